#pragma once
// How much of the kernel around a place is hidden by faces, and how much of a wall is wet.

#include <vector>

#include "fluid/boundary/plane_walls.hpp"
#include "fluid/reference.hpp"
#include "ranks/halo.hpp"
#include "ranks/ranks.hpp"
#include "sph/faces.hpp"

namespace tern::fluid {

/// Part of sum V w at x that lies behind the faces seen from there. `seen`: scratch.
template <int D>
double hidden_density(const Constants<D>& constants, const Faces<D>& faces, const FaceFinder<D>& finder, const Vector<D>& x,
                      std::vector<int>& seen);

/// Part of sum V w that walls leave open just in front of their patch k. `seen`: scratch.
template <int D>
double space_before(const Constants<D>& constants, const Faces<D>& walls, const FaceFinder<D>& finder, std::size_t k,
                    std::vector<int>& seen);

/// A wall mirrors the fluid in front of it; where there is none, above the water or beside a jet, nothing is behind it either. Sets
/// `wall_rows.wet` to the share of each wall patch that is wet, from the filled share of the `space` in front of it, less what the
/// structure takes of that. `patches`: that other ranks fill as well. `space`: part of sum V w that walls leave open in front of each of
/// their patches, negative where it is not yet known. `whole_walls`: as they are without a structure.
template <int D>
void leave_out_dry_walls(const Constants<D>& constants, const Halo& patches, const std::vector<Vector<D>>& position, const Faces<D>& walls,
                         const Faces<D>& whole_walls, const FaceFinder<D>& wall_finder, std::vector<double>& space,
                         const Faces<D>& structure, const FaceFinder<D>& structure_finder, const std::vector<PlaneWall>& planes,
                         FaceRows& wall_rows);

/// The same of the faces of bodies: sets `rows.wet` of each, from what particles of all ranks fill of what walls and bodies leave open.
template <int D>
void leave_out_dry_bodies(const Constants<D>& constants, const Ranks& ranks, const std::vector<Vector<D>>& position, const Faces<D>& bodies,
                          const FaceFinder<D>& body_finder, const Faces<D>& walls, const FaceFinder<D>& wall_finder, FaceRows& rows);

}  // namespace tern::fluid
