#pragma once
// Geometry of contact between a particle and a face patch.

#include <cmath>

#include "base/vector.hpp"
#include "sph/faces.hpp"

namespace tern {

/// True when x stands over the patch (half an edge, 10 % more so that patches leave no gap) nearer than `distance` [m].
template <int D>
bool touches(const Vector<D>& centre, const Vector<D>& normal, double area, const Vector<D>& x, double distance) {
  const Vector<D> d = x - centre;
  const double height = d.dot(normal);
  if (height >= distance) return false;
  return d.squaredNorm() - height * height < patch_reach2<D>(area);
}

}  // namespace tern
