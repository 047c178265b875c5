#pragma once
// Polygons in a plane: distances, their parts on one side of a line, and the cells of points in them.

#include <algorithm>
#include <cmath>
#include <limits>
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

/// Distance of (x, y) from the straight line between a and b [m].
template <class Corner>
double distance_to_side(const Corner& a, const Corner& b, double x, double y) {
  const double ex = b[0] - a[0], ey = b[1] - a[1];
  const double s = std::clamp(((x - a[0]) * ex + (y - a[1]) * ey) / (ex * ex + ey * ey), 0.0, 1.0);
  return std::hypot(x - a[0] - s * ex, y - a[1] - s * ey);
}

/// Of (x, y) from the boundary of a polygon, negative inside and positive outside [m].
template <class Corner>
double polygon_distance(const std::vector<Corner>& corners, double x, double y) {
  double nearest = std::numeric_limits<double>::max();
  bool inside = false;
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    const Corner &a = corners[j], &b = corners[i];
    nearest = std::min(nearest, distance_to_side(a, b, x, y));
    if ((a[1] > y) != (b[1] > y) && x < a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1])) inside = !inside;
  }
  return inside ? -nearest : nearest;
}

/// Of what is inside an outline that goes round anticlockwise, the area that is nearer to each point than to all others. Together they are
/// the area of the outline. `spacing` of the points is about how far they are apart.
std::vector<double> cell_areas(const Outline& outline, const std::vector<Vector<2>>& points, double spacing);

/// For each point the others within `reach` that a straight line inside the outline leads to, in ascending order.
std::vector<std::vector<std::uint32_t>> points_beside(const Outline& outline, const std::vector<Vector<2>>& points, double reach);

}  // namespace tern
