// Gauges that the structure process evaluates (structure/gauges/).

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "scene/checks/checks.hpp"
#include "scene/gauges/gauge.hpp"
#include "scene/mid_surface.hpp"

namespace tern {
namespace {

using Type = ParameterType;

// The frame of a displacement is a wall or clamp that moves.
void check_frame(const GaugeCase& gauge, const Case& scene, const std::string& where) {
  const std::string frame = gauge.text("frame");
  if (frame.empty()) return;
  int known = 0, moving = 0;
  std::vector<std::string> movers;
  const auto look_at = [&](const auto& all) {
    for (const auto& one : all) {
      known += one.name == frame;
      moving += one.name == frame && one.motion;
      if (one.motion) movers.push_back(one.name);
    }
  };
  look_at(scene.walls);
  if (scene.structure) look_at(scene.structure->clamps);
  if (moving == 1 && known == 1) return;
  const std::string remedy =
      movers.empty() ? "nothing in this case moves; remove 'frame'" : fmt::format("what moves is '{}'", fmt::join(movers, "', '"));
  fail_at(where, fmt::format("the gauge '{}' measures in the frame of '{}', {}; {}.", gauge.name, frame,
                             known == 0    ? "which is no [[wall]] and no [[structure.clamp]]"
                             : moving == 0 ? "which does not move"
                                           : "which names a wall and a clamp",
                             remedy));
}

void check_displacement(const GaugeCase& gauge, const Case& scene, const std::string& where) {
  const StructureBody& body = body_of(gauge, scene, where);
  check_frame(gauge, scene, where);
  const double distance = distance_from(body.shape, gauge.point("at"), scene);
  if (distance > 1e-6 * body.spacing)
    fail_at(where, fmt::format("the gauge '{}' at {} is no point of the undeformed body '{}'; move it by {:.3g} m.", gauge.name,
                               place_text(gauge.point("at"), scene), body.name, distance));
  if (!body.is_shell) return;
  for (const Shape& clamp : body.rigid_clamps()) {
    if (distance_from(clamp, gauge.point("at"), scene) < 0)
      fail_at(where, fmt::format("the gauge '{}' at {} is inside a clamp of '{}', where a shell has no particles; move it out.", gauge.name,
                                 place_text(gauge.point("at"), scene), body.name));
  }
  const auto check_place = [&]<int D>(const MidSurface<D>& surface) {
    const Vector<D> at = gauge.place<D>("at"), foot = surface.foot(at);
    if ((at - foot).norm() > 1e-3 * surface.thickness)
      fail_at(where, fmt::format("the gauge '{}' at {} is not on the mid-surface of the shell '{}', but {:.6g} m beside it; move it to "
                                 "[{:.7g}].",
                                 gauge.name, place_text(gauge.point("at"), scene), body.name, (at - foot).norm(),
                                 fmt::join(foot.data(), foot.data() + D, ", ")));
  };
  scene.dimension == 2 ? check_place(mid_surface<2>(body)) : check_place(mid_surface<3>(body));
}

void check_reaction(const GaugeCase& gauge, const Case& scene, const std::string& where) {
  const StructureBody& body = body_of(gauge, scene, where);
  if (body.clamps.empty()) {
    fail_at(where,
            fmt::format("the gauge '{}' measures the reaction of the body '{}', which has no clamp; give it one.", gauge.name, body.name));
  }
  const std::string name = gauge.text("clamp");
  const auto& clamps = scene.structure->clamps;
  if (name.empty() ||
      std::any_of(clamps.begin(), clamps.end(), [&](const ClampCase& c) { return c.name == name && c.body == body.name; })) {
    return;
  }
  fail_at(where, fmt::format("the gauge '{}' names the clamp '{}', but the body '{}' has no [[structure.clamp]] of this name; correct it, "
                             "or leave it out for all clamps of the body.",
                             gauge.name, name, body.name));
}

void check_body_pressure(const GaugeCase& gauge, const Case& scene, const std::string& where) {
  const StructureBody& body = body_of(gauge, scene, where);
  if (!scene.fluid)
    fail_at(where, fmt::format("the gauge '{}' measures the fluid's pressure, but the case has no [fluid]; remove it.", gauge.name));
  const std::array<double, 3> at = gauge.point("at");
  const double distance = distance_from(body.shape, at, scene);
  if (std::abs(distance) > 0.1 * body.spacing) {
    fail_at(where, fmt::format("the sensor '{}' at {} is {:.3g} m away from the surface of the undeformed body '{}'; move it there.",
                               gauge.name, place_text(at, scene), std::abs(distance), body.name));
  }
  for (const Shape& clamp : body.clamps) {
    if (distance_from(clamp, at, scene) < 0)
      fail_at(where, fmt::format("the sensor '{}' at {} is inside a clamp of '{}', where no fluid loads it; move it.", gauge.name,
                                 place_text(at, scene), body.name));
  }
}

}  // namespace

std::vector<GaugeDefinition> structure_gauges() {
  return {
      {.kind = "displacement",
       .owner = GaugeOwner::structure,
       .meaning = "displacement of a body's material point [m]",
       .keys = {{"body", Type::text, true, "the elastic body"},
                {"at", Type::point, true, "the point of the undeformed body"},
                {"frame", Type::text, false,
                 "a wall or clamp that moves: the displacement as seen by one who moves with it; absent = by one at rest"}},
       .columns = [](int dimension) { return component_columns("u", "m", dimension); },
       .place = GaugePlace::point,
       .check = check_displacement},
      {.kind = "body_pressure",
       .owner = GaugeOwner::structure,
       .meaning = "mean pressure over a sensor on an elastic body, its normal load over its area, 0 where it is dry [Pa]",
       .keys = {{"body", Type::text, true, "the elastic body"},
                {"at", Type::point, true, "the middle of the sensor on the surface of the undeformed body, which carries it along"},
                {"diameter", Type::number, false, "diameter of the sensor; absent = one spacing of the fluid", "m", a_size}},
       .columns = [](int) { return std::vector<std::string>{"p_Pa"}; },
       .place = GaugePlace::disc,
       .complete = one_spacing_wide,
       .check = check_body_pressure},
      {.kind = "reaction",
       .owner = GaugeOwner::structure,
       .meaning = "force [N/m^(3-D)] and moment [N m/m^(3-D)] with which a clamp, or all clamps of a body, hold it, without weight and "
                  "inertia of the particles that it holds",
       .keys = {{"body", Type::text, true, "the elastic body"},
                {"clamp", Type::text, false, "a named clamp of the body; absent = all of them"},
                {"at", Type::point, false, "the point of the moment, fixed in space; absent = the origin"}},
       .columns = force_and_moment_columns,
       .check = check_reaction},
  };
}

}  // namespace tern
