#include "fluid/process/output.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace tern::fluid {

template <int D>
std::vector<double> energy_values(const Fluid<D>& fluid) {
  const Energies energies = fluid.energies();
  return {energies.kinetic, energies.potential};
}

/// As frames hold them; of a class: 0 interior, 1 free surface, 2 spray.
std::vector<std::uint32_t> numbers(std::vector<std::uint32_t> values) { return values; }
std::vector<std::uint32_t> numbers(const std::vector<ParticleClass>& values) {
  std::vector<std::uint32_t> result(values.size());
  std::transform(values.begin(), values.end(), result.begin(), [](ParticleClass own) {
    return own.spray() ? 2 : own.free_surface() ? 1 : 0;
  });
  return result;
}

/// Of each moving wall, in the order of the case: where its points are that were at t = 0 at the origin and 1 m from it along each axis.
template <int D>
std::vector<Vector<D>> wall_places(const std::vector<Wall<D>>& walls, double t) {
  std::vector<Vector<D>> places;
  for (const Wall<D>& wall : walls) {
    if (!wall.scene.motion) continue;
    const Placement<D> place = placement<D>(wall.scene, t);
    places.push_back(place(Vector<D>::Zero()));
    for (int d = 0; d < D; ++d) places.push_back(place(Vector<D>::Unit(d)));
  }
  return places;
}

template <int D>
void write_frame(const Fluid<D>& fluid, FrameWriter& frames, long step) {
  const State<D>& state = fluid.state();
  std::vector<std::size_t> order(state.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return state.id[a] < state.id[b]; });
  const auto sorted = [&](const auto& values) {
    auto result = values;
    for (std::size_t k = 0; k < order.size(); ++k) result[k] = values[order[k]];
    return result;
  };
  frames.begin(seconds(state.time), step);
  for_each_particle_field(state, [&]<class T>(const char* name, const char* unit, const std::vector<T>& values) {
    if (unit == nullptr) return;
    if constexpr (std::is_same_v<T, Vector<D>>)
      frames.vector<D>(name, unit, sorted(values));
    else if constexpr (std::is_same_v<T, double>)
      frames.scalar(name, unit, sorted(values));
    else
      frames.integer(name, std::span<const std::uint32_t>(numbers(sorted(values))));
  });
  const std::vector<Vector<D>> places = wall_places(fluid.boundary().walls.all(), seconds(state.time));
  if (!places.empty()) frames.side_vector<D>("wall_place", "m", places);
  frames.end();
}

template <int D>
void Measures<D>::add(const Fluid<D>& fluid) {
  ++steps_;
  iterations_ += fluid.last_solve().iterations;
  most_iterations_ = std::max(most_iterations_, fluid.last_solve().iterations);
  if (steps_ == 1) first_angular_momentum_ = fluid.angular_momentum();
  largest_speed_ = std::max(largest_speed_, fluid.largest_speed());
  drift_ = fluid.volume_drift().inside;
  if (std::abs(drift_) > std::abs(largest_drift_)) largest_drift_ = drift_;
}

template <int D>
void Measures<D>::report(const Fluid<D>& fluid, RunReport& report) const {
  report.set_count("particles", static_cast<long>(fluid.particles()));
  report.set_count("particles_leaked", static_cast<long>(fluid.leaked()));
  report.set_count("particles_removed", static_cast<long>(fluid.removed()));
  report.set_count("spray_particles", static_cast<long>(fluid.spray_particles()));
  report.set_count("fallback_solves", fluid.fallback_solves());
  report.set_measure("pressure_iterations_mean", steps_ ? double(iterations_) / double(steps_) : 0);
  report.set_measure("pressure_iterations_max", most_iterations_);
  report.set_measure("volume_drift", drift_);
  report.set_measure("volume_drift_largest", largest_drift_);
  // Since the first step; without a spin at the start there is nothing to compare with.
  if (const double first = first_angular_momentum_.norm(); first > 0)
    report.set_measure("angular_momentum_change", (fluid.angular_momentum() - first_angular_momentum_).norm() / first);
  report.set_measure("largest_speed_m_per_s", fluid.largest_speed());
  report.set_measure("largest_speed_of_run_m_per_s", largest_speed_);
  if (!fluid.domain().alone()) {
    report.set_count("ranks", fluid.domain().ranks().count());
    report.set_measure("rank_imbalance", fluid.domain().imbalance());
    report.set_measure("ghost_share", fluid.ghost_share());
    fluid.for_each_traffic([&](const char* name, double value) { report.set_measure(fmt::format("{}_per_step", name), value); });
  }
  if (fluid.sealed().any) {
    report.set_measure(D == 2 ? "sealed_flux_removed_m2_per_s" : "sealed_flux_removed_m3_per_s", fluid.sealed().largest_flux);
    report.set_measure("sealed_volume_error", fluid.sealed().volume_error);
  }
  const Evaluations evaluations = fluid.evaluations();
  report.set_evaluations("viscosity", evaluations.viscosity);
  report.set_evaluations("noise_damping", evaluations.noise_damping);
  report.set_evaluations("density_source", evaluations.density_source);
  report.set_evaluations("shifting", evaluations.shifting);
  report.set_evaluations("moving_walls", evaluations.moving_walls);
  report.set_evaluations("structure_surface", evaluations.structure_surface);
  const StepTiming& timing = fluid.timing();
  report.timing("compute.neighbours") = timing.neighbours;
  report.timing("compute.boundary") = timing.boundary;
  report.timing("compute.assembly") = timing.assembly;
  report.timing("compute.pressure_solve") = timing.pressure_solve;
  report.timing("compute.correction") = timing.correction;
}

#define TERN_INSTANTIATE(D)                                          \
  template std::vector<double> energy_values<D>(const Fluid<D>&);    \
  template void write_frame<D>(const Fluid<D>&, FrameWriter&, long); \
  template class Measures<D>;
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
