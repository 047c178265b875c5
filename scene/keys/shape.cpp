// Shapes, wherever they stand.

#include <fmt/format.h>
#include "base/error.hpp"
#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

// Two sides of a polygon cross or touch other than at a shared corner.
bool crosses_itself(const std::vector<std::array<double, 2>>& v) {
  const auto turn = [](const auto& a, const auto& b, const auto& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  };
  const std::size_t n = v.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      const auto &a = v[i], &b = v[i + 1], &c = v[j], &d = v[(j + 1) % n];
      if (turn(a, b, c) * turn(a, b, d) <= 0 && turn(c, d, a) * turn(c, d, b) <= 0 && (turn(a, b, c) != 0 || turn(a, b, d) != 0)) {
        return true;
      }
    }
  }
  return false;
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
  constexpr std::size_t most_corners = 10000;  // each side is held against each other one
  if (shape.vertices.size() > most_corners) {
    throw BadInput(
        fmt::format("{}: the polygon has {} corners, but at most {} are allowed; leave out those that lie nearer than a spacing.",
                    table.where, shape.vertices.size(), most_corners));
  }
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
      {"union", combination(Shape::Kind::union_of), "", absent, any, "List of shapes; a point of any of them belongs to the solid."},
      {"difference", combination(Shape::Kind::difference), "", absent, any, "List of shapes; the first without the others."},
  };
  // clang-format on
  return rows;
}

}  // namespace

std::vector<TableDefinition> shape_tables() {
  return {{"shape", false, Presence::filled,
           "A solid, written as an inline table with exactly one of these keys, e.g. `{ box = { min = [0, 0], max = [1, 2] } }`.",
           parameters_of(shape_rows())},
          {"shape.box", false, Presence::filled, "A box along the axes.", parameters_of(box_rows())},
          {"shape.polygon", false, Presence::filled, "A polygon; 2D only.", parameters_of(polygon_rows())},
          {"shape.ball", false, Presence::filled, "A disc (2D) or ball (3D).", parameters_of(ball_rows())}};
}

Shape read_shape(const Setting& table) { return filled(shape_rows(), table); }

}  // namespace tern
