// [[structure.clamp]]

#include "scene/keys/motion.hpp"
#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

const Rows<ClampCase>& clamp_rows() {
  // clang-format off
  static const Rows<ClampCase> rows = {
      {"name", &ClampCase::name, "", required, any, "Name of the clamp in gauges and messages; unique."},
      {"body", &ClampCase::body, "", required, any, "The elastic body it holds."},
      {"region", &ClampCase::region, "", required, any, "Particles of the undeformed body inside this shape are held."},
      {"hinge", &ClampCase::is_hinge, "", "false", any,
       "Of a shell: hold its edge in its place only and let it turn, as `hinge` of [[structure.body]] does."},
      {"displacement", of_motion<ClampCase>(&RigidMotion::displacement), "m", absent, a_place,
       "Displacement from the initial place as expressions in t, 0 at t = 0; absent = none."},
      {"rotation", of_motion<ClampCase>(&RigidMotion::rotation), "rad", absent, an_angle,
       "Angle by which the clamp is turned about `pivot` before it is displaced, an expression in t, 0 at t = 0; positive from x to y, "
       "in 3D by the right hand about `axis`."},
      {"motion_file", motion_file<ClampCase>(), "", absent, any, "In place of both: a CSV file as of a [[wall]]."},
      {"pivot", of_motion<ClampCase>(&RigidMotion::pivot), "m", absent, a_place, "Point about which it turns, at t = 0."},
      {"axis", of_motion<ClampCase>(&RigidMotion::axis), "", absent, a_place, "Direction of the axis of a rotation; 3D only."},
  };
  // clang-format on
  return rows;
}

}  // namespace

TableDefinition clamp_table() {
  return {"structure.clamp", true, Presence::optional,
          "A clamp with a name, which can move and whose reaction can be measured; a region of `clamp` in [[structure.body]] is fixed.",
          parameters_of(clamp_rows())};
}

ClampCase read_clamp(const Setting& table, int dimension, const std::filesystem::path& folder) {
  ClampCase clamp = filled(clamp_rows(), table);
  complete_motion(clamp.motion, table, "clamp '" + clamp.name + "'", dimension, folder);
  return clamp;
}

}  // namespace tern
