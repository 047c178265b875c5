#pragma once
// The fluid as the frame of its process sees it (run/process_output.hpp).

#include <vector>

#include "fluid/process/output.hpp"
#include "fluid/process/ranks.hpp"

namespace tern::fluid {

template <int D>
class FluidSide {
 public:
  static constexpr const char* role = "fluid";

  FluidSide(const Case& scene, Leader<D>& leader) : scene_(scene), fluid_(leader.fluid()), leader_(leader) {}

  Ticks time() const { return fluid_.state().time; }
  GaugeValues gauges() const {
    return look([&](const Fluid<D>& fluid) { return gauge_values(fluid, scene_); });
  }
  std::vector<double> energies() const { return energy_values(fluid_); }
  void write_frame(FrameWriter& frames, long step) const {
    look([&](const Fluid<D>& fluid) { fluid::write_frame(fluid, frames, step); });
  }
  void add_window() { measures_.add(fluid_); }
  void report(RunReport& report) const {
    measures_.report(fluid_, report);
    // The ranks are asked when their answer will be written.
    if (!fluid_.domain().alone() && (report.due() || time() >= to_ticks(scene_.end_time))) report.set_ranks(ranks());
  }

  /// The list of what add_window() has gathered: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("fluid", all.measures_...);
  }

 private:
  std::vector<RunReport::Rank> ranks() const {
    std::vector<RunReport::Rank> all;
    for (const Load& load : leader_.loads())
      all.push_back({.machine = load.machine.data(),
                     .particles = static_cast<long>(load.particles),
                     .ghosts = static_cast<long>(load.ghosts),
                     .cpu_s = load.cpu_s,
                     .waiting_s = load.waiting_s,
                     .peak_memory_bytes = static_cast<long>(load.peak_memory_bytes)});
    return all;
  }
  template <class Look>
  auto look(Look&& look) const {
    return leader_.look(look);
  }

  const Case& scene_;
  const Fluid<D>& fluid_;
  Leader<D>& leader_;
  Measures<D> measures_;
};

}  // namespace tern::fluid
