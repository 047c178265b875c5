#include "coupler/totals.hpp"

#include <algorithm>

namespace tern::coupler {

void Totals::add(const WindowAudit& audit, int iterations_of_window, bool agreed, double duration) {
  ++windows;
  work_on_fluid += audit.work_on_fluid;
  riemann += audit.riemann_dissipation;
  mitigation += audit.mitigation_dissipation;
  contact += audit.contact_dissipation;
  contacts += audit.contacts;
  wet_windows += audit.pairs > 0;
  iterations += iterations_of_window;
  most_iterations = std::max(most_iterations, iterations_of_window);
  open_windows += !agreed;
  largest_force_error = std::max(largest_force_error, audit.force_error);
  largest_moment_error = std::max(largest_moment_error, audit.moment_error);
  impulse_sum += audit.force_sum * duration;
  impulse_size += audit.force_size * duration;
}

std::vector<std::string> Totals::columns() {
  return {"interface_work_on_fluid_J", "riemann_dissipation_J", "vem_dissipation_J", "contact_dissipation_J", "interface_staggering_J"};
}

std::vector<double> Totals::energies(double work_on_structure) const {
  return {work_on_fluid, riemann, mitigation, contact, work_on_structure + work_on_fluid};
}

}  // namespace tern::coupler
