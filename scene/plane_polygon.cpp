#include "scene/plane_polygon.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace tern {
namespace {

double cross(const Vector<2>& a, const Vector<2>& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Finds the points near a place by square cells.
class Cells {
 public:
  Cells(const std::vector<Vector<2>>& points, double width) : points_(points), width_(width) {
    for (std::uint32_t j = 0; j < points.size(); ++j) cells_[key(points[j])].push_back(j);
  }
  /// Those within `reach` of points[i] but itself, in ascending order.
  std::vector<std::uint32_t> near(std::size_t i, double reach) const {
    std::vector<std::uint32_t> found;
    const Vector<2>& x = points_[i];
    const auto low = key(x - Vector<2>::Constant(reach)), high = key(x + Vector<2>::Constant(reach));
    for (long a = low[0]; a <= high[0]; ++a)
      for (long b = low[1]; b <= high[1]; ++b)
        if (const auto cell = cells_.find({a, b}); cell != cells_.end())
          for (const std::uint32_t j : cell->second)
            if (j != i && (points_[j] - x).norm() < reach) found.push_back(j);
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  std::array<long, 2> key(const Vector<2>& x) const {
    return {std::lround(std::floor(x[0] / width_)), std::lround(std::floor(x[1] / width_))};
  }
  const std::vector<Vector<2>>& points_;
  double width_;
  std::map<std::array<long, 2>, std::vector<std::uint32_t>> cells_;
};

}  // namespace

PlaneArea area_of(const Outline& outline) {
  double twice = 0;
  Vector<2> sum = Vector<2>::Zero();
  if (outline.empty()) return {0, sum};
  const Vector<2>& from = outline[0];  // so that the figures are no larger than the polygon
  for (std::size_t i = 1; i + 1 < outline.size(); ++i) {
    const Vector<2> a = outline[i] - from, b = outline[i + 1] - from;
    twice += cross(a, b);
    sum += cross(a, b) * (a + b);
  }
  return {0.5 * twice, twice == 0 ? from : Vector<2>(from + sum / (3 * twice))};
}

Outline cut(const Outline& outline, const Vector<2>& point, const Vector<2>& normal) {
  Outline kept;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector<2>&a = outline[i], &b = outline[(i + 1) % outline.size()];
    const double at_a = (a - point).dot(normal), at_b = (b - point).dot(normal);
    if (at_a <= 0) kept.push_back(a);
    if ((at_a < 0 && at_b > 0) || (at_a > 0 && at_b < 0)) kept.push_back(a + at_a / (at_a - at_b) * (b - a));
  }
  return kept;
}

// A cell begins as the whole outline, and the middle line to each point cuts off what is nearer to that one, the nearest points first.
// A point farther away than twice the farthest corner of the cell cuts off nothing.
std::vector<double> cell_areas(const Outline& outline, const std::vector<Vector<2>>& points, double spacing) {
  const Cells cells(points, 2 * spacing);
  std::vector<double> areas(points.size());
  double size = 0;
  for (const Vector<2>& corner : outline) size = std::max(size, (corner - outline[0]).norm());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (double reach = 4 * spacing;; reach *= 2) {
      std::vector<std::uint32_t> others = cells.near(i, reach);
      const auto distance = [&](std::uint32_t j) { return (points[j] - points[i]).norm(); };
      std::stable_sort(others.begin(), others.end(), [&](auto a, auto b) { return distance(a) < distance(b); });
      Outline cell = outline;
      const auto twice_farthest = [&] {
        double farthest = 0;
        for (const Vector<2>& corner : cell) farthest = std::max(farthest, (corner - points[i]).norm());
        return 2 * farthest;
      };
      for (const std::uint32_t j : others) {
        if (distance(j) >= twice_farthest()) break;
        cell = cut(cell, 0.5 * (points[i] + points[j]), points[j] - points[i]);
      }
      areas[i] = area_of(cell).area;
      if (twice_farthest() <= reach || reach > 2 * size) break;
    }
  }
  return areas;
}

std::vector<std::vector<std::uint32_t>> points_beside(const Outline& outline, const std::vector<Vector<2>>& points, double reach) {
  const Cells cells(points, reach);
  std::vector<std::vector<std::uint32_t>> beside(points.size());
  constexpr int parts = 8;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto distance = [&](const Vector<2>& x) { return polygon_distance(outline, x[0], x[1]); };
    const bool is_deep = distance(points[i]) < -reach;
    for (const std::uint32_t j : cells.near(i, reach)) {
      bool is_inside = true;
      for (int k = 1; k < parts && is_inside && !is_deep; ++k) {
        const double share = static_cast<double>(i < j ? k : parts - k) / parts;  // the same places from both ends
        is_inside = distance(points[i] + share * (points[j] - points[i])) <= 1e-6 * reach;
      }
      if (is_inside) beside[i].push_back(j);
    }
  }
  return beside;
}

}  // namespace tern
