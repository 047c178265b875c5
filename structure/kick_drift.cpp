// Velocity Verlet:  v += dt (f_internal + f_external)/m,   d += dt v.
// Clamped rows and rows without particle have 1/m = 0: they keep their velocity of zero.

#include "structure/time_step.hpp"

namespace tern::structure {

template <int D>
void kick(const Reference<D>& reference, const Workspace<D>& work, double dt, State<D>& state) {
  for_each_block(static_cast<std::ptrdiff_t>(reference.blocks.size()), [&](std::ptrdiff_t n) {
    const std::ptrdiff_t i = reference.blocks[n].row;
    const Lanes factor = dt * load(reference.inverse_mass.data() + i);
    for (int a = 0; a < D; ++a) {
      double* v = state.velocity[a].data() + i;
      store(v, load(v) + factor * (load(state.internal_force[a].data() + i) + load(work.external_force[a].data() + i)));
    }
  });
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
}

template void kick<2>(const Reference<2>&, const Workspace<2>&, double, State<2>&);
template void kick<3>(const Reference<3>&, const Workspace<3>&, double, State<3>&);
template void drift<2>(const Reference<2>&, double, State<2>&);
template void drift<3>(const Reference<3>&, double, State<3>&);

}  // namespace tern::structure
