// What moves: walls and clamps.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "scene/checks/checks.hpp"
#include "scene/parameter_table.hpp"

namespace tern {
namespace {

constexpr int instants = 500;  // of the run at which motions are looked at

template <int D>
void check_motion(const std::optional<RigidMotion>& motion, const Setting& table, const std::string& mover, double end_time) {
  if (!motion) return;
  const Setting* key = nullptr;
  for (const char* name : {"displacement", "rotation", "motion_file"})
    if (!key) key = table.find(name);
  const std::string& where = key ? key->where : table.where;
  for (int k = 0; k <= instants; ++k) {
    const double t = end_time * k / instants;
    try {
      const Placement<D> place = placement<D>(*motion, t);
      const double farthest = std::max(place.shift.cwiseAbs().maxCoeff(), std::abs(place.angle));
      if (farthest <= a_place.highest) continue;
      fail_at(where, fmt::format("the {} is displaced by {:.3g} m or turned by {:.3g} rad at t = {:.6g} s, but at most {:g} of either is "
                                 "allowed; correct its motion.",
                                 mover, place.shift.cwiseAbs().maxCoeff(), std::abs(place.angle), t, a_place.highest));
    } catch (const NumericalFailure& fault) {
      fail_at(where, fmt::format("{}: {}", mover, fault.what()));
    }
  }
}

/// The largest of |way(x)| over the corners x of the box around the shape.
template <int D, class Way>
double largest_at_corners(const Shape& shape, Way&& way) {
  const Bounds<D> bounds = bounding_box<D>(shape);
  double largest = 0;
  for (int corner = 0; corner < (1 << D); ++corner) {
    Vector<D> x = bounds.min;
    for (int d = 0; d < D; ++d)
      if (corner & (1 << d)) x[d] = bounds.max[d];
    largest = std::max(largest, Vector<D>(way(x)).norm());
  }
  return largest;
}

/// The farthest that any corner of the shape comes between two instants [m].
template <int D>
double farthest_between(const RigidMotion& motion, const Shape& shape, double begin, double end) {
  const Placement<D> before = placement<D>(motion, begin), after = placement<D>(motion, end);
  return largest_at_corners<D>(shape, [&](const Vector<D>& x) { return Vector<D>(after(x) - before(x)); });
}

/// What round-off leaves of the way of a point of the shape that stands still [m].
template <int D>
double noise(const Shape& shape) {
  const Bounds<D> bounds = bounding_box<D>(shape);
  return 1e-10 * (bounds.min.norm() + bounds.max.norm());
}

struct Jump {
  double time, size;  ///< [s], of a place [m] or of a velocity [m/s]
};

/// Change of the velocity of any corner of the shape from just before `begin` to just after `end` [m/s].
template <int D>
double change_of_velocity(const RigidMotion& motion, const Shape& shape, double begin, double end) {
  const double h = end - begin;
  const Placement<D> first = placement<D>(motion, begin - h), second = placement<D>(motion, begin), third = placement<D>(motion, end),
                     fourth = placement<D>(motion, end + h);
  return largest_at_corners<D>(shape, [&](const Vector<D>& x) { return Vector<D>(fourth(x) - third(x) - second(x) + first(x)); }) / h;
}

// Of a smooth motion the velocity changes half as much in half the time; after so many halvings next to nothing is left of it. A blow stays
// what it is.
template <int D>
std::optional<Jump> first_blow(const RigidMotion& motion, const Shape& shape, double end_time) {
  constexpr int halvings = 10;
  constexpr double left = 0.05;  // of the largest change on the way
  for (int k = 2; k < instants - 2; ++k) {
    double begin = end_time * k / instants, end = end_time * (k + 1) / instants;
    double change = change_of_velocity<D>(motion, shape, begin, end), rest = change;
    for (int n = 0; n < halvings && rest > left * change && rest * (end - begin) > 4 * noise<D>(shape); ++n) {
      const double middle = 0.5 * (begin + end);
      const double first = change_of_velocity<D>(motion, shape, begin, middle), second = change_of_velocity<D>(motion, shape, middle, end);
      rest = std::max(first, second);
      change = std::max(change, rest);  // it may swing as fast as the intervals follow each other
      (first > second ? end : begin) = middle;
    }
    if (rest > left * change && rest * (end - begin) > 4 * noise<D>(shape)) return Jump{end, rest};
  }
  return std::nullopt;
}

// A continuous motion comes half as far, about, in the faster half of an interval; after so many halvings next to nothing is left of it.
// A jump stays what it is.
template <int D>
std::optional<Jump> first_jump(const RigidMotion& motion, const Shape& shape, double end_time) {
  constexpr int halvings = 40;
  constexpr double left = 1e-3;  // of the way in the interval
  for (int k = 0; k < instants; ++k) {
    double begin = end_time * k / instants, end = end_time * (k + 1) / instants;
    const double way = farthest_between<D>(motion, shape, begin, end);
    double rest = way;
    for (int n = 0; n < halvings && rest > std::max(left * way, noise<D>(shape)); ++n) {
      const double middle = 0.5 * (begin + end);
      const double first = farthest_between<D>(motion, shape, begin, middle), second = farthest_between<D>(motion, shape, middle, end);
      rest = std::max(first, second);
      (first > second ? end : begin) = middle;
    }
    if (rest > std::max(left * way, noise<D>(shape))) return Jump{end, rest};
  }
  return std::nullopt;
}

/// Speed at the start [m/s]; 0 where it grows from rest. From rest the way grows with the square of the time at least: four times in twice
/// the time; at speed it grows twice.
template <int D>
double speed_at_start(const RigidMotion& motion, const Shape& shape, double end_time) {
  constexpr double between = 2.5;
  const double dt = 1e-2 * end_time / instants;
  const double one = farthest_between<D>(motion, shape, 0, dt), two = farthest_between<D>(motion, shape, 0, 2 * dt);
  return one > noise<D>(shape) && two < between * one ? one / dt : 0;
}

template <int D>
void look_at_smoothness(Case& scene, const std::optional<RigidMotion>& motion, const Shape& shape, bool starts_with_it,
                        const Setting& table, const std::string& mover, bool holds) {
  if (!motion) return;
  const auto jump_of_place = first_jump<D>(*motion, shape, scene.end_time);
  // An obstacle may be out of the water by then: a gate that is up stops as it likes.
  if (const auto blow = holds && !jump_of_place ? first_blow<D>(*motion, shape, scene.end_time) : std::nullopt)
    scene.warnings.push_back(fmt::format(
        "{}: the velocity of the {} jumps by {:.3g} m/s at t = {:.6g} s: the forces there are those of a blow, and depend on the "
        "length of the step. Let the parts of its motion meet with the same slope.",
        table.where, mover, blow->size, blow->time));
  if (const auto& jump = jump_of_place)
    scene.warnings.push_back(
        fmt::format("{}: the {} jumps by {:.3g} m at t = {:.6g} s: its speed is infinite there, and fluid may get through it. Let the "
                    "parts of its motion meet.",
                    table.where, mover, jump->size, jump->time));
  const double speed = starts_with_it ? 0 : speed_at_start<D>(*motion, shape, scene.end_time);
  if (speed > 0)
    scene.warnings.push_back(
        fmt::format("{}: the {} starts at {:.3g} m/s, while what it moves is at rest: the first forces are those of a blow, and depend on "
                    "the length of the first step. A motion that begins like t^2 starts from rest.",
                    table.where, mover, speed));
}

// A velocity at the start that changes in time is meant for something else: an inflow, or a motion that is given.
template <class Body>
void check_start(const std::vector<Body>& bodies, const Setting& tables) {
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (const Expression& component : bodies[i].velocity)
      if (component.depends_on('t'))
        fail_at(tables.items[i].at("velocity").where,
                fmt::format("velocity depends on t (\"{}\"), but it is that of the start; use x, y and z alone. What is moved as given "
                            "is a [[wall]] or a [[structure.clamp]] with a `displacement`.",
                            component.text()));
}

}  // namespace

template <int D>
void check_motions(Case& scene, const Setting& settings) {
  if (scene.fluid) check_start(scene.fluid->bodies, settings.at("fluid").at("body"));
  if (scene.structure) check_start(scene.structure->bodies, settings.at("structure").at("body"));
  const bool flows = scene.fluid && std::any_of(scene.fluid->bodies.begin(), scene.fluid->bodies.end(),
                                                [](const FluidBody& body) { return !is_zero(body.velocity); });
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    const WallCase& wall = scene.walls[i];
    const Setting& table = settings.at("wall").items[i];
    check_motion<D>(wall.motion, table, "wall '" + wall.name + "'", scene.end_time);
    look_at_smoothness<D>(scene, wall.motion, wall.shape, flows, table, "wall '" + wall.name + "'", wall.container);
  }
  if (!scene.structure) return;
  for (std::size_t i = 0; i < scene.structure->clamps.size(); ++i) {
    const ClampCase& clamp = scene.structure->clamps[i];
    const Setting& table = settings.at("structure").at("clamp").items[i];
    check_motion<D>(clamp.motion, table, "clamp '" + clamp.name + "'", scene.end_time);
    bool moves = false;
    for (const StructureBody& body : scene.structure->bodies) moves |= body.name == clamp.body && !is_zero(body.velocity);
    look_at_smoothness<D>(scene, clamp.motion, clamp.region, moves, table, "clamp '" + clamp.name + "'", true);
  }
}

template void check_motions<2>(Case&, const Setting&);
template void check_motions<3>(Case&, const Setting&);

}  // namespace tern
