// Velocity Verlet:  v += dt (f_internal + f_external)/m,   d += dt v.
// Clamped rows and rows without particle have 1/m = 0: they keep the velocity they are given.
// The energy that the diffusion takes in a kick is its power in the middle of it.
// Mass damping alpha (the first term of Rayleigh's) decays the velocity by exp(-alpha dt) in the same kick.

#include <cmath>

#include "structure/shell/shell_body.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {

template <int D>
void kick(const Reference<D>& reference, double dt, State<D>& state) {
  for_each_block(static_cast<std::ptrdiff_t>(reference.blocks.size()), [&](std::ptrdiff_t n) {
    const Block& block = reference.blocks[n];
    const std::ptrdiff_t i = block.row;
    const Lanes inverse_mass = load(reference.inverse_mass.data() + i);
    const double damping = reference.bodies[block.body].mass_damping;
    if (damping > 0) {
      const double decay = std::exp(-damping * dt);
      const Lanes one = broadcast(1), factor = inverse_mass > Lanes{} ? broadcast(decay) : one;
      Lanes lost = {};
      for (int a = 0; a < D; ++a) {
        double* v = state.velocity[a].data() + i;
        const Lanes before = load(v);
        lost += before * before * (1 - factor * factor);
        store(v, factor * before);
      }
      state.damping_loss[n] += 0.5 * load(reference.mass.data() + i) * lost;
      state.diffusion_power[n] *= decay;
    }
    if (reference.has_diffusion) {
      state.diffusion_loss[n] += dt * (state.diffusion_power[n] - 0.5 * dt * state.diffusion_brake[n]);
      state.diffusion_power[n] -= dt * state.diffusion_brake[n];
    }
    for (int a = 0; a < D; ++a) {
      double* v = state.velocity[a].data() + i;
      store(v, load(v) + dt * inverse_mass * (load(state.internal_force[a].data() + i) + load(state.external_force[a].data() + i)));
    }
  });
}

template <int D>
void aim_clamps(const Reference<D>& reference, double end, double dt, State<D>& state) {
  for (std::size_t c = 0; c < reference.clamps.size(); ++c) {
    const Clamp& clamp = reference.clamps[c];
    if (!clamp.motion) continue;
    const auto place = placement<D>(*clamp.motion, end);
    state.clamp_spin[c] = (place.angle - state.clamp_angle[c]) / dt;
    for (const auto row : clamp.row) {
      const Vector<D> x = reference.position_of(row), d = place(x) - x;
      for (int a = 0; a < D; ++a) state.velocity[a][row] = (d[a] - state.displacement[a][row]) / dt;
    }
  }
}

template <int D>
void drift(const Reference<D>& reference, double dt, State<D>& state) {
  for_each_block(static_cast<std::ptrdiff_t>(reference.blocks.size()), [&](std::ptrdiff_t n) {
    const std::ptrdiff_t i = reference.blocks[n].row;
    for (int a = 0; a < D; ++a) {
      double* d = state.displacement[a].data() + i;
      store(d, load(d) + dt * load(state.velocity[a].data() + i));
    }
  });
  for (std::size_t c = 0; c < state.clamp_angle.size(); ++c) state.clamp_angle[c] += dt * state.clamp_spin[c];
}

template <int D>
double clamp_power(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work) {
  double power = shell_clamp_power(reference, work);
  for (const Clamp& clamp : reference.clamps) {
    if (!clamp.motion) continue;
    for (const auto row : clamp.row)
      for (int a = 0; a < D; ++a) power -= state.internal_force[a][row] * state.velocity[a][row];
  }
  return power;
}

template double clamp_power<2>(const Reference<2>&, const State<2>&, const Workspace<2>&);
template double clamp_power<3>(const Reference<3>&, const State<3>&, const Workspace<3>&);
template void kick<2>(const Reference<2>&, double, State<2>&);
template void kick<3>(const Reference<3>&, double, State<3>&);
template void aim_clamps<2>(const Reference<2>&, double, double, State<2>&);
template void aim_clamps<3>(const Reference<3>&, double, double, State<3>&);
template void drift<2>(const Reference<2>&, double, State<2>&);
template void drift<3>(const Reference<3>&, double, State<3>&);

}  // namespace tern::structure
