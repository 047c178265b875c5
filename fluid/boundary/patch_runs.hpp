#pragma once
// Which patches of the walls a rank looks at in a window.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fluid/boundary/plane_walls.hpp"

namespace tern::fluid {

/// Part of the grid of a plane wall: columns and rows from .. to - 1.
struct GridPart {
  std::array<int, 2> from, to;
};

/// Of each plane wall the patches that particles at these positions fill, or count as dry (leave_dry_planes()). `parts` is overwritten.
inline void parts_near(const std::vector<PlaneWall>& planes, double support, const std::vector<Vector<3>>& position, std::size_t particles,
                       std::vector<GridPart>& parts) {
  Vector<3> low = Vector<3>::Constant(1e300), high = -low;
  for (std::size_t i = 0; i < particles; ++i) low = low.cwiseMin(position[i]), high = high.cwiseMax(position[i]);
  parts.clear();
  for (const PlaneWall& plane : planes) {
    GridPart part{{0, 0}, {0, 0}};
    const bool near = particles > 0 && plane.height(plane.side > 0 ? low : high) < 1.01 * support;
    for (int c = 0; c < 2 && near; ++c) {
      // Half a patch and the one in which that ends.
      const double from = (low[plane.along[c]] - support - plane.low[c]) / plane.step[c] - 1.5;
      const double to = (high[plane.along[c]] + support - plane.low[c]) / plane.step[c] + 1.5;
      part.from[c] = static_cast<int>(std::clamp(std::floor(from), 0.0, static_cast<double>(plane.count[c])));
      part.to[c] = static_cast<int>(std::clamp(std::ceil(to), 0.0, static_cast<double>(plane.count[c])));
    }
    parts.push_back(part);
  }
}

/// All of them.
inline void whole_parts(const std::vector<PlaneWall>& planes, std::vector<GridPart>& parts) {
  parts.clear();
  for (const PlaneWall& plane : planes) parts.push_back({{0, 0}, plane.count});
}

}  // namespace tern::fluid
