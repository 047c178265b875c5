#include "scene/gauges.hpp"

#include <algorithm>

namespace tern {
namespace {

constexpr const char* axis[] = {"x", "y", "z"};

}  // namespace

GaugeOwner owner(GaugeCase::Kind kind) {
  switch (kind) {
    case GaugeCase::Kind::displacement:
    case GaugeCase::Kind::reaction: return GaugeOwner::structure;
    case GaugeCase::Kind::interface_force: return GaugeOwner::coupler;
    case GaugeCase::Kind::pressure:
    case GaugeCase::Kind::elevation:
    case GaugeCase::Kind::front:
    case GaugeCase::Kind::force:
    case GaugeCase::Kind::wall_pressure:
    case GaugeCase::Kind::flux: break;
  }
  return GaugeOwner::fluid;
}

std::vector<std::string> gauge_columns(const GaugeCase& gauge, int dimension) {
  std::vector<std::string> columns;
  switch (gauge.kind) {
    case GaugeCase::Kind::displacement:
      for (int c = 0; c < dimension; ++c) columns.push_back(gauge.name + ".u" + axis[c] + "_m");
      break;
    case GaugeCase::Kind::interface_force:
      for (int c = 0; c < dimension; ++c) columns.push_back(gauge.name + ".F" + axis[c] + (dimension == 2 ? "_N_per_m" : "_N"));
      break;
    case GaugeCase::Kind::force:
    case GaugeCase::Kind::reaction:
      for (int c = 0; c < dimension; ++c) columns.push_back(gauge.name + ".F" + axis[c] + (dimension == 2 ? "_N_per_m" : "_N"));
      if (dimension == 2) columns.push_back(gauge.name + ".Mz_Nm_per_m");
      for (int c = 0; dimension == 3 && c < 3; ++c) columns.push_back(gauge.name + ".M" + axis[c] + "_Nm");
      break;
    case GaugeCase::Kind::pressure:
    case GaugeCase::Kind::wall_pressure: columns.push_back(gauge.name + ".p_Pa"); break;
    case GaugeCase::Kind::flux: columns.push_back(gauge.name + (dimension == 2 ? ".Q_m2_per_s" : ".Q_m3_per_s")); break;
    case GaugeCase::Kind::elevation: columns.push_back(gauge.name + ".eta_m"); break;
    case GaugeCase::Kind::front: columns.push_back(gauge.name + ".x_m"); break;
  }
  return columns;
}

std::vector<std::string> gauge_columns(const Case& scene, GaugeOwner who) {
  std::vector<std::string> all;
  for (const GaugeCase& gauge : scene.gauges)
    if (owner(gauge.kind) == who)
      for (std::string& column : gauge_columns(gauge, scene.dimension)) all.push_back(std::move(column));
  return all;
}

std::vector<std::string> fluid_energy_columns() { return {"fluid_kinetic_J", "fluid_potential_J"}; }

bool has_structure_loads(const StructureCase& structure) {
  return !structure.loads.empty() ||
         std::any_of(structure.clamps.begin(), structure.clamps.end(), [](const auto& c) { return c.motion.has_value(); }) ||
         std::any_of(structure.bodies.begin(), structure.bodies.end(), [](const auto& b) { return b.mass_damping > 0; });
}

std::vector<std::string> structure_energy_columns(const Case& scene) {
  std::vector<std::string> columns{"structure_kinetic_J",   "structure_strain_J",  "structure_potential_J",
                                   "structure_diffusion_J", "structure_penalty_J", "interface_work_on_structure_J"};
  if (has_structure_loads(*scene.structure))
    columns.insert(columns.end(), {"structure_damping_J", "load_work_on_structure_J", "clamp_work_on_structure_J"});
  return columns;
}

}  // namespace tern
