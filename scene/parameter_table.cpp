#include "scene/parameter_table.hpp"

#include <fmt/format.h>

#include <cmath>

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

namespace {

// 1000000000 as 1e+09: nobody counts zeros.
std::string number(double x) {
  const std::string brief = fmt::format("{:g}", x);
  return std::abs(x) >= 1e6 && std::stod(brief) == x ? brief : fmt::format("{}", x);
}

}  // namespace

std::string describe(const Range& range) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const bool below = range.lowest > -infinity, over = range.highest < infinity;
  if (below && over) {
    return fmt::format("from {}{} to {}{}", number(range.lowest), range.lowest_excluded ? " (excluded)" : "", number(range.highest),
                       range.highest_excluded ? " (excluded)" : "");
  }
  if (below) return fmt::format("{} {}", range.lowest_excluded ? "greater than" : "at least", number(range.lowest));
  if (over) return fmt::format("{} {}", range.highest_excluded ? "less than" : "at most", number(range.highest));
  return "";
}

}  // namespace tern
