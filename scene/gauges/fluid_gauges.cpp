// Gauges that the fluid process evaluates (fluid/gauges/).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/checks/checks.hpp"
#include "scene/gauges.hpp"
#include "scene/gauges/gauge.hpp"
#include "scene/scene_check.hpp"

namespace tern {
namespace {

using Type = ParameterType;
using Columns = std::vector<std::string>;

// Outside the container there is never fluid, unless the container moves.
void check_pressure(const GaugeCase& gauge, const Case& scene, const std::string& where) {
  const auto region = fluid_region(scene);
  const bool moves =
      std::any_of(scene.walls.begin(), scene.walls.end(), [](const WallCase& wall) { return wall.container && wall.motion; });
  if (!region || moves || distance_from(*region, gauge.point("at"), scene) <= 1e-6 * scene.fluid->spacing) return;
  fail_at(where, fmt::format("the gauge '{}' at {} is outside the container, where there is never fluid; move it.", gauge.name,
                             place_text(gauge.point("at"), scene)));
}

// A place beside the container has no surface above or below it.
void check_elevation(const GaugeCase& gauge, const Case& scene, const std::string& where) {
  const auto region = fluid_region(scene);
  const bool moves =
      std::any_of(scene.walls.begin(), scene.walls.end(), [](const WallCase& wall) { return wall.container && wall.motion; });
  if (!region || moves) return;
  const int up = upward(scene).axis;
  const auto is_beside = [&](const auto& box) {
    bool beside = false;
    for (int d = 0; d < scene.dimension; ++d) beside |= d != up && (gauge.point("at")[d] < box.min[d] || gauge.point("at")[d] > box.max[d]);
    return beside;
  };
  if (!(scene.dimension == 2 ? is_beside(bounding_box<2>(*region)) : is_beside(bounding_box<3>(*region)))) return;
  fail_at(where, fmt::format("the gauge '{}' at {} is beside the container, where there is never fluid; move it.", gauge.name,
                             place_text(gauge.point("at"), scene)));
}

void check_wall_pressure(const GaugeCase& gauge, const Case& scene, const std::string& where) {
  const WallCase& wall = wall_of(gauge, scene, where);
  const std::array<double, 3> at = gauge.point("at");
  const double slack = 0.1 * scene.fluid->spacing, distance = distance_from(wall.shape, at, scene);
  if (std::abs(distance) > slack) {
    fail_at(where, fmt::format("the sensor '{}' at {} is {:.3g} m away from the surface of the wall '{}'; move it there.", gauge.name,
                               place_text(at, scene), std::abs(distance), wall.name));
  }
  bool on_open = false, on_closed = wall.open.empty();
  for (int d = 0; d < scene.dimension && !wall.open.empty(); ++d)
    for (const auto& [side, face] : {std::pair{"_min", wall.shape.min[d]}, std::pair{"_max", wall.shape.max[d]}})
      if (std::abs(at[d] - face) <= slack) (is_open(wall, std::string(1, "xyz"[d]) + side) ? on_open : on_closed) = true;
  if (on_open && !on_closed) {
    fail_at(where, fmt::format("the sensor '{}' at {} is on an open face of '{}', where there is no wall; move it.", gauge.name,
                               place_text(at, scene), wall.name));
  }
}

void check_flux(const GaugeCase& gauge, const Case& scene, const std::string& where) {
  const std::array<double, 3> from = gauge.point("from"), to = gauge.point("to");
  int equal = 0;
  for (int d = 0; d < scene.dimension; ++d) equal += from[d] == to[d];
  if (scene.dimension == 2 && equal == 2) {
    fail_at(where, fmt::format("the line of the gauge '{}' has length 0; move 'to'.", gauge.name));
  }
  if (scene.dimension == 3 && equal != 1) {
    fail_at(where, fmt::format("'from' and 'to' of the gauge '{}' agree in {} coordinates instead of one; they are opposite corners of a "
                               "rectangle across an axis.",
                               gauge.name, equal));
  }
}

void about_the_pivot(GaugeCase& gauge, const Case& scene) {
  for (const WallCase& wall : scene.walls)
    if (wall.name == gauge.text("wall") && wall.motion && !gauge.points.contains("at")) gauge.points["at"] = wall.motion->pivot;
}

}  // namespace

std::vector<GaugeDefinition> fluid_gauges() {
  return {
      {.kind = "pressure",
       .owner = GaugeOwner::fluid,
       .meaning = "pressure of the fluid at a point [Pa]",
       .keys = {{"at", Type::point, true, "the point"}},
       .columns = [](int) { return Columns{"p_Pa"}; },
       .place = GaugePlace::point,
       .check = check_pressure},
      {.kind = "elevation",
       .owner = GaugeOwner::fluid,
       .meaning =
           "elevation of the free surface at a place, as a wire gauge measures it: the y of the top of the lowest water, or where gravity "
           "is along another axis its coordinate there, and the thickness of all water above and of "
           "bodies and walls between [m]",
       .keys = {{"at", Type::point, true, "the place, whose entry along gravity is not used"}},
       .columns = [](int) { return Columns{"eta_m"}; },
       .check = check_elevation},
      {.kind = "front",
       .owner = GaugeOwner::fluid,
       .meaning = "largest x the connected fluid reaches [m]",
       .keys = {},
       .columns = [](int) { return Columns{"x_m"}; }},
      {.kind = "force",
       .owner = GaugeOwner::fluid,
       .meaning = "force on a rigid wall, by pressure, contact and friction [N/m^(3-D)], and its moment [N m/m^(3-D)]",
       .keys = {{"wall", Type::text, true, "the rigid wall"},
                {"at", Type::point, false,
                 "the point of the moment, which moves along with the wall; absent = the pivot of the wall, else the origin"}},
       .columns = force_and_moment_columns,
       .complete = about_the_pivot,
       .check = [](const GaugeCase& gauge, const Case& scene, const std::string& where) { wall_of(gauge, scene, where); }},
      {.kind = "wall_pressure",
       .owner = GaugeOwner::fluid,
       .meaning = "mean over a sensor on a rigid wall, 0 where it is dry [Pa]",
       .keys = {{"wall", Type::text, true, "the rigid wall"},
                {"at", Type::point, true, "the middle of the sensor on the wall at t = 0, which moves along with it"},
                {"diameter", Type::number, false, "diameter of the sensor; absent = one spacing of the fluid", "m", a_size}},
       .columns = [](int) { return Columns{"p_Pa"}; },
       .place = GaugePlace::disc,
       .complete = one_spacing_wide,
       .check = check_wall_pressure},
      {.kind = "flux",
       .owner = GaugeOwner::fluid,
       .meaning = "flux through a line or rectangle [m^D/s]",
       .keys = {{"from", Type::point, true,
                 "begin of the line, or one corner of the rectangle; seen from here, flow to the right counts as positive (3D: flow along "
                 "the positive axis)"},
                {"to", Type::point, true, "end of the line, or the opposite corner; in 3D both agree in one coordinate"}},
       .columns = [](int dimension) { return Columns{dimension == 2 ? "Q_m2_per_s" : "Q_m3_per_s"}; },
       .place = GaugePlace::line,
       .check = check_flux},
  };
}

}  // namespace tern
