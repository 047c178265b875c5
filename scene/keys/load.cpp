// [[structure.load]]

#include <fmt/format.h>
#include "base/error.hpp"
#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

Member<LoadCase> vector_load(LoadCase::Kind kind) {
  return {ParameterType::expressions, [kind](LoadCase& load, const Setting& value) {
            load.kind = kind;
            read_value(load.value, value);
          }};
}

Member<LoadCase> pressure() {
  return {ParameterType::expression, [](LoadCase& load, const Setting& value) {
            load.kind = LoadCase::Kind::pressure;
            read_value(load.value[0], value);
          }};
}

const Rows<LoadCase>& load_rows() {
  // clang-format off
  static const Rows<LoadCase> rows = {
      {"name", &LoadCase::name, "", required, any, "Name of the load in messages; unique."},
      {"body", &LoadCase::body, "", required, any, "The elastic body it acts on."},
      {"region", &LoadCase::region, "", absent, any,
       "Part of the undeformed body that is loaded: of a body force, of every particle's cell as much as is inside; of a traction or "
       "pressure, the surface inside, patch by patch. Absent = the whole."},
      {"traction", vector_load(LoadCase::Kind::traction), "Pa", absent, a_stress, "Force per undeformed area; it keeps its direction."},
      {"pressure", pressure(), "Pa", absent, a_stress, "Pressure on the present surface; it turns and stretches with it."},
      {"body_force", vector_load(LoadCase::Kind::body_force), "N/m^3", absent, a_body_force, "Force per undeformed volume."},
  };
  // clang-format on
  return rows;
}

}  // namespace

TableDefinition load_table() {
  return {"structure.load", true, Presence::optional,
          "A load on a body; exactly one of `traction`, `pressure` and `body_force`, expressions in t and in the place x, y, z in the "
          "undeformed body.",
          parameters_of(load_rows())};
}

LoadCase read_load(const Setting& table) {
  const LoadCase load = filled(load_rows(), table);
  int given = 0;
  for (const char* kind : {"traction", "pressure", "body_force"}) given += table.find(kind) != nullptr;
  if (given != 1) {
    throw BadInput(fmt::format("{}: the load '{}' has {} of traction, pressure and body_force; give exactly one.", table.where, load.name,
                               given == 0 ? "none" : "several"));
  }
  return load;
}

}  // namespace tern
