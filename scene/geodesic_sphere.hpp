#pragma once
// A sphere of radius 1 in triangles: the faces of an icosahedron, each cut into smaller ones.

#include <array>
#include <cstddef>
#include <vector>

#include "base/vector.hpp"
#include "scene/geometry.hpp"

namespace tern {

struct GeodesicSphere {
  std::vector<Vector<3>> corner;
  std::vector<double> area;  ///< of each corner: a third of the triangles around it [sr]
  std::vector<std::array<std::size_t, 3>> triangle;
};

/// `parts`: into which each edge of the icosahedron is cut. The corners of the triangles of a face are where sums of its corners with the
/// weights sin(i w/n) point to, w the angle of an edge: on the edges they are evenly spaced.
GeodesicSphere geodesic_sphere(int parts);

/// Points about `spacing` [m] apart on the sphere of this radius [m] about `center`, with normals outwards or inwards: one at each corner,
/// or some in the part of each corner in each triangle around it. Those of a corner have the area of that corner together.
void sample_sphere(const GeodesicSphere& sphere, const Vector<3>& center, double radius, bool outwards, double spacing,
                   SurfacePoints<3>& points);

}  // namespace tern
