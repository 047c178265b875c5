// Velocity Verlet:  v += dt (f_internal + f_external)/m,   d += dt v.
// Clamped rows and rows without particle have 1/m = 0: they keep their velocity of zero.

#include "structure/time_step.hpp"

namespace tern::structure {

template <int D>
void kick(const Reference<D>& reference, const Workspace<D>& work, double dt, State<D>& state) {
  const auto rows = static_cast<std::ptrdiff_t>(reference.rows);
  const double* inverse_mass = reference.inverse_mass.data();
  for (int a = 0; a < D; ++a) {
    double* v = state.velocity[a].data();
    const double* internal = state.internal_force[a].data();
    const double* external = work.external_force[a].data();
#pragma omp parallel for simd schedule(static) if (rows > lane_count * parallel_blocks)
    for (std::ptrdiff_t i = 0; i < rows; ++i) v[i] += dt * inverse_mass[i] * (internal[i] + external[i]);
  }
}

template <int D>
void drift(const Reference<D>& reference, double dt, State<D>& state) {
  const auto rows = static_cast<std::ptrdiff_t>(reference.rows);
  for (int a = 0; a < D; ++a) {
    double* d = state.displacement[a].data();
    const double* v = state.velocity[a].data();
#pragma omp parallel for simd schedule(static) if (rows > lane_count * parallel_blocks)
    for (std::ptrdiff_t i = 0; i < rows; ++i) d[i] += dt * v[i];
  }
}

template void kick<2>(const Reference<2>&, const Workspace<2>&, double, State<2>&);
template void kick<3>(const Reference<3>&, const Workspace<3>&, double, State<3>&);
template void drift<2>(const Reference<2>&, double, State<2>&);
template void drift<3>(const Reference<3>&, double, State<3>&);

}  // namespace tern::structure
