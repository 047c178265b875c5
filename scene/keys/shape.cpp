// Shapes, wherever they stand.

#include <fmt/format.h>
#include "base/error.hpp"
#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

// Two sides of a polygon, or of a line, cross or touch other than at a shared corner.
bool crosses_itself(const std::vector<std::array<double, 2>>& v, bool closed = true) {
  const auto turn = [](const auto& a, const auto& b, const auto& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  };
  const std::size_t n = v.size();
  const std::size_t sides = closed ? n : n - 1;
  for (std::size_t i = 0; i < sides; ++i) {
    for (std::size_t j = i + 2; j < sides; ++j) {
      if (closed && i == 0 && j == n - 1) continue;
      const auto &a = v[i], &b = v[i + 1], &c = v[j], &d = v[(j + 1) % n];
      if (turn(a, b, c) * turn(a, b, d) <= 0 && turn(c, d, a) * turn(c, d, b) <= 0 && (turn(a, b, c) != 0 || turn(a, b, d) != 0)) {
        return true;
      }
    }
  }
  return false;
}

template <class Corners>
void check_corners(const Corners& vertices, const char* what, const Setting& table) {
  constexpr std::size_t most_corners = 10000;  // each side is held against each other one
  if (vertices.size() > most_corners)
    throw BadInput(fmt::format("{}: the {} has {} corners, but at most {} are allowed; leave out those that lie nearer than a spacing.",
                               table.where, what, vertices.size(), most_corners));
}

const Rows<Shape>& box_rows() {
  // clang-format off
  static const Rows<Shape> rows = {
      {"min", &Shape::min, "m", required, a_place, "Lower corner."},
      {"max", &Shape::max, "m", required, a_place, "Upper corner."},
  };
  // clang-format on
  return rows;
}

const Rows<Shape>& polygon_rows() {
  // clang-format off
  static const Rows<Shape> rows = {
      {"vertices", &Shape::vertices, "m", required, a_place, "Corners in order, either way round; sides must not cross."},
  };
  // clang-format on
  return rows;
}

const Rows<Shape>& ball_rows() {
  // clang-format off
  static const Rows<Shape> rows = {
      {"center", &Shape::center, "m", required, a_place, "Centre."},
      {"radius", &Shape::radius, "m", required, a_size, "Radius."},
  };
  // clang-format on
  return rows;
}

const Rows<Shape>& ring_rows() {
  // clang-format off
  static const Rows<Shape> rows = {
      {"center", &Shape::center, "m", required, a_place, "Centre."},
      {"radius", &Shape::radius, "m", required, a_size, "Radius, halfway through the thickness."},
      {"thickness", &Shape::thickness, "m", required, a_size, "Thickness."},
      {"begin", &Shape::begin, "rad", absent, an_angle, "Angle from x towards y at which an arc begins; absent = 0."},
      {"end", &Shape::end, "rad", absent, an_angle, "Angle at which it ends; absent = a whole turn."},
  };
  // clang-format on
  return rows;
}

const Rows<Shape>& line_rows() {
  // clang-format off
  static const Rows<Shape> rows = {
      {"vertices", &Shape::vertices, "m", required, a_place, 
       "Corners in order, halfway through the thickness; the line must not cross itself."},
      {"thickness", &Shape::thickness, "m", required, a_size, "Thickness."},
      {"closed", &Shape::closed, "", "false", any, "It goes on from the last corner to the first."},
  };
  // clang-format on
  return rows;
}

const Rows<Shape>& tube_rows() {
  // clang-format off
  static const Rows<Shape> rows = {
      {"center", &Shape::center, "m", required, a_place, "Centre, halfway along the axis."},
      {"axis", one_of(&Shape::axis, {{"x", 0}, {"y", 1}, {"z", 2}}), "", "\"z\"", any, "Direction of the axis."},
      {"length", &Shape::length, "m", required, a_size, "Length along the axis."},
      {"radius", &Shape::radius, "m", required, a_size, "Radius, halfway through the thickness."},
      {"thickness", &Shape::thickness, "m", required, a_size, "Thickness."},
      {"begin", &Shape::begin, "rad", absent, an_angle,
       "Angle about the axis at which it begins, from x towards y, of the axes x and y from y to z and from z to x; absent = 0."},
      {"end", &Shape::end, "rad", absent, an_angle, "Angle at which it ends; absent = a whole turn."},
  };
  // clang-format on
  return rows;
}

const Rows<Shape>& plate_rows() {
  // clang-format off
  static const Rows<Shape> rows = {
      {"vertices", &Shape::corners, "m", required, a_place,
       "Corners in order, either way round, all in one plane, halfway through the thickness; sides must not cross."},
      {"thickness", &Shape::thickness, "m", required, a_size, "Thickness."},
  };
  // clang-format on
  return rows;
}

void check_arc(const Shape& shape, const Setting& table) {
  const double turn = shape.end - shape.begin;
  if (turn <= 0 || turn > Shape::whole_turn * (1 + 1e-12))
    throw BadInput(fmt::format("{}: it reaches from {} to {} rad; 'end' has to be greater than 'begin', by a whole turn ({:.10g}) at most.",
                               table.where, shape.begin, shape.end, Shape::whole_turn));
  if (shape.thickness >= 2 * shape.radius)
    throw BadInput(fmt::format("{}: its thickness {} m fills the radius {} m; make it thinner, or use a ball.", table.where,
                               shape.thickness, shape.radius));
}

void read_ring(Shape& shape, const Setting& table) {
  fill(shape, ring_rows(), table);
  check_arc(shape, table);
}

void read_tube(Shape& shape, const Setting& table) {
  fill(shape, tube_rows(), table);
  check_arc(shape, table);
}

void read_line(Shape& shape, const Setting& table) {
  fill(shape, line_rows(), table);
  const auto& v = shape.vertices;
  if (shape.closed && v.size() < 3) throw BadInput(fmt::format("{}: a closed line needs at least 3 corners.", table.where));
  check_corners(v, "line", table);
  for (std::size_t i = shape.closed ? 0 : 1; i < v.size(); ++i)
    if (v[i] == v[(i + v.size() - 1) % v.size()])
      throw BadInput(
          fmt::format("{}: corner {} of the line repeats the one before, ({}, {}) m; remove one.", table.where, i + 1, v[i][0], v[i][1]));
  if (crosses_itself(v, shape.closed)) throw BadInput(fmt::format("{}: the line crosses itself; give its corners in order.", table.where));
}

void read_plate(Shape& shape, const Setting& table) {
  fill(shape, plate_rows(), table);
  check_corners(shape.corners, "plate", table);
  const std::size_t count = shape.corners.size();
  for (std::size_t i = 0; i < count; ++i)
    if (const auto& x = shape.corners[i]; x == shape.corners[(i + count - 1) % count])
      throw BadInput(fmt::format("{}: corner {} of the plate repeats the one before, ({}, {}, {}) m; remove one.", table.where, i + 1, x[0],
                                 x[1], x[2]));
  shape = plate_shape(std::move(shape.corners), shape.thickness);
  if (shape.vertices.empty() || crosses_itself(shape.vertices))
    throw BadInput(fmt::format("{}: the sides of the plate cross, or it has no area; give the corners in order around it.", table.where));
  double size = 0;
  for (const auto& vertex : shape.vertices) size = std::max(size, std::hypot(vertex[0], vertex[1]));
  for (std::size_t i = 0; i < count; ++i) {
    double off = 0;
    for (int d = 0; d < 3; ++d) off += shape.axes[2][d] * (shape.corners[i][d] - shape.center[d]);
    if (std::abs(off) > 1e-6 * size)
      throw BadInput(fmt::format("{}: corner {} of the plate, ({}, {}, {}) m, is {:.3g} m off the plane of the others; a plate is flat.",
                                 table.where, i + 1, shape.corners[i][0], shape.corners[i][1], shape.corners[i][2], std::abs(off)));
  }
}

void read_box(Shape& shape, const Setting& table) {
  fill(shape, box_rows(), table);
  for (std::size_t d = 0; d < table.at("min").items.size(); ++d) {
    if (shape.min[d] < shape.max[d]) continue;
    throw BadInput(fmt::format("{}: the box has min {} and max {} m in direction {}; min has to be less than max.", table.where,
                               shape.min[d], shape.max[d], "xyz"[d]));
  }
}

void read_polygon(Shape& shape, const Setting& table) {
  fill(shape, polygon_rows(), table);
  if (shape.vertices.size() < 3)
    throw BadInput(fmt::format("{}: the polygon has {} corners, but needs at least 3.", table.where, shape.vertices.size()));
  check_corners(shape.vertices, "polygon", table);
  double twice_area = 0;
  for (std::size_t i = 0, j = shape.vertices.size() - 1; i < shape.vertices.size(); j = i++) {
    const auto &a = shape.vertices[j], &b = shape.vertices[i];
    twice_area += a[0] * b[1] - b[0] * a[1];
    if (a == b) {
      throw BadInput(
          fmt::format("{}: corner {} of the polygon repeats the one before, ({}, {}) m; remove one.", table.where, i + 1, b[0], b[1]));
    }
  }
  if (crosses_itself(shape.vertices) || twice_area == 0) {
    throw BadInput(fmt::format("{}: the sides of the polygon cross, or it has no area; give the corners in order around it.", table.where));
  }
}

void read_ball(Shape& shape, const Setting& table) { fill(shape, ball_rows(), table); }

// A solid of one kind, read from the table of that kind.
Member<Shape> solid(Shape::Kind kind, void (*read)(Shape&, const Setting&)) {
  return {ParameterType::shape, [kind, read](Shape& shape, const Setting& table) {
            shape.kind = kind;
            read(shape, table);
          }};
}

Member<Shape> combination(Shape::Kind kind) {
  return {ParameterType::shapes, [kind](Shape& shape, const Setting& list) {
            shape.kind = kind;
            read_value(shape.parts, list);
          }};
}

const Rows<Shape>& shape_rows() {
  // clang-format off
  static const Rows<Shape> rows = {
      {"box", solid(Shape::Kind::box, read_box), "", absent, any, "See `shape.box`."},
      {"polygon", solid(Shape::Kind::polygon, read_polygon), "", absent, any, "See `shape.polygon`."},
      {"ball", solid(Shape::Kind::ball, read_ball), "", absent, any, "See `shape.ball`."},
      {"ring", solid(Shape::Kind::ring, read_ring), "", absent, any, "See `shape.ring`."},
      {"line", solid(Shape::Kind::line, read_line), "", absent, any, "See `shape.line`."},
      {"tube", solid(Shape::Kind::tube, read_tube), "", absent, any, "See `shape.tube`."},
      {"plate", solid(Shape::Kind::plate, read_plate), "", absent, any, "See `shape.plate`."},
      {"union", combination(Shape::Kind::union_of), "", absent, any, "List of shapes; a point of any of them belongs to the solid."},
      {"difference", combination(Shape::Kind::difference), "", absent, any, "List of shapes; the first without the others."},
  };
  // clang-format on
  return rows;
}

}  // namespace

std::vector<TableDefinition> shape_tables() {
  return {
      {"shape", false, Presence::filled,
       "A solid, written as an inline table with exactly one of these keys, e.g. `{ box = { min = [0, 0], max = [1, 2] } }`.",
       parameters_of(shape_rows())},
      {"shape.box", false, Presence::filled, "A box along the axes.", parameters_of(box_rows())},
      {"shape.polygon", false, Presence::filled, "A polygon; 2D only.", parameters_of(polygon_rows())},
      {"shape.ball", false, Presence::filled, "A disc (2D) or ball (3D).", parameters_of(ball_rows())},
      {"shape.ring", false, Presence::filled, "A ring, or an arc of one; in 2D, of an elastic body or cut out of the fluid.",
       parameters_of(ring_rows())},
      {"shape.line", false, Presence::filled,
       "A line of straight pieces with a thickness; in 2D, of an elastic body or cut out of the fluid.", parameters_of(line_rows())},
      {"shape.tube", false, Presence::filled,
       "A round tube, or a part of one between two angles; in 3D, of an elastic body or cut out of the fluid.", parameters_of(tube_rows())},
      {"shape.plate", false, Presence::filled,
       "A flat polygon in space with a thickness; in 3D, of an elastic body or cut out of the fluid.", parameters_of(plate_rows())}};
}

Shape read_shape(const Setting& table) { return filled(shape_rows(), table); }

}  // namespace tern
