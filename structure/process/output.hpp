#pragma once
// What the structure process reports: energies, frames, measures; its gauges are in structure/gauges/.

#include <algorithm>
#include <array>
#include <vector>

#include "run/frame_writer.hpp"
#include "run/run_report.hpp"
#include "structure/gauges/gauges.hpp"
#include "structure/structure.hpp"

namespace tern::structure {

/// In the order of structure_energy_columns(scene).
template <int D>
std::vector<double> energy_values(const Case& scene, const Structure<D>& structure);

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
    if (++windows_ == 1) first_angular_momentum_ = structure.momentum().angular;
  }
  template <int D>
  void report(const Case& scene, const Structure<D>& structure, RunReport& report) const {
    report.set_count("particles", static_cast<long>(structure.particles()));
    report.set_count("surface_points", static_cast<long>(structure.surface_points()));
    report.set_count("sub_steps", sub_steps_);
    const Evaluations& evaluations = structure.evaluations();
    report.set_evaluations("elastic_force", evaluations.elastic_force);
    report.set_evaluations("riemann_diffusion", evaluations.riemann_diffusion);
    report.set_evaluations("loads", evaluations.loads);
    report.set_evaluations("moving_clamps", evaluations.moving_clamps);
    report.set_count("windows_at_rest", evaluations.windows_at_rest);
    if (windows_ > 0) report.set_measure("sub_steps_mean", static_cast<double>(sub_steps_) / static_cast<double>(windows_));
    const Eigen::Map<const Vector<3>> first(first_angular_momentum_.data());
    if (!moves_alone(scene) || first.norm() == 0) return;
    const std::array<double, 3> last = structure.momentum().angular;  // against that after the first window
    report.set_measure("structure_angular_momentum_change", (Eigen::Map<const Vector<3>>(last.data()) - first).norm() / first.norm());
  }

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("sub_steps", all.sub_steps_...);
    visit("windows", all.windows_...);
    visit("first_angular_momentum", all.first_angular_momentum_...);
  }

 private:
  /// Nothing acts on the bodies from outside.
  static bool moves_alone(const Case& scene) {
    const auto is_zero = [](const Expression& value) { return value.is_constant() && value(0) == 0; };
    return !scene.fluid && scene.structure->loads.empty() && std::all_of(scene.gravity.begin(), scene.gravity.end(), is_zero) &&
           std::all_of(scene.structure->bodies.begin(), scene.structure->bodies.end(),
                       [](const StructureBody& body) { return body.clamps.empty() && body.mass_damping == 0; });
  }

  long sub_steps_ = 0, windows_ = 0;
  std::array<double, 3> first_angular_momentum_{};
};

}  // namespace tern::structure
