#include "fluid/gauges/totals.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"

namespace tern::fluid {

template <class V>
double largest_speed(const std::vector<V>& velocity) {
  return std::sqrt(
      ordered_max(static_cast<std::ptrdiff_t>(velocity.size()), 0.0, [&](std::ptrdiff_t i) { return velocity[i].squaredNorm(); }));
}

template <int D>
double largest_bulk_speed(const State<D>& state) {
  return std::sqrt(ordered_max(static_cast<std::ptrdiff_t>(state.size()), 0.0,
                               [&](std::ptrdiff_t i) { return state.particle_class[i].spray() ? 0.0 : state.velocity[i].squaredNorm(); }));
}

template <int D>
double kinetic_energy(double mass, const State<D>& state) {
  return ordered_reduce(static_cast<std::ptrdiff_t>(state.size()), 0.0,
                        [&](std::ptrdiff_t i) { return 0.5 * mass * state.velocity[i].squaredNorm(); });
}

template <int D>
Vector<D> momentum(double mass, const State<D>& state) {
  return ordered_reduce(static_cast<std::ptrdiff_t>(state.size()), Vector<D>(Vector<D>::Zero()),
                        [&](std::ptrdiff_t i) { return Vector<D>(mass * state.velocity[i]); });
}

template <int D>
Vector<3> angular_momentum(double mass, const State<D>& state) {
  return ordered_reduce(static_cast<std::ptrdiff_t>(state.size()), Vector<3>(Vector<3>::Zero()), [&](std::ptrdiff_t i) {
    Vector<3> x = Vector<3>::Zero(), u = Vector<3>::Zero();
    for (int c = 0; c < D; ++c) x[c] = state.position[i][c], u[c] = state.velocity[i][c];
    return Vector<3>(mass * x.cross(u));
  });
}

template <int D>
VolumeDrift volume_drift(const Constants<D>& constants, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                         const Corrections<D>& correction, const State<D>& state) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < correction.trace.size(); ++i) {
    if (i >= state.size() || !state.particle_class[i].interior() || correction.trace[i] < 0.925) continue;
    sum += (neighbours.number_density[i] + boundary.sums.number_density[i]) / constants.lattice.density;
    ++count;
  }
  if (count == 0) return {};
  return {static_cast<double>(count) / sum - 1, static_cast<double>(count) / static_cast<double>(state.size())};
}

template <int D>
std::size_t spray_particles(const State<D>& state) {
  return static_cast<std::size_t>(
      std::count_if(state.particle_class.begin(), state.particle_class.end(), [](ParticleClass own) { return own.spray(); }));
}

#define TERN_INSTANTIATE(D)                                                                                                  \
  template double largest_speed(const std::vector<Vector<D>>&);                                                              \
  template double largest_bulk_speed<D>(const State<D>&);                                                                    \
  template double kinetic_energy<D>(double, const State<D>&);                                                                \
  template Vector<D> momentum<D>(double, const State<D>&);                                                                   \
  template Vector<3> angular_momentum<D>(double, const State<D>&);                                                           \
  template VolumeDrift volume_drift<D>(const Constants<D>&, const Neighbours<D>&, const Boundary<D>&, const Corrections<D>&, \
                                       const State<D>&);                                                                     \
  template std::size_t spray_particles<D>(const State<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
