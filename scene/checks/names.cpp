// Names of walls, bodies, clamps, loads and gauges.

#include "scene/checks/checks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

namespace tern {

void check_names(const Setting& settings) {
  for (const std::string table : {"wall", "gauge", "structure.body", "structure.clamp", "structure.load"}) {
    const Setting* list = settings.find(table.substr(0, table.find('.')));
    if (list && table.find('.') != std::string::npos) list = list->find(table.substr(table.find('.') + 1));
    if (!list) continue;
    std::set<std::string> seen;
    for (const Setting& item : list->items) {
      const std::string& name = item.at("name").text;
      if (name.find_first_of(",\"\n\r") != std::string::npos) {
        fail_at(item.at("name").where, fmt::format("the name '{}' holds a comma, a quote or a line break, which would break the "
                                                   "tables; use letters, digits, '_', '.' and '-'.",
                                                   name));
      }
      if (!seen.insert(name).second) {
        fail_at(item.at("name").where, fmt::format("the name '{}' is used twice in [[{}]]; give each its own.", name, table));
      }
    }
  }
}

const StructureBody& body_named(const std::string& name, const Case& scene, const std::string& where, const std::string& what) {
  static const std::vector<StructureBody> none;
  const auto& bodies = scene.structure ? scene.structure->bodies : none;
  const auto body = std::find_if(bodies.begin(), bodies.end(), [&](const auto& b) { return b.name == name; });
  if (body != bodies.end()) return *body;
  std::vector<std::string> names;
  for (const StructureBody& known : bodies) names.push_back(known.name);
  fail_at(where, fmt::format("the {} names the elastic body '{}', but {}.", what, name,
                             names.empty() ? "the case has no [structure]" : fmt::format("there is only '{}'", fmt::join(names, "', '"))));
}

}  // namespace tern
