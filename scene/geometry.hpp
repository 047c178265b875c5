#pragma once
// Solid shapes: boxes, polygons (2D), balls and their union and difference. Coordinates in m.

#include <array>
#include <string>
#include <vector>

#include "base/vector.hpp"

namespace tern {

struct Shape {
  enum class Kind { box, polygon, ball, union_of, difference };
  Kind kind = Kind::box;
  std::array<double, 3> min{}, max{};           ///< box
  std::vector<std::array<double, 2>> vertices;  ///< polygon, any orientation, not self-intersecting
  std::array<double, 3> center{};               ///< ball
  double radius = 0;                            ///< ball
  std::vector<Shape> parts;                     ///< union_of: all; difference: the first minus the others
};

template <int D>
struct Bounds {
  Vector<D> min, max;
};

/// Points on a surface with outward unit normal and the area they stand for. sum(area) = the surface to O(spacing^2).
template <int D>
struct SurfacePoints {
  std::vector<Vector<D>> position;
  std::vector<Vector<D>> normal;
  std::vector<double> area;  ///< [m^(D-1)]
};

/// Negative inside, 0 on the boundary, positive outside [m]. Its size is the distance to the boundary for a single box,
/// polygon or ball, and a lower bound of it in unions (outside) and differences (inside).
template <int D>
double signed_distance(const Shape& shape, const Vector<D>& x);

/// True inside or on the boundary.
template <int D>
bool contains(const Shape& shape, const Vector<D>& x);

template <int D>
Bounds<D> bounding_box(const Shape& shape);

/// Lattice points x = bounding_box.min + (k + 1/2) spacing inside the shape, x running fastest. The lattice of a box
/// whose sides are whole multiples of the spacing fills it exactly (tolerance 1e-6 spacing).
template <int D>
std::vector<Vector<D>> fill_lattice(const Shape& shape, double spacing);

/// The same for a fluid, whose walls shall be half a step away on all sides: in a box, or what is cut out of one, the steps are stretched
/// so that whole ones fill each side.
template <int D>
std::vector<Vector<D>> fill_with_fluid(const Shape& shape, double spacing);

/// The spacing near `spacing` whose D-th power is the volume of a cell of these lattices, on average over all boxes: with it the fluid
/// begins at its density. `spacing` itself where whole multiples of it fill the boxes.
template <int D>
double fitted_spacing(const std::vector<Shape>& shapes, double spacing);

/// Boundary of the shape cut into flat patches of about `spacing`, one point at the middle of each. Every straight edge
/// (box face, polygon side) is divided evenly with its own rounded count; a ball evenly in angle (2D) or area (3D).
/// In union and difference only the parts on the final boundary remain; normals point out of the final solid.
template <int D>
SurfacePoints<D> sample_surface(const Shape& shape, double spacing);

/// Distance from surface point x along -normal to where the ray leaves the solid again [m].
template <int D>
double thickness(const Shape& shape, const Vector<D>& x, const Vector<D>& normal);

}  // namespace tern
