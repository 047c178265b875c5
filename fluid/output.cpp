#include "fluid/output.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tern::fluid {

template <int D>
GaugeValues gauge_values(const Fluid<D>& fluid, const Case& scene) {
  GaugeValues values;
  for (const GaugeCase& gauge : scene.gauges) {
    Vector<D> at;
    for (int c = 0; c < D; ++c) at[c] = gauge.at[c];
    if (gauge.kind == GaugeCase::Kind::pressure) values.push_back(fluid.pressure_at(at));
    if (gauge.kind == GaugeCase::Kind::elevation) values.push_back(fluid.elevation_at(at));
    if (gauge.kind == GaugeCase::Kind::front) values.push_back(fluid.front());
  }
  return values;
}

template <int D>
std::vector<double> energy_values(const Fluid<D>& fluid) {
  const Energies energies = fluid.energies();
  return {energies.kinetic, energies.potential};
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
  std::vector<std::uint32_t> flag(state.size());
  for (std::size_t k = 0; k < order.size(); ++k) flag[k] = static_cast<std::uint32_t>(fluid.flags()[order[k]]);
  frames.begin(seconds(state.time), step);
  frames.vector<D>("position", "m", sorted(state.position));
  frames.vector<D>("velocity", "m/s", sorted(state.velocity));
  frames.scalar("pressure", "Pa", sorted(state.pressure));
  frames.integer("id", std::span<const std::uint32_t>(sorted(state.id)));
  frames.integer("flag", std::span<const std::uint32_t>(flag));
  frames.end();
}

template <int D>
void Measures<D>::add(const Fluid<D>& fluid) {
  ++steps_;
  iterations_ += fluid.last_solve().iterations;
  most_iterations_ = std::max(most_iterations_, fluid.last_solve().iterations);
  const double drift = fluid.volume_drift();
  if (std::abs(drift) > std::abs(largest_drift_)) largest_drift_ = drift;
}

template <int D>
void Measures<D>::report(const Fluid<D>& fluid, RunReport& report) const {
  report.set_count("particles", static_cast<long>(fluid.state().size()));
  report.set_count("particles_leaked", static_cast<long>(fluid.leaked()));
  report.set_count("particles_removed", static_cast<long>(fluid.removed()));
  report.set_count("spray_particles", static_cast<long>(fluid.spray_particles()));
  report.set_count("fallback_solves", fluid.fallback_solves());
  report.set_measure("pressure_iterations_mean", steps_ ? double(iterations_) / double(steps_) : 0);
  report.set_measure("pressure_iterations_max", most_iterations_);
  report.set_measure("volume_drift", fluid.volume_drift());
  report.set_measure("volume_drift_largest", largest_drift_);
  report.set_measure("largest_speed_m_per_s", fluid.largest_speed());
  const StepTiming& timing = fluid.timing();
  report.timing("compute.neighbours") = timing.neighbours;
  report.timing("compute.boundary") = timing.boundary;
  report.timing("compute.assembly") = timing.assembly;
  report.timing("compute.pressure_solve") = timing.pressure_solve;
  report.timing("compute.correction") = timing.correction;
}

#define TERN_INSTANTIATE(D)                                              \
  template GaugeValues gauge_values<D>(const Fluid<D>&, const Case&);    \
  template std::vector<double> energy_values<D>(const Fluid<D>&);        \
  template void write_frame<D>(const Fluid<D>&, FrameWriter&, long);     \
  template class Measures<D>;
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
