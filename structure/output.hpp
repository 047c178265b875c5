#pragma once
// What the structure process reports: gauges, energies, frames, measures.

#include <vector>

#include "particles/frame_writer.hpp"
#include "particles/gauges.hpp"
#include "particles/run_report.hpp"
#include "structure/structure.hpp"

namespace tern::structure {

/// The displacement gauges of a scene, found once.
template <int D>
class DisplacementGauges {
 public:
  /// Throws BadInput for a gauge outside its body.
  DisplacementGauges(const Case& scene, const Structure<D>& structure);
  GaugeValues values(const Structure<D>& structure) const;

 private:
  std::vector<MaterialPoint> points_;
};

/// In the order of structure_energy_columns().
template <int D>
std::vector<double> energy_values(const Structure<D>& structure);

/// Appends the present state.
template <int D>
void write_frame(const Structure<D>& structure, FrameWriter& frames, long step);

/// Follows a run for its report.
class Measures {
 public:
  /// After each window.
  template <int D>
  void add(const Structure<D>& structure) {
    sub_steps_ += structure.sub_steps();
    ++windows_;
  }
  template <int D>
  void report(const Structure<D>& structure, RunReport& report) const {
    report.set_count("particles", static_cast<long>(structure.particles()));
    report.set_count("surface_points", static_cast<long>(structure.surface_points()));
    report.set_count("sub_steps", sub_steps_);
    if (windows_ > 0) report.set_measure("sub_steps_mean", static_cast<double>(sub_steps_) / static_cast<double>(windows_));
  }

 private:
  long sub_steps_ = 0, windows_ = 0;
};

}  // namespace tern::structure
