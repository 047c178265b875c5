#pragma once
// What particles see: faces that no other hides, and each other where no body stands between them.

#include <vector>

#include "fluid/neighbours.hpp"
#include "fluid/period.hpp"
#include "fluid/reference.hpp"
#include "sph/faces.hpp"

namespace tern::fluid {

/// Fills `rows` with the faces every particle sees, in the order of the particles, without the weights.
template <int D>
void see_faces(const std::vector<Vector<D>>& position, const Faces<D>& faces, const FaceFinder<D>& finder, FaceRows& rows);

/// Takes out of `wall_rows` the patches of walls that the structure hides from a particle.
template <int D>
void hide_walls_behind_structure(const std::vector<Vector<D>>& position, const Faces<D>& walls, const Faces<D>& surface,
                                 const FaceRows& surface_rows, FaceRows& wall_rows);

/// Takes out pairs whose connecting line passes through a two-sided face that either particle sees, and sums those rows
/// anew. `rows` lists the faces seen by each particle. The fluid on one side of a plate does not see the fluid on the other.
/// With `past_corners`, fluid past a convex corner is seen (convex_corner.hpp).
template <int D>
void cut_pairs_through_faces(const Constants<D>& constants, const Period<D>& period, const std::vector<Vector<D>>& position,
                             const Faces<D>& faces, const FaceRows& rows, bool past_corners, Neighbours<D>& neighbours);

}  // namespace tern::fluid
