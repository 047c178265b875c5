#include "scene/gauges/gauge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "scene/checks/checks.hpp"

namespace tern {

const std::vector<GaugeDefinition>& gauge_definitions() {
  static const std::vector<GaugeDefinition> definitions = [] {
    std::vector<GaugeDefinition> all;
    for (const auto& list : {structure_gauges(), fluid_gauges(), coupler_gauges()}) all.insert(all.end(), list.begin(), list.end());
    return all;
  }();
  return definitions;
}

const GaugeDefinition& gauge_definition(const std::string& kind) {
  const auto& all = gauge_definitions();
  return *std::find_if(all.begin(), all.end(), [&](const GaugeDefinition& definition) { return definition.kind == kind; });
}

void one_spacing_wide(GaugeCase& gauge, const Case& scene) {
  if (scene.fluid && !gauge.numbers.contains("diameter")) gauge.numbers["diameter"] = scene.fluid->spacing;
}

const StructureBody& body_of(const GaugeCase& gauge, const Case& scene, const std::string& where) {
  return body_named(gauge.text("body"), scene, where, "gauge '" + gauge.name + "'");
}

const WallCase& wall_of(const GaugeCase& gauge, const Case& scene, const std::string& where) {
  const auto wall = std::find_if(scene.walls.begin(), scene.walls.end(), [&](const auto& w) { return w.name == gauge.text("wall"); });
  if (wall != scene.walls.end()) return *wall;
  std::vector<std::string> names;
  for (const WallCase& known : scene.walls) names.push_back(known.name);
  fail_at(where, fmt::format("the gauge '{}' names the wall '{}', but {}.", gauge.name, gauge.text("wall"),
                             names.empty() ? "the case has no [[wall]]" : fmt::format("there is only '{}'", fmt::join(names, "', '"))));
}

double distance_from(const Shape& shape, const std::array<double, 3>& point, const Case& scene) {
  return scene.dimension == 2 ? signed_distance<2>(shape, Vector<2>(point[0], point[1]))
                              : signed_distance<3>(shape, Vector<3>(point[0], point[1], point[2]));
}

std::string place_text(const std::array<double, 3>& point, const Case& scene) {
  return fmt::format("({:.6g}) m", fmt::join(point.begin(), point.begin() + scene.dimension, ", "));
}

std::vector<std::string> component_columns(const std::string& prefix, const std::string& unit, int dimension) {
  std::vector<std::string> columns;
  for (int d = 0; d < dimension; ++d) columns.push_back(prefix + "xyz"[d] + "_" + unit);
  return columns;
}

std::vector<std::string> force_and_moment_columns(int dimension) {
  std::vector<std::string> columns = component_columns("F", dimension == 2 ? "N_per_m" : "N", dimension);
  if (dimension == 2) {
    columns.push_back("Mz_Nm_per_m");
  } else {
    for (const std::string& moment : component_columns("M", "Nm", 3)) columns.push_back(moment);
  }
  return columns;
}

}  // namespace tern
