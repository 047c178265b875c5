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
};

}  // namespace tern::coupler
