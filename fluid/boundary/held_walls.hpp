#pragma once
// Which patches of the walls a rank has: those near its particles and ghosts, and those near the structure, of which every rank has all.

#include <cstdint>
#include <span>
#include <vector>

#include "fluid/domain.hpp"
#include "fluid/reference.hpp"
#include "scene/geometry.hpp"

namespace tern::fluid {

template <int D>
struct Boundary;

/// Where a rank has the patches of walls, as they are at t = 0: of those at rest, then of each that moves (Wall::frame). Boxes around its
/// particles, around the structure, and the images of both: a patch is held together with its images beyond the end of a period.
template <int D>
using WallBoxes = std::vector<std::vector<Bounds<D>>>;

template <int D>
struct HeldWalls {
  WallBoxes<D> own;                    ///< empty: none is held yet
  std::vector<WallBoxes<D>> of_ranks;  ///< of each rank
  std::int64_t cuts = -1;              ///< of space, as of which these are
  std::int64_t changes = 0;            ///< how often any rank has found its patches anew
};

/// Finds the patches anew where space was cut anew, or particles or structure have come to where some of a wall are not held, or a wall has
/// moved that far. `position`: of own
/// particles and ghosts; `surface`: of the structure. Sums over the patches that own particles see have the bits that they have with
/// all patches. All ranks call it in each window. Does nothing where walls are whole.
template <int D>
void hold_walls(const Domain<D>& domain, const Constants<D>& constants, const Period<D>& period, std::span<const Vector<D>> position,
                std::span<const Vector<D>> surface, Boundary<D>& boundary);

}  // namespace tern::fluid
