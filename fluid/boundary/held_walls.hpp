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

/// Where a rank has the patches of walls.
template <int D>
struct WallBoxes {
  Bounds<D> particles = Bounds<D>::nowhere(), structure = Bounds<D>::nowhere();

  /// Both, and their images: a patch is held together with its images beyond the end of a period.
  std::vector<Bounds<D>> with_images(const Period<D>& period) const;
};

template <int D>
struct HeldWalls {
  WallBoxes<D> own;
  std::vector<std::vector<Bounds<D>>> of_ranks;  ///< of each rank, with images
  std::int64_t cuts = -1;                        ///< of space, as of which these are
  std::int64_t changes = 0;                      ///< how often any rank has found its patches anew
};

/// Finds the patches anew where space was cut anew, or particles or structure have come to where some are not held. `position`: of own
/// particles and ghosts; `surface`: of the structure. Sums over the patches that own particles see have the bits that they have with
/// all patches. All ranks call it in each window. Does nothing where walls are whole.
template <int D>
void hold_walls(const Domain<D>& domain, const Constants<D>& constants, const Period<D>& period, std::span<const Vector<D>> position,
                std::span<const Vector<D>> surface, Boundary<D>& boundary);

}  // namespace tern::fluid
