#include "fluid/gauges/totals.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"

namespace tern::fluid {

template <class V>
double largest_speed(const std::vector<V>& velocity, const V& observer) {
  return std::sqrt(ordered_max(static_cast<std::ptrdiff_t>(velocity.size()), 0.0,
                               [&](std::ptrdiff_t i) { return (velocity[i] - observer).squaredNorm(); }));
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
Filling filling(const Constants<D>& constants, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                const Corrections<D>& correction, const State<D>& state) {
  Filling filled;
  filled.all = static_cast<double>(state.size());
  for (std::size_t i = 0; i < correction.trace.size(); ++i) {
    if (i >= state.size() || !state.particle_class[i].interior() || correction.trace[i] < 0.925) continue;
    filled.density += (neighbours.number_density[i] + boundary.sums.number_density[i]) / constants.lattice.density;
    ++filled.inside;
  }
  return filled;
}

template <int D>
std::size_t spray_particles(const State<D>& state) {
  return static_cast<std::size_t>(
      std::count_if(state.particle_class.begin(), state.particle_class.end(), [](ParticleClass own) { return own.spray(); }));
}

template <int D>
Totals<D> add_up(const Ranks& ranks, const Totals<D>& own) {
  Totals<D> all = own;
  std::vector<double> sums;
  // The same list twice: into the sums and out of them. Whole numbers below 2^53 are exact.
  const auto for_each_sum = [&](auto&& visit) {
    visit(all.kinetic), visit(all.potential), visit(all.filling.density), visit(all.filling.inside), visit(all.filling.all);
    for (int c = 0; c < D; ++c) visit(all.momentum[c]);
    for (int c = 0; c < 3; ++c) visit(all.angular_momentum[c]);
    visit(all.particles), visit(all.spray_particles), visit(all.removed), visit(all.leaked), visit(all.ghosts);
    Traffic::for_each_field([&](const char*, auto& count) { visit(count); }, all.traffic);
    Evaluations::for_each_field([&](const char*, auto& count) { visit(count); }, all.evaluations);
  };
  // Every rank has the whole surface of the structure.
  if (!ranks.first()) all.evaluations.structure_surface = 0;
  for_each_sum([&](auto& value) { sums.push_back(static_cast<double>(value)); });
  std::vector<double> most{own.largest_speed, static_cast<double>(own.particles), own.largest_in_frame};
  if (all.extent)
    for (int c = 0; c < D; ++c) most.push_back(-own.extent->low[c]), most.push_back(own.extent->high[c]);
  ranks.sum_and_most(sums, most);
  std::size_t next = 0;
  for_each_sum([&](auto& value) { value = static_cast<std::remove_reference_t<decltype(value)>>(sums[next++]); });
  all.largest_speed = most[0], all.most_particles = static_cast<std::size_t>(most[1]), all.largest_in_frame = most[2];
  if (all.extent) {
    for (int c = 0; c < D; ++c) all.extent->low[c] = -most[3 + 2 * c], all.extent->high[c] = most[4 + 2 * c];
    all.extent->largest_speed = all.largest_speed;
  }
  return all;
}

#define TERN_INSTANTIATE(D)                                                                                                           \
  template double largest_speed(const std::vector<Vector<D>>&, const Vector<D>&);                                                     \
  template double kinetic_energy<D>(double, const State<D>&);                                                                         \
  template Vector<D> momentum<D>(double, const State<D>&);                                                                            \
  template Vector<3> angular_momentum<D>(double, const State<D>&);                                                                    \
  template Filling filling<D>(const Constants<D>&, const Neighbours<D>&, const Boundary<D>&, const Corrections<D>&, const State<D>&); \
  template std::size_t spray_particles<D>(const State<D>&);                                                                           \
  template Totals<D> add_up<D>(const Ranks&, const Totals<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
