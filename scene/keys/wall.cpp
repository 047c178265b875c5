// [[wall]]

#include <fmt/format.h>
#include "base/error.hpp"
#include "scene/keys/motion.hpp"
#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

Member<WallCase> shape_of_wall(bool container) {
  return {ParameterType::shape, [container](WallCase& wall, const Setting& shape) {
            wall.container = container;
            read_value(wall.shape, shape);
          }};
}

const Rows<WallCase>& wall_rows() {
  // clang-format off
  static const Rows<WallCase> rows = {
      {"name", &WallCase::name, "", required, any, "Name of the wall in messages; unique."},
      {"container", shape_of_wall(true), "", absent, any, "The fluid stays inside this shape."},
      {"obstacle", shape_of_wall(false), "", absent, any, "The fluid stays outside this shape."},
      {"open", some_of(&WallCase::open, {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"}), "", "[]", any,
       "Faces left out; of a container that is a box only."},
      {"displacement", of_motion<WallCase>(&RigidMotion::displacement), "m", absent, a_place,
       "Displacement from the initial place as expressions in t, 0 at t = 0; absent = none."},
      {"rotation", of_motion<WallCase>(&RigidMotion::rotation), "rad", absent, an_angle,
       "Angle by which the wall is turned about `pivot` before it is displaced, an expression in t, 0 at t = 0; positive from x to y, in"
       " 3D by the right hand about `axis`."},
      {"motion_file", motion_file<WallCase>(), "", absent, any,
       "In place of both: a CSV file, its path relative to the case file, with a header of t_s and some of x_m, y_m, z_m, angle_rad and "
       "the first row 0 at t = 0; splines between its rows, the last row is held."},
      {"pivot", of_motion<WallCase>(&RigidMotion::pivot), "m", absent, a_place,
       "Point about which a wall with a rotation turns, at t = 0."},
      {"axis", of_motion<WallCase>(&RigidMotion::axis), "", absent, a_place, "Direction of the axis of a rotation; 3D only."},
      {"slip", &WallCase::slip, "", "false", any,
       "A wall without friction although the fluid has a viscosity; without viscosity every wall is one."},
  };
  // clang-format on
  return rows;
}

}  // namespace

std::vector<TableDefinition> wall_tables() {
  return {{"wall", true, Presence::optional, "A rigid, impermeable wall; either `container` or `obstacle`.", parameters_of(wall_rows())}};
}

WallCase read_wall(const Setting& table, int dimension, const std::filesystem::path& folder) {
  WallCase wall = filled(wall_rows(), table);
  const bool container = table.find("container"), obstacle = table.find("obstacle");
  if (container == obstacle) {
    throw BadInput(fmt::format("{}: the wall '{}' has {} container and obstacle; give exactly one of them.", table.where, wall.name,
                               container ? "both" : "neither"));
  }
  const Setting& open = table.at("open");
  if (!wall.open.empty() && !(wall.container && wall.shape.kind == Shape::Kind::box)) {
    throw BadInput(
        fmt::format("{}: the wall '{}' has open faces, but only a container that is a box can have them.", open.where, wall.name));
  }
  for (const std::string& face : wall.open) {
    if (dimension == 2 && face[0] == 'z')
      throw BadInput(fmt::format("{}: the wall '{}' has no face {} in 2D; remove it.", open.where, wall.name, face));
  }
  complete_motion(wall.motion, table, "wall '" + wall.name + "'", dimension, folder);
  return wall;
}

}  // namespace tern
