#include "scene/geodesic_sphere.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace tern {
namespace {

/// Of the triangle between three directions [sr].
double solid_angle(const Vector<3>& a, const Vector<3>& b, const Vector<3>& c) {
  return 2 * std::atan2(std::abs(a.dot(b.cross(c))), 1 + a.dot(b) + b.dot(c) + c.dot(a));
}

/// Builds the corners, each once, as triangles ask for them.
class Builder {
 public:
  explicit Builder(int parts) : parts_(parts) {
    for (int axis = 0; axis < 3; ++axis)
      for (const double one : {-1.0, 1.0})
        for (const double other : {-std::numbers::phi, std::numbers::phi}) {
          Vector<3> x = Vector<3>::Zero();
          x[(axis + 1) % 3] = one, x[(axis + 2) % 3] = other;
          of_icosahedron_.push_back(x.normalized());
        }
    const int count = static_cast<int>(of_icosahedron_.size());
    for (int a = 0; a < count; ++a)
      for (int b = a + 1; b < count; ++b)
        for (int c = b + 1; c < count; ++c)
          if (are_neighbours(a, b) && are_neighbours(b, c) && are_neighbours(a, c)) add_face({a, b, c});
  }

  GeodesicSphere sphere;

 private:
  bool are_neighbours(int a, int b) const { return of_icosahedron_[a].dot(of_icosahedron_[b]) > 0.9 * std::cos(angle_); }

  /// Where a corner of the icosahedron has `share` of `parts_`.
  std::size_t corner_at(const std::array<int, 3>& of, const std::array<int, 3>& share) {
    std::array<int, 6> key{-1, -1, -1, 0, 0, 0};  // those that have a share, and their shares
    Vector<3> x = Vector<3>::Zero();
    for (int n = 0, m = 0; n < 3; ++n) {
      if (share[n] == 0) continue;
      key[m] = of[n], key[3 + m++] = share[n];
      x += std::sin(share[n] * angle_ / parts_) * of_icosahedron_[of[n]];
    }
    const auto [entry, is_new] = known_.try_emplace(key, sphere.corner.size());
    if (is_new) {
      sphere.corner.push_back(x.normalized());
      sphere.area.push_back(0);
    }
    return entry->second;
  }

  void add_triangle(const std::array<std::size_t, 3>& at) {
    const double area = solid_angle(sphere.corner[at[0]], sphere.corner[at[1]], sphere.corner[at[2]]);
    for (const std::size_t n : at) sphere.area[n] += area / 3;
    sphere.triangle.push_back(at);
  }

  void add_face(const std::array<int, 3>& of) {
    const auto at = [&](int i, int j) { return corner_at(of, {parts_ - i - j, i, j}); };
    for (int i = 0; i < parts_; ++i)
      for (int j = 0; i + j < parts_; ++j) {
        add_triangle({at(i, j), at(i + 1, j), at(i, j + 1)});
        if (i + j + 1 < parts_) add_triangle({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  }

  int parts_;
  double angle_ = std::acos(1 / std::sqrt(5.0));
  std::vector<Vector<3>> of_icosahedron_;
  std::map<std::array<int, 6>, std::size_t> known_;
};

/// The part of a triangle that is corner a's, between it, the middles of its edges and that of the triangle, in n x n pieces.
void sample_part(const Vector<3>& a, const Vector<3>& b, const Vector<3>& c, int n, const auto& add) {
  const Vector<3> to_b = (a + b).normalized(), to_c = (a + c).normalized(), middle = (a + b + c).normalized();
  const auto at = [&](double u, double v) -> Vector<3> {
    return ((1 - u) * (1 - v) * a + u * (1 - v) * to_b + u * v * middle + (1 - u) * v * to_c).normalized();
  };
  std::vector<Vector<3>> place;
  std::vector<double> area;
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const auto corner = [&](int k, int l) { return at(static_cast<double>(i + k) / n, static_cast<double>(j + l) / n); };
      place.push_back(at((i + 0.5) / n, (j + 0.5) / n));
      area.push_back(solid_angle(corner(0, 0), corner(1, 0), corner(1, 1)) + solid_angle(corner(0, 0), corner(1, 1), corner(0, 1)));
      sum += area.back();
    }
  const double whole = solid_angle(a, b, c) / 3;
  for (std::size_t k = 0; k < place.size(); ++k) add(place[k], area[k] * whole / sum);
}

}  // namespace

GeodesicSphere geodesic_sphere(int parts) { return Builder(parts).sphere; }

void sample_sphere(const GeodesicSphere& sphere, const Vector<3>& center, double radius, bool outwards, double spacing,
                   SurfacePoints<3>& points) {
  const auto add = [&](const Vector<3>& direction, double area) {
    points.position.push_back(center + radius * direction);
    points.normal.push_back(outwards ? direction : Vector<3>(-direction));
    points.area.push_back(radius * radius * area);
  };
  const double of_corner = radius * std::sqrt(4 * std::numbers::pi / static_cast<double>(sphere.corner.size()));
  const double of_part = of_corner / std::sqrt(6.0);  // six triangles have a part of most corners
  if (spacing > std::sqrt(of_corner * of_part)) {
    for (std::size_t k = 0; k < sphere.corner.size(); ++k) add(sphere.corner[k], sphere.area[k]);
    return;
  }
  const int n = static_cast<int>(std::max(1L, std::lround(of_part / spacing)));
  for (const std::array<std::size_t, 3>& of : sphere.triangle)
    for (int k = 0; k < 3; ++k) sample_part(sphere.corner[of[k]], sphere.corner[of[(k + 1) % 3]], sphere.corner[of[(k + 2) % 3]], n, add);
}

}  // namespace tern
