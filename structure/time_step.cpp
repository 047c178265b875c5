// One window of the structure under a constant load: sub-steps of velocity Verlet (kick, drift, forces, kick), or implicit
// steps (implicit_step.cpp). The page to read first; each call is one equation, in the file of its name.

#include "structure/time_step.hpp"

#include "structure/implicit/implicit_step.hpp"
#include "structure/shell/shell_body.hpp"

namespace tern::structure {

template <int D>
void internal_forces(const Reference<D>& reference, double time_s, State<D>& state, Workspace<D>& work) {
  deformation_gradient(reference, state, work);           // F_i, K_i, and l_i for the reconstruction
  first_piola_kirchhoff(reference, state, time_s, work);  // P, Q of W(F, K)
  diffusion_force(reference, state, work);                // Riemann diffusion
  elastic_force(reference, work, state);                  // -dE/dx of sum V W(F, K)
  shell_internal_forces(reference, time_s, state, work);  // the same of the layers
  work.evaluations.elastic_force += reference.rows;
  state.force_is_elastic = !reference.has_diffusion;
}

template <int D>
void verlet(const Reference<D>& reference, double begin, double duration, int sub_steps, State<D>& state, Workspace<D>& work) {
  const double dt = duration / sub_steps;
  for (int n = 0; n < sub_steps; ++n) {
    // The kick that ends a sub-step and the one that begins the next are the same force for half a step each.
    kick(reference, n == 0 ? 0.5 * dt : dt, state);
    aim_clamps(reference, begin + (n + 1) * dt, dt, state);
    drift(reference, dt, state);
    state.clamp_work += 0.5 * dt * clamp_power(reference, state, work);  // by the forces at the begin of the drift
    internal_forces(reference, begin + (n + 1) * dt, state, work);
    state.clamp_work += 0.5 * dt * clamp_power(reference, state, work);  // and at its end
  }
  kick(reference, 0.5 * dt, state);
}

namespace {

/// One implicit step that stands for `sub_steps` explicit ones; failing that, two of half its length, and at last those. The load is one
/// for the whole window: what moves faster than the windows is not resolved by them, however many steps they have.
template <int D>
void implicit_or_explicit(const Reference<D>& reference, double begin, double duration, int sub_steps, ImplicitStep<D>& implicit,
                          State<D>& state, Workspace<D>& work) {
  if (implicit.advance(reference, begin, duration, state, work)) return;
  if (sub_steps > least_implicit_ratio) {
    const int half = (sub_steps + 1) / 2;
    implicit_or_explicit(reference, begin, 0.5 * duration, half, implicit, state, work);
    implicit_or_explicit(reference, begin + 0.5 * duration, 0.5 * duration, half, implicit, state, work);
    return;
  }
  internal_forces(reference, begin, state, work);
  verlet(reference, begin, duration, sub_steps, state, work);
}

}  // namespace

template <int D>
void advance_window(const Reference<D>& reference, Ticks duration, int sub_steps, ImplicitStep<D>* implicit, State<D>& state,
                    Workspace<D>& work) {
  if (implicit == nullptr) {
    verlet(reference, seconds(state.time), seconds(duration), sub_steps, state, work);
  } else {
    implicit_or_explicit(reference, seconds(state.time), seconds(duration), sub_steps, *implicit, state, work);
  }
  state.time += duration;
}

template void internal_forces<2>(const Reference<2>&, double, State<2>&, Workspace<2>&);
template void internal_forces<3>(const Reference<3>&, double, State<3>&, Workspace<3>&);
template void verlet<2>(const Reference<2>&, double, double, int, State<2>&, Workspace<2>&);
template void verlet<3>(const Reference<3>&, double, double, int, State<3>&, Workspace<3>&);
template void advance_window<2>(const Reference<2>&, Ticks, int, ImplicitStep<2>*, State<2>&, Workspace<2>&);
template void advance_window<3>(const Reference<3>&, Ticks, int, ImplicitStep<3>*, State<3>&, Workspace<3>&);

}  // namespace tern::structure
