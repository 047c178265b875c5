#pragma once
// The fluid as the frame of its process sees it (run/process_output.hpp).

#include <vector>

#include "fluid/process/output.hpp"

namespace tern::fluid {

template <int D>
class FluidSide {
 public:
  static constexpr const char* role = "fluid";

  FluidSide(const Case& scene, const Fluid<D>& fluid) : scene_(scene), fluid_(fluid) {}

  Ticks time() const { return fluid_.state().time; }
  GaugeValues gauges() const { return gauge_values(fluid_, scene_); }
  std::vector<double> energies() const { return energy_values(fluid_); }
  void write_frame(FrameWriter& frames, long step) const { fluid::write_frame(fluid_, frames, step); }
  void add_window() { measures_.add(fluid_); }
  void report(RunReport& report) const { measures_.report(fluid_, report); }

  /// The list of what add_window() has gathered: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("fluid", all.measures_...);
  }

 private:
  const Case& scene_;
  const Fluid<D>& fluid_;
  Measures<D> measures_;
};

}  // namespace tern::fluid
