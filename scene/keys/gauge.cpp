// [[gauge]]

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include "base/error.hpp"
#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

const Rows<GaugeCase>& gauge_rows() {
  // clang-format off
  static const Rows<GaugeCase> rows = {
      {"kind",
       one_of(&GaugeCase::kind, {{"displacement", GaugeCase::Kind::displacement},
                                 {"pressure", GaugeCase::Kind::pressure},
                                 {"elevation", GaugeCase::Kind::elevation},
                                 {"front", GaugeCase::Kind::front},
                                 {"interface_force", GaugeCase::Kind::interface_force},
                                 {"force", GaugeCase::Kind::force},
                                 {"wall_pressure", GaugeCase::Kind::wall_pressure},
                                 {"reaction", GaugeCase::Kind::reaction},
                                 {"flux", GaugeCase::Kind::flux}}),
       "", required, any,
       "displacement of a body's material point [m]; pressure of the fluid at a point [Pa]; elevation of the free surface at a place "
       "[m]; front: largest x the connected fluid reaches [m]; interface_force on a body [N/m^(3-D)]; force on a rigid wall [N/m^(3-D)] "
       "and its moment [N m/m^(3-D)]; wall_pressure: mean over a sensor on a rigid wall [Pa]; reaction: force [N/m^(3-D)] and moment [N "
       "m/m^(3-D)] with which a clamp, or all clamps of a body, hold it; flux through a line or rectangle [m^D/s]."},
      {"name", &GaugeCase::name, "", required, any, "Name of the column; unique."},
      {"body", &GaugeCase::body, "", absent, any, "Elastic body; displacement, interface_force and reaction need it."},
      {"clamp", &GaugeCase::clamp, "", absent, any, "A named clamp of the body, of a reaction; absent = all clamps of the body."},
      {"at", &GaugeCase::at, "m", absent, any,
       "Where: displacement (in the undeformed body), pressure, elevation (whose y entry is not used) and wall_pressure (on the wall at "
       "t = 0) need it; force: the point of the moment, default the wall's pivot, else the origin. On a wall that moves, it moves along."
       " Reaction: the point of the moment, fixed in space, default the origin."},
      {"wall", &GaugeCase::wall, "", absent, any, "Rigid wall; force and wall_pressure need it."},
      {"diameter", &GaugeCase::diameter, "m", absent, positive, "Of the sensor of a wall_pressure; absent = one spacing of the fluid."},
      {"from", &GaugeCase::from, "m", absent, any,
       "Flux: begin of the line, or one corner of the rectangle; seen from here, flow to the right counts as positive (3D: flow along "
       "the positive axis)."},
      {"to", &GaugeCase::to, "m", absent, any, "Flux: end of the line, or the opposite corner; in 3D both agree in one coordinate."},
  };
  // clang-format on
  return rows;
}

struct GaugeKeys {
  GaugeCase::Kind kind;
  std::vector<std::string> required, optional;
};

const std::map<std::string, GaugeKeys>& gauge_keys() {
  using Kind = GaugeCase::Kind;
  static const std::map<std::string, GaugeKeys> keys = {
      {"displacement", {Kind::displacement, {"body", "at"}, {}}},
      {"pressure", {Kind::pressure, {"at"}, {}}},
      {"elevation", {Kind::elevation, {"at"}, {}}},
      {"front", {Kind::front, {}, {}}},
      {"interface_force", {Kind::interface_force, {"body"}, {}}},
      {"force", {Kind::force, {"wall"}, {"at"}}},
      {"wall_pressure", {Kind::wall_pressure, {"wall", "at"}, {"diameter"}}},
      {"reaction", {Kind::reaction, {"body"}, {"clamp", "at"}}},
      {"flux", {Kind::flux, {"from", "to"}, {}}},
  };
  return keys;
}

}  // namespace

std::vector<TableDefinition> gauge_tables() {
  return {{"gauge", true, Presence::optional, "A quantity written to gauges.csv.", parameters_of(gauge_rows())}};
}

GaugeCase read_gauge(const Setting& setting, const Case& scene) {
  const std::string& kind = setting.at("kind").text;
  const GaugeKeys& keys = gauge_keys().at(kind);
  GaugeCase gauge;
  for (const WallCase& wall : scene.walls)
    if (const Setting* name = setting.find("wall"); name && wall.name == name->text && wall.motion) gauge.at = wall.motion->pivot;
  fill(gauge, gauge_rows(), setting);
  for (const std::string key : {"body", "clamp", "wall", "at", "diameter", "from", "to"}) {
    const Setting* value = setting.find(key);
    const bool needed = std::count(keys.required.begin(), keys.required.end(), key) > 0;
    if (value ? needed || std::count(keys.optional.begin(), keys.optional.end(), key) > 0 : !needed) continue;
    throw BadInput(fmt::format("{}: the gauge '{}' of kind {} {} '{}'; {} it.", value ? value->where : setting.where, gauge.name, kind,
                               needed ? "needs the key" : "has no use for the key", key, needed ? "give" : "remove"));
  }
  if (gauge.kind == GaugeCase::Kind::wall_pressure && !setting.find("diameter")) gauge.diameter = scene.fluid ? scene.fluid->spacing : 0;
  return gauge;
}

}  // namespace tern
