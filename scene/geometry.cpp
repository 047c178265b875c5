// Solids as signed functions: negative inside, zero on the boundary, positive outside.
//   box, ball, polygon, ring, line, tube, plate: the signed distance;  union: min over parts;  difference: max(first, -others).

#include "scene/geometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/plane_polygon.hpp"

namespace tern {
namespace {

constexpr double along_coordinates = 1e-6;  ///< rad
constexpr double round_off = 1e-6;          // in spacings: sides given in decimal are whole multiples only to round-off

/// Of a product: `across` and `along` are the signed distances to two sets whose boundaries are at right angles.
double distance_to_product(double across, double along) {
  if (across > 0 && along > 0) return std::hypot(across, along);
  return std::max(across, along);
}

/// x and y of a ring; of a tube the coordinates across its axis.
template <int D>
std::array<double, 2> in_plane(const Shape& shape, const Vector<D>& x) {
  const int first = D == 2 ? 0 : (shape.axis + 1) % 3, second = D == 2 ? 1 : (shape.axis + 2) % 3;
  return {x[first] - shape.center[first], x[second] - shape.center[second]};
}

bool is_whole_ring(const Shape& shape) { return shape.end - shape.begin >= Shape::whole_turn * (1 - 1e-12); }

/// x and y from the centre.
double ring_distance(const Shape& shape, double x, double y) {
  const double across = std::abs(std::hypot(x, y) - shape.radius) - 0.5 * shape.thickness;
  if (is_whole_ring(shape)) return across;
  // From the middle of the arc: the nearer end is where the angle has the same sign.
  const double middle = 0.5 * (shape.begin + shape.end), half = 0.5 * (shape.end - shape.begin);
  const double u = x * std::cos(middle) + y * std::sin(middle), v = std::abs(-x * std::sin(middle) + y * std::cos(middle));
  const double angle = std::atan2(v, u);
  const double beyond = v * std::cos(half) - u * std::sin(half);    // distance from the plane of the end
  const double outwards = u * std::cos(half) + v * std::sin(half);  // along it, from the centre
  const double of_end = std::abs(outwards - shape.radius) - 0.5 * shape.thickness;
  if (angle > half) return of_end > 0 ? std::hypot(of_end, beyond) : std::abs(beyond);
  if (across > 0) return across;
  return std::max(across, outwards > 0 ? beyond : across);
}

double line_distance(const Shape& shape, double x, double y) {
  const std::size_t count = shape.vertices.size(), segments = shape.closed ? count : count - 1;
  double nearest = std::numeric_limits<double>::max(), beyond = 0, across = 0, inner_end = std::numeric_limits<double>::max();
  bool is_past = false;
  for (std::size_t i = 0; i < segments; ++i) {
    const auto &a = shape.vertices[i], &b = shape.vertices[(i + 1) % count];
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]), ex = (b[0] - a[0]) / length, ey = (b[1] - a[1]) / length;
    const double along = (x - a[0]) * ex + (y - a[1]) * ey, off = std::abs(-(x - a[0]) * ey + (y - a[1]) * ex);
    const bool before = !shape.closed && i == 0 && along < 0, after = !shape.closed && i + 1 == segments && along > length;
    const double distance = std::hypot(std::max({0.0, -along, along - length}), off);
    if (!shape.closed && off <= 0.5 * shape.thickness && along >= 0 && along <= length) {
      if (i == 0) inner_end = std::min(inner_end, along);
      if (i + 1 == segments) inner_end = std::min(inner_end, length - along);
    }
    if (distance >= nearest) continue;
    nearest = distance;
    is_past = before || after;
    beyond = before ? -along : along - length;
    across = off - 0.5 * shape.thickness;
  }
  if (is_past) return across > 0 ? std::hypot(across, beyond) : beyond;
  const double side = nearest - 0.5 * shape.thickness;
  return side < 0 ? std::max(side, -inner_end) : side;
}

/// In the plane of a plate, and over it.
std::array<double, 3> in_plate(const Shape& shape, const Vector<3>& x, bool is_direction = false) {
  std::array<double, 3> s{};
  for (int a = 0; a < 3; ++a)
    for (int d = 0; d < 3; ++d) s[a] += shape.axes[a][d] * (x[d] - (is_direction ? 0 : shape.center[d]));
  return s;
}

template <int D>
double thin_distance(const Shape& shape, const Vector<D>& x) {
  if (shape.kind == Shape::Kind::line) return line_distance(shape, x[0], x[1]);
  if constexpr (D == 3)
    if (shape.kind == Shape::Kind::plate) {
      const auto [u, v, w] = in_plate(shape, x);
      return distance_to_product(polygon_distance(shape.vertices, u, v), std::abs(w) - 0.5 * shape.thickness);
    }
  const auto [u, v] = in_plane<D>(shape, x);
  const double across = ring_distance(shape, u, v);
  if (D == 2) return across;
  return distance_to_product(across, std::abs(x[shape.axis] - shape.center[shape.axis]) - 0.5 * shape.length);
}

/// Where a ray from x with this direction meets the line through `a` along `e`, both in the plane.
void add_crossing(double ax, double ay, double ex, double ey, double x, double y, double dx, double dy, std::vector<double>& at) {
  const double rate = ey * dx - ex * dy;
  if (rate != 0) at.push_back((ey * (ax - x) - ex * (ay - y)) / rate);
}

template <int D>
void add_crossings_of_thin(const Shape& shape, const Vector<D>& x, const Vector<D>& direction, std::vector<double>& at) {
  if (shape.kind == Shape::Kind::line) {
    const std::size_t count = shape.vertices.size(), segments = shape.closed ? count : count - 1;
    for (std::size_t i = 0; i < segments; ++i) {
      const auto &a = shape.vertices[i], &b = shape.vertices[(i + 1) % count];
      const double length = std::hypot(b[0] - a[0], b[1] - a[1]), ex = (b[0] - a[0]) / length, ey = (b[1] - a[1]) / length;
      for (const double z : {-0.5 * shape.thickness, 0.5 * shape.thickness})
        add_crossing(a[0] - z * ey, a[1] + z * ex, ex, ey, x[0], x[1], direction[0], direction[1], at);
      for (const auto& end : {a, b}) add_crossing(end[0], end[1], -ey, ex, x[0], x[1], direction[0], direction[1], at);
    }
    return;
  }
  if constexpr (D == 3)
    if (shape.kind == Shape::Kind::plate) {
      const auto [u, v, w] = in_plate(shape, x);
      const auto [du, dv, dw] = in_plate(shape, direction, true);
      for (std::size_t i = 0, j = shape.vertices.size() - 1; i < shape.vertices.size(); j = i++) {
        const auto &a = shape.vertices[j], &b = shape.vertices[i];
        add_crossing(a[0], a[1], b[0] - a[0], b[1] - a[1], u, v, du, dv, at);
      }
      for (const double z : {-0.5 * shape.thickness, 0.5 * shape.thickness})
        if (dw != 0) at.push_back((z - w) / dw);
      return;
    }
  const auto [u, v] = in_plane<D>(shape, x);
  const int first = D == 2 ? 0 : (shape.axis + 1) % 3, second = D == 2 ? 1 : (shape.axis + 2) % 3;
  const double du = direction[first], dv = direction[second], squared = du * du + dv * dv;
  for (const double z : {-0.5 * shape.thickness, 0.5 * shape.thickness}) {
    const double half = u * du + v * dv, root = half * half - squared * (u * u + v * v - std::pow(shape.radius + z, 2));
    if (squared == 0 || root < 0) continue;
    at.push_back((-half - std::sqrt(root)) / squared);
    at.push_back((-half + std::sqrt(root)) / squared);
  }
  if (!is_whole_ring(shape))
    for (const double angle : {shape.begin, shape.end}) add_crossing(0, 0, std::cos(angle), std::sin(angle), u, v, du, dv, at);
  if (D == 3 && direction[shape.axis] != 0)
    for (const double end : {-0.5, 0.5})
      at.push_back((shape.center[shape.axis] + end * shape.length - x[shape.axis]) / direction[shape.axis]);
}

template <int D>
Bounds<D> bounds_of_thin(const Shape& shape) {
  Bounds<D> bounds;
  if constexpr (D == 3)
    if (shape.kind == Shape::Kind::plate) {
      bounds.min.setConstant(std::numeric_limits<double>::max());
      bounds.max = -bounds.min;
      for (const auto& corner : shape.corners)
        for (int d = 0; d < 3; ++d) {
          const double half = 0.5 * shape.thickness * std::abs(shape.axes[2][d]);
          bounds.min[d] = std::min(bounds.min[d], corner[d] - half);
          bounds.max[d] = std::max(bounds.max[d], corner[d] + half);
        }
      return bounds;
    }
  if (shape.kind == Shape::Kind::line) {
    bounds.min.setConstant(std::numeric_limits<double>::max());
    bounds.max = -bounds.min;
    for (const auto& vertex : shape.vertices)
      for (int d = 0; d < 2; ++d) {
        bounds.min[d] = std::min(bounds.min[d], vertex[d] - 0.5 * shape.thickness);
        bounds.max[d] = std::max(bounds.max[d], vertex[d] + 0.5 * shape.thickness);
      }
    return bounds;
  }
  const int first = D == 2 ? 0 : (shape.axis + 1) % 3, second = D == 2 ? 1 : (shape.axis + 2) % 3;
  for (int d = 0; d < D; ++d) bounds.min[d] = bounds.max[d] = shape.center[d];
  if (D == 3) bounds.min[shape.axis] -= 0.5 * shape.length, bounds.max[shape.axis] += 0.5 * shape.length;
  std::vector<double> angles{shape.begin, shape.end};
  for (double quarter = std::ceil(shape.begin / (0.25 * Shape::whole_turn)); quarter * 0.25 * Shape::whole_turn < shape.end; ++quarter)
    angles.push_back(quarter * 0.25 * Shape::whole_turn);
  bool is_first = true;
  for (const double angle : angles)
    for (const double r : {shape.radius - 0.5 * shape.thickness, shape.radius + 0.5 * shape.thickness}) {
      const double u = shape.center[first] + r * std::cos(angle), v = shape.center[second] + r * std::sin(angle);
      bounds.min[first] = is_first ? u : std::min(bounds.min[first], u);
      bounds.max[first] = is_first ? u : std::max(bounds.max[first], u);
      bounds.min[second] = is_first ? v : std::min(bounds.min[second], v);
      bounds.max[second] = is_first ? v : std::max(bounds.max[second], v);
      is_first = false;
    }
  return bounds;
}

template <int D>
void add_ray_crossings(const Shape& shape, const Vector<D>& x, const Vector<D>& direction, std::vector<double>& at) {
  switch (shape.kind) {
    case Shape::Kind::box:
      for (int d = 0; d < D; ++d) {
        if (direction[d] == 0) continue;
        at.push_back((shape.min[d] - x[d]) / direction[d]);
        at.push_back((shape.max[d] - x[d]) / direction[d]);
      }
      return;
    case Shape::Kind::polygon:
      for (std::size_t i = 0, j = shape.vertices.size() - 1; i < shape.vertices.size(); j = i++) {
        const auto& a = shape.vertices[j];
        const auto& b = shape.vertices[i];
        const double nx = b[1] - a[1], ny = a[0] - b[0];
        const double rate = nx * direction[0] + ny * direction[1];
        if (rate != 0) at.push_back((nx * (a[0] - x[0]) + ny * (a[1] - x[1])) / rate);
      }
      return;
    case Shape::Kind::ball: {
      Vector<D> offset = x;
      for (int d = 0; d < D; ++d) offset[d] -= shape.center[d];
      const double half = offset.dot(direction);
      const double root = half * half - offset.squaredNorm() + shape.radius * shape.radius;
      if (root < 0) return;
      at.push_back(-half - std::sqrt(root));
      at.push_back(-half + std::sqrt(root));
      return;
    }
    case Shape::Kind::ring:
    case Shape::Kind::line:
    case Shape::Kind::tube:
    case Shape::Kind::plate: return add_crossings_of_thin<D>(shape, x, direction, at);
    case Shape::Kind::union_of:
    case Shape::Kind::difference:
      for (const Shape& part : shape.parts) add_ray_crossings<D>(part, x, direction, at);
  }
}

}  // namespace

Shape plate_shape(std::vector<std::array<double, 3>> corners, double thickness) {
  Shape plate;
  plate.kind = Shape::Kind::plate;
  plate.thickness = thickness;
  plate.corners = std::move(corners);
  const std::size_t count = plate.corners.size();
  const auto corner = [&](std::size_t i) {
    const auto& x = plate.corners[i % count];
    return Vector<3>(x[0], x[1], x[2]);
  };
  const Vector<3> from = corner(0);
  Vector<3> normal = Vector<3>::Zero(), along = Vector<3>::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    normal += (corner(i) - from).cross(corner(i + 1) - from);
    const Vector<3> side = corner(i + 1) - corner(i);
    if (side.norm() > along.norm() * (1 + round_off)) along = side;
  }
  if (normal.norm() <= round_off * along.squaredNorm()) return plate;
  normal.normalize();
  along = (along - along.dot(normal) * normal).normalized();
  const Vector<3> across = normal.cross(along);
  for (int d = 0; d < 3; ++d) {
    plate.center[d] = from[d];
    plate.axes[0][d] = along[d], plate.axes[1][d] = across[d], plate.axes[2][d] = normal[d];
  }
  for (std::size_t i = 0; i < count; ++i) plate.vertices.push_back({along.dot(corner(i) - from), across.dot(corner(i) - from)});
  return plate;
}

template <int D>
double signed_distance(const Shape& shape, const Vector<D>& x) {
  switch (shape.kind) {
    case Shape::Kind::box: {
      double inner = -std::numeric_limits<double>::max(), outer = 0;
      for (int d = 0; d < D; ++d) {
        const double beyond = std::max(shape.min[d] - x[d], x[d] - shape.max[d]);
        inner = std::max(inner, beyond);
        outer += std::pow(std::max(beyond, 0.0), 2);
      }
      return outer > 0 ? std::sqrt(outer) : inner;
    }
    case Shape::Kind::polygon: return polygon_distance(shape.vertices, x[0], x[1]);
    case Shape::Kind::ball: {
      double squared = 0;
      for (int d = 0; d < D; ++d) squared += std::pow(x[d] - shape.center[d], 2);
      return std::sqrt(squared) - shape.radius;
    }
    case Shape::Kind::ring:
    case Shape::Kind::line:
    case Shape::Kind::tube:
    case Shape::Kind::plate: return thin_distance<D>(shape, x);
    case Shape::Kind::union_of: {
      double value = std::numeric_limits<double>::max();
      for (const Shape& part : shape.parts) value = std::min(value, signed_distance<D>(part, x));
      return value;
    }
    case Shape::Kind::difference: {
      double value = signed_distance<D>(shape.parts.front(), x);
      for (std::size_t i = 1; i < shape.parts.size(); ++i) {
        value = std::max(value, -signed_distance<D>(shape.parts[i], x));
      }
      return value;
    }
  }
  return 0;
}

template <int D>
Bounds<D> bounding_box(const Shape& shape) {
  Bounds<D> bounds;
  switch (shape.kind) {
    case Shape::Kind::box:
      for (int d = 0; d < D; ++d) bounds.min[d] = shape.min[d], bounds.max[d] = shape.max[d];
      break;
    case Shape::Kind::polygon:
      bounds.min.setZero(), bounds.max.setZero();
      for (int d = 0; d < 2; ++d) {
        const auto [low, high] =
            std::minmax_element(shape.vertices.begin(), shape.vertices.end(), [d](const auto& a, const auto& b) { return a[d] < b[d]; });
        bounds.min[d] = (*low)[d], bounds.max[d] = (*high)[d];
      }
      break;
    case Shape::Kind::ball:
      for (int d = 0; d < D; ++d) {
        bounds.min[d] = shape.center[d] - shape.radius;
        bounds.max[d] = shape.center[d] + shape.radius;
      }
      break;
    case Shape::Kind::ring:
    case Shape::Kind::line:
    case Shape::Kind::tube:
    case Shape::Kind::plate: return bounds_of_thin<D>(shape);
    case Shape::Kind::union_of:
      bounds = bounding_box<D>(shape.parts.front());
      for (const Shape& part : shape.parts) {
        const Bounds<D> other = bounding_box<D>(part);
        bounds.min = bounds.min.cwiseMin(other.min);
        bounds.max = bounds.max.cwiseMax(other.max);
      }
      break;
    case Shape::Kind::difference: bounds = bounding_box<D>(shape.parts.front()); break;
  }
  return bounds;
}

template <int D>
bool contains(const Shape& shape, const Vector<D>& x) {
  const Bounds<D> bounds = bounding_box<D>(shape);
  return signed_distance<D>(shape, x) <= 1e-12 * (bounds.max - bounds.min).maxCoeff();
}

namespace {

/// Whole spacings in a length.
long cells_in(double length, double spacing) { return static_cast<long>(std::floor(length / spacing + 0.5 + round_off)); }

/// How many more points of a row, `step` apart, are on the same side of the level as one whose signed distance is off it by so much: no
/// signed distance changes faster than its point moves.
long same_side(double off_level, double step) {
  constexpr double most = 1e9;
  return static_cast<long>(std::min(most, std::max(0.0, std::ceil(std::abs(off_level) / step - round_off) - 1)));
}

/// Bounds of the shape in the directions of these axes.
template <int D>
Bounds<D> bounds_along(const Shape& shape, const Matrix<D>& axes) {
  if (axes == Matrix<D>::Identity()) return bounding_box<D>(shape);
  Bounds<D> bounds;
  bounds.min.setConstant(std::numeric_limits<double>::max());
  bounds.max = -bounds.min;
  const auto add = [&](const Vector<D>& x, const Vector<D>& margin) {
    const Vector<D> along = axes.transpose() * x;
    bounds.min = bounds.min.cwiseMin(along - margin);
    bounds.max = bounds.max.cwiseMax(along + margin);
  };
  if constexpr (D == 3)
    if (shape.kind == Shape::Kind::plate) {
      for (const auto& corner : shape.corners)
        add({corner[0], corner[1], corner[2]},
            0.5 * shape.thickness * (axes.transpose() * Vector<3>(shape.axes[2][0], shape.axes[2][1], shape.axes[2][2])).cwiseAbs());
      return bounds;
    }
  if constexpr (D == 2)
    if (shape.kind == Shape::Kind::polygon || shape.kind == Shape::Kind::line) {
      const double margin = shape.kind == Shape::Kind::line ? 0.5 * shape.thickness : 0;
      for (const auto& vertex : shape.vertices) add({vertex[0], vertex[1]}, Vector<2>::Constant(margin));
      return bounds;
    }
  if (shape.kind == Shape::Kind::difference) return bounds_along<D>(shape.parts.front(), axes);
  if (shape.kind == Shape::Kind::union_of) {
    for (const Shape& part : shape.parts) {
      const Bounds<D> of_part = bounds_along<D>(part, axes);
      bounds.min = bounds.min.cwiseMin(of_part.min);
      bounds.max = bounds.max.cwiseMax(of_part.max);
    }
    return bounds;
  }
  const Bounds<D> box = bounding_box<D>(shape);
  const Vector<D> half = 0.5 * (box.max - box.min);
  if (shape.kind == Shape::Kind::ball)
    add(box.min + half, half);
  else
    add(box.min + half, axes.cwiseAbs().transpose() * half);
  return bounds;
}

/// Points of a lattice along these axes, with these steps from the lowest place of the shape in their directions, inside the shape.
template <int D>
LatticePoints<D> fill(const Shape& shape, const Vector<D>& step, double spacing, const Matrix<D>& axes = Matrix<D>::Identity()) {
  const Bounds<D> bounds = bounds_along<D>(shape, axes);
  std::array<long, 3> count{1, 1, 1};
  for (int d = 0; d < D; ++d) count[d] = cells_in(bounds.max[d] - bounds.min[d], step[d]);
  LatticePoints<D> points(bounds.min, step, axes);
  for (long k = 0; k < count[2]; ++k) {
    for (long j = 0; j < count[1]; ++j) {
      typename LatticePoints<D>::Run run{{0, j, k}, 0};
      for (long i = 0; i < count[0];) {
        const double off = signed_distance<D>(shape, points.at({{i, j, k}, 1}, 0)) - round_off * spacing;
        const long next = std::min(count[0], i + 1 + same_side(off, step[0]));
        if (off <= 0) {
          if (run.count == 0) run.index[0] = i;
          run.count += next - i;
        } else if (run.count > 0) {
          points.add(run);
          run.count = 0;
        }
        i = next;
      }
      if (run.count > 0) points.add(run);
    }
  }
  return points;
}

/// The same points, but those on the faces of the shape a thousandth of a spacing inside. On a face it is up to rounding whether a wall
/// that stands there sees a particle; what it does not see falls through it.
template <int D>
LatticePoints<D> off_the_faces(const LatticePoints<D>& points, const Shape& shape, double spacing) {
  constexpr double depth = 1e-3;
  LatticePoints<D> result = points.without(std::vector<char>(points.size(), true));
  for (const auto& run : points.runs()) {
    typename LatticePoints<D>::Run inside = run;
    inside.count = 0;
    const auto end_run = [&](long next) {
      if (inside.count > 0) result.add(inside);
      inside.index[0] = run.index[0] + next;
      inside.count = 0;
    };
    for (long i = 0; i < run.count;) {
      const Vector<D> x = points.at(run, i);
      const double distance = signed_distance<D>(shape, x);
      if (distance > -round_off * spacing) {
        Vector<D> outward;
        for (int d = 0; d < D; ++d) {
          const Vector<D> way = depth * spacing * Vector<D>::Unit(d);
          outward[d] = signed_distance<D>(shape, Vector<D>(x + way)) - signed_distance<D>(shape, Vector<D>(x - way));
        }
        end_run(i + 1);
        result.add_off_lattice(x - (distance + depth * spacing) * outward.normalized());
        ++i;
      } else {
        const long next = std::min(run.count, i + 1 + same_side(distance + round_off * spacing, points.step()[0]));
        inside.count += next - i;
        i = next;
      }
    }
    end_run(run.count);
  }
  return result;
}

/// The box that a shape is, or is cut out of.
const Shape* box_of(const Shape& shape) {
  if (shape.kind == Shape::Kind::difference) return box_of(shape.parts[0]);
  return shape.kind == Shape::Kind::box ? &shape : nullptr;
}

}  // namespace

template <int D>
Matrix<D> lattice_axes(const Shape& shape) {
  if (shape.kind == Shape::Kind::union_of || shape.kind == Shape::Kind::difference) return lattice_axes<D>(shape.parts.front());
  Matrix<D> axes = Matrix<D>::Identity();
  if constexpr (D == 2) {
    if (shape.kind != Shape::Kind::polygon && shape.kind != Shape::Kind::line) return axes;
    const std::size_t count = shape.vertices.size(), open = shape.kind == Shape::Kind::line && !shape.closed ? 1 : 0;
    Vector<2> longest = Vector<2>::Zero();
    for (std::size_t i = 0; i + open < count; ++i) {
      const auto &a = shape.vertices[i], &b = shape.vertices[(i + 1) % count];
      const Vector<2> side(b[0] - a[0], b[1] - a[1]);
      if (side.norm() > longest.norm() * (1 + round_off)) longest = side;
    }
    constexpr double quarter = 0.25 * Shape::whole_turn;
    const double angle = std::remainder(std::atan2(longest[1], longest[0]), quarter);  // the nearest to the coordinates
    if (std::abs(angle) > along_coordinates) axes << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  } else {
    if (shape.kind != Shape::Kind::plate) return axes;
    for (int a = 0; a < 3; ++a)
      for (int d = 0; d < 3; ++d) axes(d, a) = shape.axes[a][d];
    // Close to a permutation of the coordinates all rows and columns have one number that is not small.
    if ((axes.cwiseAbs().array() > along_coordinates).count() == 3 || axes.isZero()) axes.setIdentity();
  }
  return axes;
}

template <int D>
LatticePoints<D> fill_lattice(const Shape& shape, double spacing) {
  return fill<D>(shape, Vector<D>::Constant(spacing), spacing, lattice_axes<D>(shape));
}

template <int D>
LatticePoints<D> fill_with_fluid(const Shape& shape, double spacing) {
  Vector<D> step = Vector<D>::Constant(spacing);
  if (const Shape* box = box_of(shape))
    for (int d = 0; d < D; ++d) {
      const double length = box->max[d] - box->min[d];
      const long cells = cells_in(length, spacing);
      if (cells > 0 && std::abs(length - static_cast<double>(cells) * spacing) > round_off * spacing)
        step[d] = length / static_cast<double>(cells);
    }
  return off_the_faces(fill<D>(shape, step, spacing), shape, spacing);
}

template <int D>
std::optional<Vector<D>> first_inside(const LatticePoints<D>& points, const Shape& shape, double depth) {
  for (const auto& run : points.runs()) {
    for (long i = 0; i < run.count;) {
      const Vector<D> x = points.at(run, i);
      const double off = signed_distance<D>(shape, x) + depth;
      if (off < 0) return x;
      i += 1 + same_side(off, points.step()[0]);
    }
  }
  return std::nullopt;
}

template <int D>
double fitted_spacing(const std::vector<Shape>& shapes, double spacing) {
  double fitted = spacing;
  constexpr int rounds = 4;  // another spacing may be another number of cells
  for (int round = 0; round < rounds; ++round) {
    double volume = 0, cells = 0;
    for (const Shape& shape : shapes) {
      const Shape* box = box_of(shape);
      if (!box) continue;
      double of_box = 1, in_box = 1;
      for (int d = 0; d < D; ++d) {
        of_box *= box->max[d] - box->min[d];
        in_box *= static_cast<double>(cells_in(box->max[d] - box->min[d], fitted));
      }
      if (in_box > 0) volume += of_box, cells += in_box;
    }
    const double next = cells > 0 ? std::pow(volume / cells, 1.0 / D) : spacing;
    if (std::abs(next - fitted) <= round_off * spacing) break;
    fitted = next;
  }
  return fitted;
}

template <int D>
double thickness(const Shape& shape, const Vector<D>& x, const Vector<D>& normal) {
  const Bounds<D> bounds = bounding_box<D>(shape);
  const double least = 1e-9 * (bounds.max - bounds.min).maxCoeff();
  std::vector<double> at;
  add_ray_crossings<D>(shape, x, -normal, at);
  std::sort(at.begin(), at.end());
  double left = 0;  // the solid is followed through inner boundaries (between the parts of a union) to the far side
  for (const double right : at) {
    if (right - left <= least) continue;
    if (signed_distance<D>(shape, x - 0.5 * (left + right) * normal) > 0) return left;
    left = right;
  }
  return left;
}

template double signed_distance<2>(const Shape&, const Vector<2>&);
template Bounds<2> bounding_box<2>(const Shape&);
template bool contains<2>(const Shape&, const Vector<2>&);
template Matrix<2> lattice_axes<2>(const Shape&);
template LatticePoints<2> fill_lattice<2>(const Shape&, double);
template LatticePoints<2> fill_with_fluid<2>(const Shape&, double);
template std::optional<Vector<2>> first_inside<2>(const LatticePoints<2>&, const Shape&, double);
template double fitted_spacing<2>(const std::vector<Shape>&, double);
template double thickness<2>(const Shape&, const Vector<2>&, const Vector<2>&);
template double signed_distance<3>(const Shape&, const Vector<3>&);
template Bounds<3> bounding_box<3>(const Shape&);
template bool contains<3>(const Shape&, const Vector<3>&);
template Matrix<3> lattice_axes<3>(const Shape&);
template LatticePoints<3> fill_lattice<3>(const Shape&, double);
template LatticePoints<3> fill_with_fluid<3>(const Shape&, double);
template std::optional<Vector<3>> first_inside<3>(const LatticePoints<3>&, const Shape&, double);
template double fitted_spacing<3>(const std::vector<Shape>&, double);
template double thickness<3>(const Shape&, const Vector<3>&, const Vector<3>&);

}  // namespace tern
