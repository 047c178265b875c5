#include "scene/mid_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.hpp"
#include "scene/geodesic_sphere.hpp"
#include "scene/loose_particles.hpp"

namespace tern {
namespace {

constexpr double round_off = 1e-6;  // of the spacing

/// A layer that turns by more than this within a spacing, ten particles round a circle, has no curvature that its particles could tell.
constexpr double largest_turn = 0.2 * std::numbers::pi;

/// The mid-surface of a box, halfway through its shortest side, without what holds it.
template <int D>
MidSurface<D> middle_of_box(const Shape& shape) {
  int across = 0;
  for (int d = 1; d < D; ++d)
    if (shape.max[d] - shape.min[d] < shape.max[across] - shape.min[across]) across = d;
  MidSurface<D> surface;
  surface.thickness = shape.max[across] - shape.min[across];
  surface.origin[across] = 0.5 * (shape.min[across] + shape.max[across]);
  surface.axes.setZero();
  for (int d = 0, n = 0; d < D; ++d) {
    if (d == across) continue;
    surface.low[n] = shape.min[d];
    surface.high[n] = shape.max[d];
    surface.axes(d, n++) = 1;
  }
  if constexpr (D == 2)
    surface.axes.col(1) << -surface.axes(1, 0), surface.axes(0, 0);
  else
    surface.axes.col(2) = surface.axes.col(0).cross(surface.axes.col(1));
  return surface;
}

/// A circle or a tube, or a part of one.
template <int D>
MidSurface<D> middle_of_round(const Shape& shape) {
  MidSurface<D> surface;
  surface.kind = MidSurface<D>::Kind::round;
  surface.thickness = shape.thickness;
  surface.radius = shape.radius;
  surface.begin = shape.begin;
  for (int d = 0; d < D; ++d) surface.origin[d] = shape.center[d];
  surface.axes.setZero();
  if constexpr (D == 3) {
    surface.origin[shape.axis] -= 0.5 * shape.length;
    surface.high[0] = shape.length;
    for (int a = 0; a < 3; ++a) surface.axes((shape.axis + a) % 3, a) = 1;
  } else {
    surface.axes.setIdentity();
  }
  surface.high[D - 2] = shape.radius * (shape.end - shape.begin);
  surface.closed[D - 2] = shape.end - shape.begin >= Shape::whole_turn * (1 - 1e-12);
  return surface;
}

template <int D>
MidSurface<D> middle_of_line(const StructureBody& body) {
  const Shape& shape = body.shape;
  MidSurface<D> surface;
  surface.kind = MidSurface<D>::Kind::path;
  surface.thickness = shape.thickness;
  surface.closed[0] = shape.closed;
  surface.reach = 0.5 * body.spacing;
  const std::size_t count = shape.vertices.size() + (shape.closed ? 1 : 0);
  for (std::size_t i = 0; i < count; ++i) {
    const auto& vertex = shape.vertices[i % shape.vertices.size()];
    Vector<D> x = Vector<D>::Zero();
    x[0] = vertex[0], x[1] = vertex[1];
    surface.corner_at.push_back(i == 0 ? 0 : surface.corner_at.back() + (x - surface.corners.back()).norm());
    surface.corners.push_back(x);
  }
  surface.high[0] = surface.corner_at.back();
  return surface;
}

/// Whether the shape is a hollow ball: what one ball leaves of another about the same centre.
bool is_hollow_ball(const Shape& shape) {
  return shape.kind == Shape::Kind::difference && shape.parts.size() == 2 && shape.parts[0].kind == Shape::Kind::ball &&
         shape.parts[1].kind == Shape::Kind::ball && shape.parts[0].center == shape.parts[1].center &&
         shape.parts[0].radius > shape.parts[1].radius;
}

template <int D>
MidSurface<D> middle_of_ball(const StructureBody& body) {
  const double outer = body.shape.parts[0].radius, inner = body.shape.parts[1].radius;
  MidSurface<D> surface;
  surface.kind = MidSurface<D>::Kind::ball;
  surface.thickness = outer - inner;
  surface.radius = 0.5 * (outer + inner);
  for (int d = 0; d < D; ++d) surface.origin[d] = body.shape.parts[0].center[d];
  for (int n = 0; n < D - 1; ++n) {
    surface.high[n] = 2 * std::numbers::pi * surface.radius;
    surface.closed[n] = true;
  }
  const double particles = 4 * std::numbers::pi * std::pow(surface.radius / body.spacing, 2);
  surface.parts = std::max(1, static_cast<int>(std::ceil(std::sqrt(std::max(0.0, particles - 2) / 10) - round_off)));
  return surface;
}

MidSurface<3> middle_of_plate(const Shape& shape) {
  MidSurface<3> surface;
  surface.kind = MidSurface<3>::Kind::plate;
  surface.thickness = shape.thickness;
  for (int d = 0; d < 3; ++d) {
    surface.origin[d] = shape.center[d];
    for (int a = 0; a < 3; ++a) surface.axes(d, a) = shape.axes[a][d];
  }
  surface.low = surface.high = shape.vertices[0];
  for (const auto& vertex : shape.vertices) {
    surface.outline.emplace_back(vertex[0], vertex[1]);
    for (int n = 0; n < 2; ++n) {
      surface.low[n] = std::min(surface.low[n], vertex[n]);
      surface.high[n] = std::max(surface.high[n], vertex[n]);
    }
  }
  surface.sides.assign(surface.outline.size(), EdgeKind::free);
  return surface;
}

template <int D>
MidSurface<D> bare_surface(const StructureBody& body) {
  const Shape::Kind kind = body.shape.kind;
  if (kind == Shape::Kind::box) return middle_of_box<D>(body.shape);
  if (kind == (D == 2 ? Shape::Kind::ring : Shape::Kind::tube)) return middle_of_round<D>(body.shape);
  if (D == 2 && kind == Shape::Kind::line) return middle_of_line<D>(body);
  if constexpr (D == 3)
    if (kind == Shape::Kind::plate) return middle_of_plate(body.shape);
  if (D == 3 && is_hollow_ball(body.shape)) return middle_of_ball<D>(body);
  throw BadInput(fmt::format("The shell '{}' has no mid-surface, which only a box{} has. Make it one, or model it as a solid.", body.name,
                             D == 2 ? ", a ring or a line" : ", a plate, a tube or a ball less a smaller one about its centre"));
}

/// Along which coordinate, in words.
template <int D>
std::string direction_of(const MidSurface<D>& surface, int n) {
  using Kind = typename MidSurface<D>::Kind;
  if (surface.kind == Kind::path) return "along it";
  if (surface.kind == Kind::ball) return "round it";
  if (surface.kind == Kind::round) return n == D - 2 ? "round it" : "along its axis";
  if (surface.kind == Kind::plate) return n == 0 ? "along its longest side" : "across its longest side";
  int axis = 0;
  surface.axes.col(n).cwiseAbs().maxCoeff(&axis);
  return fmt::format("in direction {}", "xyz"[axis]);
}

/// Which coordinate an axis of the box is.
template <int D>
int axis_of(const MidSurface<D>& surface, int n) {
  int axis = 0;
  surface.axes.col(n).cwiseAbs().maxCoeff(&axis);
  return axis;
}

/// Ends the free part of a box at the face of a clamp.
template <int D>
void clamp_box(const StructureBody& body, const Shape& clamp, MidSurface<D>& surface) {
  const Shape& shape = body.shape;
  int ends = 0, end = 0, direction = 0;
  const int across = axis_of(surface, D - 1);
  bool is_whole = clamp.kind == Shape::Kind::box && clamp.min[across] <= shape.min[across] && clamp.max[across] >= shape.max[across];
  for (int n = 0; n < D - 1 && is_whole; ++n) {
    const int d = axis_of(surface, n);
    const bool low = clamp.min[d] <= shape.min[d], high = clamp.max[d] >= shape.max[d];
    if (low && high) continue;
    is_whole = low ? clamp.max[d] >= shape.min[d] : high && clamp.min[d] <= shape.max[d];
    ++ends;
    direction = n;
    end = low ? 0 : 1;
  }
  if (!is_whole || ends != 1)
    throw BadInput(
        fmt::format("The shell '{}' is held by a clamp that is not a box over one whole edge; let it reach across the thickness "
                    "and beyond both ends of the edge, or model the body as a solid.",
                    body.name));
  const int d = axis_of(surface, direction);
  surface.edges[direction][end] = EdgeKind::clamp;
  if (end == 0)
    surface.low[direction] = std::max(surface.low[direction], clamp.max[d]);
  else
    surface.high[direction] = std::min(surface.high[direction], clamp.min[d]);
}

/// Places on the line across the mid-surface where coordinate n has this value.
template <int D>
std::vector<Vector<D>> line_across(const MidSurface<D>& surface, int n, double value) {
  constexpr int pieces = 64;
  std::vector<Vector<D>> line;
  std::array<double, D - 1> s{};
  s[n] = value;
  for (int k = 0; k <= (D == 2 ? 0 : pieces); ++k) {
    const int other = D - 2 - n;
    if constexpr (D == 3) s[other] = surface.low[other] + k * surface.length(other) / pieces;
    line.push_back(surface.at(s).position);
  }
  return line;
}

/// Ends the free part of another mid-surface where it leaves the region of a clamp.
template <int D>
void clamp_bent(const StructureBody& body, const Shape& clamp, MidSurface<D>& surface) {
  const auto holds = [&](const Vector<D>& x) { return contains<D>(clamp, x); };
  const double step = 0.25 * body.spacing;
  int found = 0;
  bool is_clean = true;
  const MidSurface<D> bare = surface;
  for (int n = 0; n < D - 1; ++n)
    for (int end = 0; end < 2 && !bare.closed[n]; ++end) {
      const double from = end == 0 ? bare.low[n] : bare.high[n], inwards = end == 0 ? 1 : -1, length = bare.length(n);
      const auto whole = [&](double depth) {
        const auto line = line_across(bare, n, from + inwards * depth);
        return std::all_of(line.begin(), line.end(), holds);
      };
      const auto any = [&](double depth) {
        const auto line = line_across(bare, n, from + inwards * depth);
        return std::any_of(line.begin(), line.end(), holds);
      };
      if (!whole(0)) continue;
      ++found;
      double held = 0;
      while (held < length && whole(held + step)) held += step;
      double out = held + step;
      for (int k = 0; k < 50; ++k) (whole(0.5 * (held + out)) ? held : out) = 0.5 * (held + out);
      for (double beyond = held + step; beyond < length; beyond += step) is_clean &= !any(beyond);
      surface.edges[n][end] = EdgeKind::clamp;
      if (end == 0)
        surface.low[n] = std::max(surface.low[n], from + held);
      else
        surface.high[n] = std::min(surface.high[n], from - held);
    }
  if (found > 1)
    throw BadInput(
        fmt::format("The shell '{}' is held by a clamp that holds {} of its ends at once; write a clamp for each.", body.name, found));
  if (found != 1 || !is_clean)
    throw BadInput(
        fmt::format("The shell '{}' is held by a clamp that does not hold one end of it from its edge to a line across; correct its shape, "
                    "or model the body as a solid.",
                    body.name));
}

/// Marks the edge that a hinge holds.
template <int D>
void hinge(const StructureBody& body, const Shape& region, MidSurface<D>& surface) {
  const auto holds = [&](const Vector<D>& x) { return signed_distance<D>(region, x) <= round_off * body.spacing; };
  int found = 0;
  for (int n = 0; n < D - 1; ++n)
    for (int end = 0; end < 2 && !surface.closed[n]; ++end) {
      const double edge = end == 0 ? surface.low[n] : surface.high[n], inwards = end == 0 ? 1 : -1;
      const auto line = line_across(surface, n, edge);
      if (!std::all_of(line.begin(), line.end(), holds)) continue;
      ++found;
      const auto inner = line_across(surface, n, edge + inwards * surface.thickness * (1 + round_off));
      const bool deep = std::any_of(inner.begin() + (D == 3), inner.end() - (D == 3), holds);
      if (deep)
        throw BadInput(
            fmt::format("The shell '{}' has a hinge that reaches farther into it than its thickness, {:.3g} m; a hinge holds an edge only: "
                        "make it smaller, or a clamp.",
                        body.name, surface.thickness));
      EdgeKind& kind = surface.edges[n][end];
      kind = std::max(kind, EdgeKind::hinge);
    }
  if (found != 1)
    throw BadInput(fmt::format(
        "The shell '{}' has a hinge that holds {} of its edges as a whole; each hinge has to contain one edge of the mid-surface, "
        "from corner to corner.",
        body.name, found == 0 ? "none" : "several"));
}

/// Marks the sides of a plate that a clamp or hinge contains.
void hold_sides(const StructureBody& body, const Shape& region, EdgeKind as, MidSurface<3>& surface) {
  constexpr int parts = 32;
  const char* what = as == EdgeKind::clamp ? "clamp" : "hinge";
  const auto holds = [&](const Vector<2>& s) {
    return signed_distance<3>(region, surface.at({s[0], s[1]}).position) <= round_off * body.spacing;
  };
  int found = 0;
  for (std::size_t i = 0; i < surface.outline.size(); ++i) {
    const Vector<2>&from = surface.outline[i], to = surface.outline[(i + 1) % surface.outline.size()], along = to - from;
    const Vector<2> inwards = Vector<2>(-along[1], along[0]).normalized();
    int held = 0;
    for (int k = 0; k <= parts; ++k) held += holds(from + along * k / parts);
    const int beside = static_cast<int>(std::ceil(parts * surface.thickness / along.norm()));  // held by what holds the next side
    if (held <= parts && held > 2 * (beside + 1) && along.norm() > 2 * surface.thickness)
      throw BadInput(
          fmt::format("The plate '{}' has a {} that holds its side {} in part; let it contain the whole side, or add a corner "
                      "where it ends.",
                      body.name, what, i + 1));
    if (held <= parts) continue;
    ++found;
    if (holds(0.5 * (from + to) + surface.thickness * (1 + round_off) * inwards))
      throw BadInput(
          fmt::format("The plate '{}' has a {} that reaches farther into it than its thickness, {:.3g} m, at its side {}; one "
                      "holds a side only: make it smaller.",
                      body.name, what, surface.thickness, i + 1));
    surface.sides[i] = std::max(surface.sides[i], as);
  }
  if (found == 0)
    throw BadInput(fmt::format("The plate '{}' has a {} that contains none of its sides from corner to corner.", body.name, what));
}

/// How a plate is held where its outline reaches the ends of its lattice.
void mark_ends(MidSurface<3>& surface) {
  for (int n = 0; n < 2; ++n)
    for (int end = 0; end < 2; ++end) {
      const double at = end == 0 ? surface.low[n] : surface.high[n], slack = round_off * surface.length(n);
      for (std::size_t i = 0; i < surface.outline.size(); ++i)
        for (const std::size_t corner : {i, (i + 1) % surface.outline.size()})
          if (std::abs(surface.outline[corner][n] - at) <= slack) surface.edges[n][end] = std::max(surface.edges[n][end], surface.sides[i]);
      // A side along the end says more than those that only touch it.
      for (std::size_t i = 0; i < surface.outline.size(); ++i) {
        const Vector<2>&from = surface.outline[i], &to = surface.outline[(i + 1) % surface.outline.size()];
        if (std::max(std::abs(from[n] - at), std::abs(to[n] - at)) <= slack) surface.edges[n][end] = surface.sides[i];
      }
    }
}

}  // namespace

template <int D>
SurfacePlace<D> MidSurface<D>::at(const std::array<double, D - 1>& s) const {
  SurfacePlace<D> place{origin, axes};
  if (kind == Kind::flat || kind == Kind::plate) {
    for (int n = 0; n < D - 1; ++n) place.position += s[n] * axes.col(n);
    return place;
  }
  Vector<D> along = Vector<D>::Zero();
  if (kind == Kind::round) {
    const double angle = begin + s[D - 2] / radius;
    const Vector<D>&first = axes.col(D - 2), &second = axes.col(D - 1);
    along = std::cos(angle) * second - std::sin(angle) * first;
    place.position += radius * (std::cos(angle) * first + std::sin(angle) * second);
    if (D == 3) place.position += s[0] * axes.col(0);
  } else {
    const double total = corner_at.back();
    const auto point = [&](double at) {
      if (closed[0]) at -= total * std::floor(at / total);
      const auto next = std::upper_bound(corner_at.begin() + 1, corner_at.end() - 1, at) - corner_at.begin();
      const double share = (at - corner_at[next - 1]) / (corner_at[next] - corner_at[next - 1]);
      return Vector<D>(corners[next - 1] + std::clamp(share, 0.0, 1.0) * (corners[next] - corners[next - 1]));
    };
    place.position = point(s[0]);
    along = (point(s[0] + reach) - point(s[0] - reach)).normalized();
  }
  place.frame.col(D - 2) = along;
  if constexpr (D == 2)
    place.frame.col(1) << -along[1], along[0];
  else
    place.frame.col(2) = place.frame.col(0).cross(along);
  return place;
}

template <int D>
Vector<D> MidSurface<D>::foot(const Vector<D>& x) const {
  if (kind == Kind::flat || kind == Kind::plate) return x - (x - origin).dot(axes.col(D - 1)) * axes.col(D - 1);
  if (kind == Kind::ball || kind == Kind::round) {
    Vector<D> out = x - origin;  // from the centre, of a tube from its axis
    if (D == 3 && kind == Kind::round) out -= out.dot(axes.col(0)) * axes.col(0);
    const double distance = out.norm();
    return x + (distance > 0 ? Vector<D>((radius / distance - 1) * out) : Vector<D>(radius * axes.col(D - 1)));
  }
  Vector<D> nearest = corners.front();
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Vector<D> along = corners[i] - corners[i - 1], from = x - corners[i - 1];
    const Vector<D> place = corners[i - 1] + std::clamp(from.dot(along) / along.squaredNorm(), 0.0, 1.0) * along;
    if ((x - place).squaredNorm() < (x - nearest).squaredNorm()) nearest = place;
  }
  return nearest;
}

namespace {

/// Refuses a path that turns too much within a spacing.
template <int D>
void check_corners(const StructureBody& body, const MidSurface<D>& surface) {
  const double dx = surface.spacing(0), inset = surface.closed[0] ? 0 : dx;
  double largest = 0;
  Vector<D> where = Vector<D>::Zero();
  for (double s = surface.low[0] + inset; s <= surface.high[0] - inset; s += 0.25 * dx) {
    const Vector<D> x = surface.at({s}).position, before = x - surface.at({s - dx}).position, after = surface.at({s + dx}).position - x;
    const double turn = std::acos(std::clamp(before.dot(after) / (before.norm() * after.norm()), -1.0, 1.0));
    if (turn > largest) largest = turn, where = x;
  }
  constexpr double degree = std::numbers::pi / 180;
  if (largest > largest_turn * (1 + round_off))
    throw BadInput(
        fmt::format("The shell '{}' turns by {:.0f} degrees within a spacing, {:.3g} m, at ({:.4g}, {:.4g}) m, but can by {:.0f} at most: "
                    "round the corner off, with more than {:.3g} m, use a smaller spacing, or make two bodies of it.",
                    body.name, largest / degree, dx, where[0], where[1], largest_turn / degree, dx / largest_turn));
}

/// Particles on a ball that are farther apart than what bends under a load on a point, sqrt(R t), answer to every other load that is not
/// quite even by bending alone: six times as much as they should at 0.8 of that.
template <int D>
void check_ball(const StructureBody& body, const MidSurface<D>& surface) {
  const double bends = std::sqrt(surface.radius * surface.thickness);
  if (surface.spacing(0) > bends * (1 + round_off))
    throw BadInput(fmt::format(
        "The shell '{}' has particles {:.3g} m apart on a ball, but what bends on it is sqrt(radius x thickness) = {:.3g} m long: "
        "it would be too soft. Use a spacing of at most {:.3g} m.",
        body.name, surface.spacing(0), bends, 0.93 * bends));
}

}  // namespace

template <int D>
MidSurface<D> mid_surface(const StructureBody& body) {
  using Kind = typename MidSurface<D>::Kind;
  MidSurface<D> surface = bare_surface<D>(body);
  if (surface.kind == Kind::ball && !body.clamps.empty())
    throw BadInput(
        fmt::format("The shell '{}' is a ball, which has no edge that a clamp or hinge could hold. Leave them out, or model it as a "
                    "solid.",
                    body.name));
  if constexpr (D == 3)
    if (surface.kind == Kind::plate) {
      for (const Shape& clamp : body.rigid_clamps()) hold_sides(body, clamp, EdgeKind::clamp, surface);
      for (const Shape& region : body.hinges) hold_sides(body, region, EdgeKind::hinge, surface);
      mark_ends(surface);
    }
  if (surface.kind != Kind::plate) {
    for (const Shape& clamp : body.rigid_clamps())
      surface.kind == Kind::flat ? clamp_box(body, clamp, surface) : clamp_bent(body, clamp, surface);
    for (const Shape& region : body.hinges) hinge(body, region, surface);
  }
  for (int n = 0; n < D - 1; ++n) {
    const double held = 0.5 * surface.held_ends(n), length = surface.length(n);
    surface.count[n] = static_cast<int>(std::lround(length / (surface.kind == Kind::ball ? surface.spacing(n) : body.spacing) - held));
    int least = 4;
    if (surface.kind == Kind::ball || (surface.kind == Kind::round && n == D - 2))
      least = std::max(least, static_cast<int>(std::ceil(length / (surface.radius * largest_turn) - held - round_off)));
    if (surface.count[n] < least)
      throw BadInput(fmt::format(
          "The shell '{}' has {} free particles over {:.3g} m {}, but needs at least {} (15 for an error of "
          "6 % in bending); use a spacing of at most {:.3g} m.",
          body.name, std::max(surface.count[n], 0), length, direction_of(surface, n), least, std::max(length, 0.0) / (least + held)));
  }
  if (surface.kind == Kind::path) check_corners(body, surface);
  if (surface.kind == Kind::ball) check_ball(body, surface);
  return surface;
}

namespace {

/// The cells of a sphere of radius 1.
std::vector<SurfaceCell<3>> cells_of_sphere(int parts) {
  const GeodesicSphere sphere = geodesic_sphere(parts);
  std::vector<SurfaceCell<3>> cells;
  for (std::size_t k = 0; k < sphere.corner.size(); ++k) {
    SurfaceCell<3> cell{{sphere.corner[k], {}}, sphere.area[k], EdgeKind::free};
    int least = 0;
    sphere.corner[k].cwiseAbs().minCoeff(&least);
    const Vector<3> normal = sphere.corner[k], first = Vector<3>::Unit(least).cross(normal).normalized();
    cell.place.frame << first, normal.cross(first), normal;
    cells.push_back(cell);
  }
  return cells;
}

/// Places along the held sides of a plate. Those between two sharp corners, or of one kind, are divided evenly as a whole: from corner
/// to corner where other held sides go on, half a spacing inside where a free one does.
void add_held(const MidSurface<3>& surface, double spacing, std::vector<Vector<2>>& places, std::vector<EdgeKind>& kinds) {
  const Outline& outline = surface.outline;
  const std::size_t count = outline.size();
  const auto corner = [&](std::size_t i) { return outline[i % count]; };
  const auto side = [&](std::size_t i) { return surface.sides[i % count]; };
  const auto is_break = [&](std::size_t i) {
    const Vector<2> before = corner(i) - corner(i + count - 1), after = corner(i + 1) - corner(i);
    const double turn = std::acos(std::clamp(before.dot(after) / (before.norm() * after.norm()), -1.0, 1.0));
    return side(i) != side(i + count - 1) || turn > largest_turn * (1 + round_off);
  };
  std::size_t first = 0;
  while (first < count && !is_break(first)) ++first;
  const bool is_loop = first == count;
  if (is_loop) first = 0;
  for (std::size_t i = first; i < first + count;) {
    std::size_t last = i + 1;  // the corner where the piece ends
    std::vector<double> at{0, (corner(i + 1) - corner(i)).norm()};
    for (; last < first + count && !is_break(last); ++last) at.push_back(at.back() + (corner(last + 1) - corner(last)).norm());
    const EdgeKind kind = side(i);
    if (kind != EdgeKind::free) {
      const EdgeKind before = side(i + count - 1), after = side(last);
      const double ends = is_loop ? 0 : 0.5 * ((before != EdgeKind::free) + (after != EdgeKind::free));
      const long pieces = std::max(1L, std::lround(at.back() / spacing - ends));
      const double step = at.back() / (static_cast<double>(pieces) + ends);
      const bool on_corner = is_loop || before != EdgeKind::free;
      const long number = pieces + (!is_loop && before != EdgeKind::free);  // not the last corner: the next piece begins there
      for (long k = 0; k < number; ++k) {
        const double s = (static_cast<double>(k) + (on_corner ? 0 : 0.5)) * step;
        const auto next = std::upper_bound(at.begin() + 1, at.end() - 1, s) - at.begin();
        const double share = (s - at[next - 1]) / (at[next] - at[next - 1]);
        const std::size_t from = i + static_cast<std::size_t>(next) - 1;
        places.push_back(corner(from) + share * (corner(from + 1) - corner(from)));
        kinds.push_back(k == 0 && on_corner ? std::max(kind, before) : kind);
      }
    }
    i = last;
  }
}

std::vector<SurfaceCell<3>> cells_of_plate(const MidSurface<3>& surface) {
  const double spacing = std::sqrt(surface.spacing(0) * surface.spacing(1));
  std::vector<Vector<2>> places;
  std::vector<EdgeKind> kinds;
  add_held(surface, spacing, places, kinds);
  for (int b = 0; b < surface.count[1] + surface.held_ends(1); ++b)
    for (int a = 0; a < surface.count[0] + surface.held_ends(0); ++a) {
      const std::array<int, 2> index{a, b};
      Vector<2> s;
      for (int n = 0; n < 2; ++n)
        s[n] = surface.low[n] + (index[n] + (surface.edges[n][0] == EdgeKind::free ? 0.5 : 0)) * surface.spacing(n);
      bool is_kept = polygon_distance(surface.outline, s[0], s[1]) <= round_off * spacing;
      for (std::size_t i = 0; i < surface.sides.size() && is_kept; ++i)
        if (surface.sides[i] != EdgeKind::free)
          is_kept = distance_to_side(surface.outline[i], surface.outline[(i + 1) % surface.sides.size()], s[0], s[1]) > 0.5 * spacing;
      if (!is_kept) continue;
      places.push_back(s);
      kinds.push_back(EdgeKind::free);
    }
  std::vector<double> areas = cell_areas(surface.outline, places, spacing);
  const auto is_small = [&](std::size_t i) { return kinds[i] == EdgeKind::free && areas[i] < 0.25 * (1 - round_off) * spacing * spacing; };
  std::size_t kept = 0;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (!is_small(i)) places[kept] = places[i], kinds[kept++] = kinds[i];
  if (kept < places.size()) {
    places.resize(kept), kinds.resize(kept);
    areas = cell_areas(surface.outline, places, spacing);
  }
  std::vector<SurfaceCell<3>> cells;
  for (std::size_t i = 0; i < places.size(); ++i) cells.push_back({surface.at({places[i][0], places[i][1]}), areas[i], kinds[i]});
  return cells;
}

}  // namespace

template <int D>
std::vector<SurfaceCell<D>> cells_of(const MidSurface<D>& surface) {
  if constexpr (D == 3)
    if (surface.kind == MidSurface<D>::Kind::ball) {
      std::vector<SurfaceCell<D>> cells = cells_of_sphere(surface.parts);
      for (SurfaceCell<D>& cell : cells) {
        cell.place.position = surface.origin + surface.radius * cell.place.position;
        cell.area *= surface.radius * surface.radius;
      }
      return cells;
    }
  if constexpr (D == 3)
    if (surface.kind == MidSurface<D>::Kind::plate) return cells_of_plate(surface);
  std::array<int, 2> size{1, 1};
  for (int a = 0; a < D - 1; ++a) size[a] = surface.count[a] + surface.held_ends(a);
  std::vector<SurfaceCell<D>> cells;
  for (int n = 0; n < size[0] * size[1]; ++n) {
    const std::array<int, 2> index{n % size[0], n / size[0]};
    std::array<double, D - 1> s{};
    SurfaceCell<D> cell{{}, 1, EdgeKind::free};
    for (int a = 0; a < D - 1; ++a) {
      s[a] = surface.low[a] + (index[a] + (surface.edges[a][0] == EdgeKind::free ? 0.5 : 0)) * surface.spacing(a);
      cell.area *= surface.spacing(a);
      const int end = index[a] == 0 ? 0 : index[a] == size[a] - 1 ? 1 : -1;
      if (end < 0 || surface.edges[a][end] == EdgeKind::free) continue;
      cell.area *= 0.5;
      cell.edge = std::max(cell.edge, surface.edges[a][end]);
    }
    cell.place = surface.at(s);
    cells.push_back(cell);
  }
  return cells;
}

namespace {

/// What is known of a strip by how its ends are held.
struct StripKind {
  const char* held;
  double shear;    ///< deflection by shear over that by bending, in E'/G (t/L)^2
  double spacing;  ///< deflection that the spacing adds, times the squared number of particles; measured
};

// Of a strip of length L under a uniform load, with the rigidity E' t^3/12 and the shear stiffness 5/6 G t, at the end of a cantilever or
// where it sags most. A strip that is free at one end, or both, and not clamped at the other bends as between supports.
// A ring bends in four half waves; its curvature, not its slope, is what the spacing makes it too stiff by.
StripKind strip_kind(const std::array<EdgeKind, 2>& edges, bool closed) {
  if (closed) return {"round a quarter of it", 0.96, -52};
  const int clamps = (edges[0] == EdgeKind::clamp) + (edges[1] == EdgeKind::clamp);
  const int hinges = (edges[0] == EdgeKind::hinge) + (edges[1] == EdgeKind::hinge);
  if (clamps == 2) return {"between two clamps", 4.8, 13};
  if (clamps == 1 && hinges == 1) return {"between a clamp and a hinge", 2.65, 5};
  if (clamps == 1) return {"from its clamp on", 0.4, 0.4};
  if (hinges == 2) return {"between two hinges", 0.96, 2};
  return {hinges == 1 ? "from its hinge on" : "from edge to edge", 0.96, 0.4};
}

}  // namespace

template <int D>
ShellFit shell_fit(const StructureBody& body) {
  const MidSurface<D> surface = mid_surface<D>(body);
  const double nu = body.poisson_ratio, modulus_over_shear = D == 2 && body.plane_stress ? 2 * (1 + nu) : 2 / (1 - nu);
  const auto is_held = [&surface](int n) {
    return surface.closed[n] || surface.edges[n][0] != EdgeKind::free || surface.edges[n][1] != EdgeKind::free;
  };
  bool any_held = false;
  for (int n = 0; n < D - 1; ++n) any_held = any_held || is_held(n);
  ShellFit worst;
  for (int n = 0; n < D - 1; ++n) {
    if (any_held && !is_held(n)) continue;  // it bends along what is held
    const StripKind kind = strip_kind(surface.edges[n], surface.closed[n]);
    ShellFit fit;
    fit.thickness = surface.thickness;
    fit.length = surface.length(n) * (surface.closed[n] ? 0.25 : 1);
    fit.held = kind.held;
    fit.count = surface.count[n];
    fit.without_shear = kind.shear * modulus_over_shear * std::pow(fit.thickness / fit.length, 2);
    fit.by_spacing = kind.spacing / std::pow(fit.count, 2);
    fit.wanted_particles = std::max(18.0, std::sqrt(std::abs(kind.spacing) / 0.015));
    if (surface.kind == MidSurface<D>::Kind::ball) {  // in its first motion, measured
      const double share = surface.spacing(n) / std::sqrt(surface.radius * surface.thickness);
      fit.by_spacing = 0.05 * std::pow(share, 4);
      fit.wanted_particles = 1.45 * fit.length / std::sqrt(surface.radius * surface.thickness);
    }
    if (worst.count == 0 || fit.without_shear + std::abs(fit.by_spacing) > worst.without_shear + std::abs(worst.by_spacing)) worst = fit;
  }
  return worst;
}

template <int D>
LatticePoints<D> fill_body(const StructureBody& body) {
  if (!body.is_shell) {
    const LatticePoints<D> points = fill_lattice<D>(body.shape, body.spacing);
    return body.shape.kind == Shape::Kind::box ? points : without_loose_particles<D>(points);  // a box has no loose ones
  }
  LatticePoints<D> points(bounding_box<D>(body.shape).min, Vector<D>::Constant(body.spacing));
  for (const SurfaceCell<D>& cell : cells_of(mid_surface<D>(body))) points.add_off_lattice(cell.place.position);
  return points;
}

template <int D>
double free_length(const StructureBody& body) {
  double longest = 0;
  if (body.is_shell) {
    const MidSurface<D> surface = mid_surface<D>(body);
    for (int n = 0; n < D - 1; ++n) longest = std::max(longest, surface.length(n) * (surface.closed[n] ? 0.25 : 1));
    return longest;
  }
  const Vector<D> half = Vector<D>::Constant(0.5 * body.spacing);
  Vector<D> low = Vector<D>::Constant(1e300), high = -low;
  for (const Vector<D>& x : fill_lattice<D>(body.shape, body.spacing)) {
    if (std::any_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& clamp) { return contains<D>(clamp, x); })) continue;
    low = low.cwiseMin(x - half), high = high.cwiseMax(x + half);
  }
  return (high - low).maxCoeff();
}

#define TERN_INSTANTIATE(D)                                               \
  template struct MidSurface<D>;                                          \
  template MidSurface<D> mid_surface<D>(const StructureBody&);            \
  template std::vector<SurfaceCell<D>> cells_of<D>(const MidSurface<D>&); \
  template ShellFit shell_fit<D>(const StructureBody&);                   \
  template LatticePoints<D> fill_body<D>(const StructureBody&);           \
  template double free_length<D>(const StructureBody&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern
