#pragma once
// The structure as the frame of its process sees it (run/process_output.hpp).

#include <vector>

#include "structure/process/output.hpp"

namespace tern::structure {

template <int D>
class StructureSide {
 public:
  static constexpr const char* role = "structure";

  StructureSide(const Case& scene, const Structure<D>& structure) : scene_(scene), structure_(structure), gauges_(scene, structure) {}

  Ticks time() const { return structure_.time(); }
  GaugeValues gauges() const { return gauges_.values(structure_); }
  std::vector<double> energies() const { return energy_values(scene_, structure_); }
  void write_frame(FrameWriter& frames, long step) const { structure::write_frame(structure_, frames, step); }
  void add_window() { measures_.add(structure_); }
  void report(RunReport& report) const { measures_.report(scene_, structure_, report); }

  /// The list of what add_window() has gathered: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("structure", all.measures_...);
  }

 private:
  const Case& scene_;
  const Structure<D>& structure_;
  StructureGauges<D> gauges_;
  Measures measures_;
};

}  // namespace tern::structure
