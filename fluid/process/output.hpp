#pragma once
// What the fluid process reports: energies, frames, measures; its gauges are in fluid/gauges/.

#include "fluid/fluid.hpp"
#include "fluid/gauges/gauges.hpp"
#include "run/frame_writer.hpp"
#include "run/run_report.hpp"

namespace tern::fluid {

template <int D>
std::vector<double> energy_values(const Fluid<D>& fluid);

/// Appends the present state, particles in the order of their labels.
template <int D>
void write_frame(const Fluid<D>& fluid, FrameWriter& frames, long step);

/// Follows a run for its report.
template <int D>
class Measures {
 public:
  /// After each window.
  void add(const Fluid<D>& fluid);
  void report(const Fluid<D>& fluid, RunReport& report) const;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("steps", all.steps_...);
    visit("iterations", all.iterations_...);
    visit("most_iterations", all.most_iterations_...);
    visit("drift", all.drift_...);
    visit("largest_drift", all.largest_drift_...);
    visit("largest_speed", all.largest_speed_...);
    visit("first_angular_momentum", all.first_angular_momentum_...);
  }

 private:
  long steps_ = 0, iterations_ = 0;
  int most_iterations_ = 0;
  double drift_ = 0, largest_drift_ = 0, largest_speed_ = 0;
  Vector<3> first_angular_momentum_ = Vector<3>::Zero();
};

}  // namespace tern::fluid
