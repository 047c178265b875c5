#pragma once
// Polygons in a plane: their parts on one side of a line, and the cells of points in them.

#include <vector>

#include "base/vector.hpp"

namespace tern {

/// Corners in order round a polygon. One that a line has cut may touch itself along that line: its area and centre are still right.
using Outline = std::vector<Vector<2>>;

struct PlaneArea {
  double area;  ///< positive where the corners go round anticlockwise [m^2]
  Vector<2> centre;
};
PlaneArea area_of(const Outline& outline);

/// What of it lies where (x - point).normal <= 0.
Outline cut(const Outline& outline, const Vector<2>& point, const Vector<2>& normal);

/// Distance of x from the straight line between a and b [m].
double distance_to_side(const Vector<2>& a, const Vector<2>& b, const Vector<2>& x);

/// Negative inside, 0 on the boundary, positive outside [m].
double signed_distance(const Outline& outline, const Vector<2>& x);

/// Of what is inside an outline that goes round anticlockwise, the area that is nearer to each point than to all others. Together they are
/// the area of the outline. `spacing` of the points is about how far they are apart.
std::vector<double> cell_areas(const Outline& outline, const std::vector<Vector<2>>& points, double spacing);

/// For each point the others within `reach` that a straight line inside the outline leads to, in ascending order.
std::vector<std::vector<std::uint32_t>> points_beside(const Outline& outline, const std::vector<Vector<2>>& points, double reach);

}  // namespace tern
