#include "scene/gauges.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tern {

GaugeOwner owner(const GaugeCase& gauge) { return gauge_definition(gauge.kind).owner; }

std::uint32_t body_index(const GaugeCase& gauge, const Case& scene) {
  std::uint32_t index = 0;
  while (scene.structure->bodies[index].name != gauge.text("body")) ++index;
  return index;
}

Upward upward(const Case& scene) {
  constexpr int instants = 200;
  std::array<double, 3> at{}, sum{};
  for (int d = 0; d < scene.dimension; ++d) at[d] = 0.5 * (scene.domain_min[d] + scene.domain_max[d]);
  for (int n = 0; n <= instants; ++n)
    for (int d = 0; d < scene.dimension; ++d) sum[d] += scene.gravity[d](n * scene.end_time / instants, at[0], at[1], at[2]);
  Upward up;
  for (int d = 0; d < scene.dimension; ++d)
    if (std::abs(sum[d]) > std::abs(sum[up.axis])) up.axis = d;
  if (sum[up.axis] > 0) up.sense = -1;
  return up;
}

std::vector<std::string> gauge_columns(const GaugeCase& gauge, int dimension) {
  std::vector<std::string> columns;
  for (const std::string& column : gauge_definition(gauge.kind).columns(dimension)) columns.push_back(gauge.name + "." + column);
  return columns;
}

std::vector<std::string> gauge_columns(const Case& scene, GaugeOwner who) {
  std::vector<std::string> all;
  for (const GaugeCase& gauge : scene.gauges)
    if (owner(gauge) == who)
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
  std::vector<std::string> columns{"structure_kinetic_J", "structure_strain_J", "structure_potential_J", "structure_diffusion_J",
                                   "interface_work_on_structure_J"};
  if (has_structure_loads(*scene.structure))
    columns.insert(columns.end(), {"structure_damping_J", "load_work_on_structure_J", "clamp_work_on_structure_J"});
  return columns;
}

}  // namespace tern
