// One window of the structure: sub-steps of velocity Verlet (kick, drift, forces, kick) under a constant load. The page to
// read first; each call is one equation, in the file of its name.

#include "structure/time_step.hpp"

namespace tern::structure {

template <int D>
void advance_window(const Reference<D>& reference, Ticks duration, int sub_steps, State<D>& state, Workspace<D>& work) {
  const double dt = seconds(duration) / sub_steps;
  const double begin = seconds(state.time);
  for (int n = 0; n < sub_steps; ++n) {
    // The kick that ends a sub-step and the one that begins the next are the same force for half a step each.
    kick(reference, work, n == 0 ? 0.5 * dt : dt, state);
    drift(reference, dt, state);
    state.clamp_work += 0.5 * dt * clamp_power(reference, state);            // by the forces at the begin of the drift
    deformation_gradient(reference, state, work);                            // F_i, and L_i for the reconstruction
    first_piola_kirchhoff(reference, state, begin + (n + 1) * dt, work);     // P, Q of W(F, K)
    stabilising_forces(reference, dt, state, work);                          // Riemann diffusion, hourglass penalty
    internal_force(reference, work, state);                                  // -dE/dx of sum V W(F, K)
    state.clamp_work += 0.5 * dt * clamp_power(reference, state);            // and at its end
  }
  kick(reference, work, 0.5 * dt, state);
  state.time += duration;
}

template void advance_window<2>(const Reference<2>&, Ticks, int, State<2>&, Workspace<2>&);
template void advance_window<3>(const Reference<3>&, Ticks, int, State<3>&, Workspace<3>&);

}  // namespace tern::structure
