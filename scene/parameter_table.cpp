#include "scene/parameter_table.hpp"

#include <fmt/format.h>

#include "scene/keys/tables.hpp"

namespace tern {

const std::vector<TableDefinition>& table_definitions() {
  static const std::vector<TableDefinition> definitions = [] {
    std::vector<TableDefinition> all;
    for (const auto& tables :
         {scene_tables, wall_tables, fluid_tables, structure_tables, coupling_tables, gauge_tables, output_tables, shape_tables}) {
      for (TableDefinition& table : tables()) {
        for (Parameter& key : table.keys) key.table = table.path;
        all.push_back(std::move(table));
      }
    }
    return all;
  }();
  return definitions;
}

const std::vector<Parameter>& parameters() {
  static const std::vector<Parameter> list = [] {
    std::vector<Parameter> all;
    for (const TableDefinition& table : table_definitions()) all.insert(all.end(), table.keys.begin(), table.keys.end());
    return all;
  }();
  return list;
}

std::string describe(const Range& range) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const bool below = range.lowest > -infinity, over = range.highest < infinity;
  if (below && over) {
    return fmt::format("from {}{} to {}{}", range.lowest, range.lowest_excluded ? " (excluded)" : "", range.highest,
                       range.highest_excluded ? " (excluded)" : "");
  }
  if (below) return fmt::format("{} {}", range.lowest_excluded ? "greater than" : "at least", range.lowest);
  if (over) return fmt::format("{} {}", range.highest_excluded ? "less than" : "at most", range.highest);
  return "";
}

}  // namespace tern
