#pragma once
// Geometry of contact between a particle and a face patch.

#include <algorithm>
#include <cmath>

#include "base/vector.hpp"
#include "sph/faces.hpp"

namespace tern {

/// True when x stands over the patch: half an edge, 10 % more so that patches leave no gap.
template <int D>
bool stands_over(const Vector<D>& centre, const Vector<D>& normal, double area, const Vector<D>& x) {
  const Vector<D> d = x - centre;
  const double height = d.dot(normal);
  return d.squaredNorm() - height * height < patch_reach2<D>(area);
}

/// The same, nearer than `distance` [m].
template <int D>
bool touches(const Vector<D>& centre, const Vector<D>& normal, double area, const Vector<D>& x, double distance) {
  return (x - centre).dot(normal) < distance && stands_over<D>(centre, normal, area, x);
}

/// Speed with which a particle at this height above a face may approach it, so that it comes no nearer than `distance` in a window [m/s].
/// A window carries a fast particle by more than the distance: to stop it only when it is that near would be too late.
inline double permitted_approach(double height, double distance, double duration) { return std::max(height - distance, 0.0) / duration; }

}  // namespace tern
