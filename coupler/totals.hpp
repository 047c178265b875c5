#pragma once
// Sums over a run of what the windows did.

#include <string>
#include <vector>

#include "coupler/audit.hpp"

namespace tern::coupler {

struct Totals {
  double work_on_fluid = 0, riemann = 0, mitigation = 0, contact = 0;
  double largest_force_error = 0, largest_moment_error = 0;
  double impulse_sum = 0, impulse_size = 0;
  long windows = 0, contacts = 0, wet_windows = 0, iterations = 0, open_windows = 0;
  int most_iterations = 0;

  /// A window of this length [s].
  void add(const WindowAudit& audit, int iterations_of_window, bool agreed, double duration);

  /// Columns of energy.csv. The last is the work on both sides together: what the interface made or took because the fluid has seen
  /// another motion of the surface than the one that came about.
  static std::vector<std::string> columns();
  std::vector<double> energies(double work_on_structure) const;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("work_on_fluid", all.work_on_fluid...);
    visit("riemann", all.riemann...);
    visit("mitigation", all.mitigation...);
    visit("contact", all.contact...);
    visit("largest_force_error", all.largest_force_error...);
    visit("largest_moment_error", all.largest_moment_error...);
    visit("impulse_sum", all.impulse_sum...);
    visit("impulse_size", all.impulse_size...);
    visit("windows", all.windows...);
    visit("contacts", all.contacts...);
    visit("wet_windows", all.wet_windows...);
    visit("iterations", all.iterations...);
    visit("open_windows", all.open_windows...);
    visit("most_iterations", all.most_iterations...);
  }
};

}  // namespace tern::coupler
