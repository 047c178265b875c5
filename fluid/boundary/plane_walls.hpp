#pragma once
// Particles in 3D that see nothing but the inside of one plane wall, all of it wet. Their sums over the hidden side are functions of the
// height alone (FaceKernel::behind_plane): they need no search for patches and no sum over them.
//
// The patches of a wall add up to the same only as they become small. So that nothing jumps where a particle comes to see something else,
// a share goes from 1 to 0 over half a spacing of what it lacks until it does, and over the first four patches that are dry.

#include <array>
#include <span>
#include <vector>

#include "base/vector.hpp"
#include "sph/faces.hpp"

namespace tern::fluid {

template <int D>
struct Boundary;

/// Part of the grid of a plane wall: columns and rows from .. to - 1.
struct GridPart {
  std::array<int, 2> from{}, to{};
};

/// A side of a box as a grid of patches, in 3D. Those of a row are numbered one after the other.
struct PlaneWall {
  int axis;                               ///< of the normal
  double place, side;                     ///< on that axis [m]; +1 if the fluid is above
  std::array<int, 2> along;               ///< axes of the grid: that of a row, and across rows
  std::array<double, 2> low, high, step;  ///< [m]
  std::array<int, 2> count;               ///< of patches
  GridPart held;                          ///< those that there are here: all, or those near the particles of a rank
  std::vector<int> row;                   ///< of each row of these: the number of its first patch, less the column of that

  double height(const Vector<3>& x) const { return side * (x[axis] - place); }

  int patch(int column, int of_row) const { return row[of_row - held.from[1]] + column; }

  /// The patch at the foot of the perpendicular from x, or the nearest to it.
  int at_foot(const Vector<3>& x) const {
    std::array<int, 2> at;
    for (int c = 0; c < 2; ++c) at[c] = std::clamp(static_cast<int>((x[along[c]] - low[c]) / step[c]), held.from[c], held.to[c] - 1);
    return patch(at[0], at[1]);
  }

  /// Calls visit(k, n, offset, rest2) for the rows of patches nearer to x than `support`: patches k .. k + n - 1, whose distances are
  /// sqrt(rest2 + (offset + m step[0])^2), m from 0.
  template <class Visit>
  void for_rows_around(const Vector<3>& x, double support, Visit&& visit) const {
    const double h = height(x), flat2 = support * support - h * h;
    const double u = (x[along[0]] - low[0]) / step[0] - 0.5, v = (x[along[1]] - low[1]) / step[1] - 0.5;  // in patches
    const double reach = std::sqrt(std::max(0.0, flat2)) / step[1];
    const int from = std::max(held.from[1], static_cast<int>(std::ceil(v - reach))),
              to = std::min(held.to[1] - 1, static_cast<int>(std::floor(v + reach)));
    for (int b = from; b <= to; ++b) {
      const double across = (b - v) * step[1], half2 = flat2 - across * across;
      if (half2 <= 0) continue;
      const double half = std::sqrt(half2) / step[0];
      const int begin = std::max(held.from[0], static_cast<int>(std::ceil(u - half))),
                end = std::min(held.to[0] - 1, static_cast<int>(std::floor(u + half)));
      if (begin <= end) visit(patch(begin, b), end - begin + 1, (begin - u) * step[0], h * h + across * across);
    }
  }
};

/// Faces of the walls that each particle sees. Of particles with a share of 1 in a plane wall only the patch at their foot.
template <int D>
void see_walls(double spacing, std::span<const Vector<D>> position, Boundary<D>& boundary);

/// Appends to `rows`, of the particles position[0] .. position[first - 1], those of the others, with faces of all walls that have two sides
/// at least. Nothing is looked for where there is none of these.
template <int D>
void see_two_sided_walls(double spacing, std::span<const Vector<D>> position, std::size_t first, const Boundary<D>& boundary,
                         FaceRows& rows);

/// Once it is known which patches are wet: takes back the shares where some are dry, and lists all patches of these particles.
template <int D>
void leave_dry_planes(const std::vector<Vector<D>>& position, Boundary<D>& boundary);

}  // namespace tern::fluid
