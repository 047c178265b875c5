#pragma once
// The faces that bound the fluid, of walls and of the structure, and what each particle sees of them.

#include <vector>

#include "fluid/boundary/boundary_sums.hpp"
#include "fluid/boundary/held_walls.hpp"
#include "fluid/boundary/wall_clipping.hpp"
#include "fluid/boundary/walls.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/reference.hpp"
#include "fluid/workspace.hpp"
#include "proto/interface.hpp"
#include "ranks/halo.hpp"
#include "ranks/ranks.hpp"
#include "sph/faces.hpp"

namespace tern::fluid {

template <int D>
struct Boundary {
  /// `whole`: with all patches of all walls, as in one process; else `share` is that of this rank in looking how fast they move.
  Boundary(const Case& scene, const Constants<D>& constants, bool whole = true, PatchShare share = {});

  Walls<D> walls;                           ///< as they are without a structure
  HeldWalls<D> held;                        ///< which patches of them there are, where there are several ranks
  FaceFinder<D> wall_finder;                ///< of these
  std::vector<double> space_before_walls;   ///< per patch, negative: not known (wetness.hpp)
  ClippedWalls<D> clipped_walls;            ///< as the structure leaves them
  FaceRows wall_rows;                       ///< by particle
  Halo patches;                             ///< of the walls, where there are several ranks (patches_of_ranks.hpp)
  std::int64_t cuts_of_patches = -1;        ///< of space, as of which these are, ...
  std::int64_t changes_of_patches = -1;     ///< ... and of what ranks hold
  Faces<D> surface;                         ///< of the structure
  FaceFinder<D> surface_finder;             ///< of it
  std::vector<std::uint8_t> covered_faces;  ///< of the surface: they stand at a wall
  FaceRows surface_rows;                    ///< by particle
  BoundarySums<D> sums;
  std::vector<int> dry_patches;           ///< scratch of leave_dry_planes()
  std::vector<std::size_t> first_corner;  ///< likewise

  const Faces<D>& seen_walls() const { return clipped_walls.none() ? walls.faces() : clipped_walls.faces(); }
  bool sees_structure(std::ptrdiff_t i) const { return surface_rows.count[i] > 0; }
  bool sees_wall(std::ptrdiff_t i) const { return wall_rows.count[i] > 0; }
  bool sees_face(std::ptrdiff_t i) const { return sees_wall(i) || sees_structure(i); }
};

/// Places moving walls at the middle of the window; their velocity in the window before becomes that in this one, in the state.
template <int D>
void move_walls(const Constants<D>& constants, const Ranks& ranks, const Window& window, Boundary<D>& boundary, State<D>& state);

/// Takes over the surface of the structure at the middle of the window and clips the walls at which it stands.
template <int D>
void set_surface(const Constants<D>& constants, const Surface<D>& surface, Boundary<D>& boundary);

/// Faces that each particle at `position` sees. Takes pairs of particles out of `neighbours` that a body parts.
template <int D>
void see_boundary(const Constants<D>& constants, const Period<D>& period, const std::vector<Vector<D>>& position, Boundary<D>& boundary,
                  Neighbours<D>& neighbours);

/// Wet shares and sums over the hidden side, of the faces that each particle sees. `gravity`: at each particle [m/s^2].
template <int D>
void sum_over_hidden_side(const Constants<D>& constants, const Ranks& ranks, const std::vector<Vector<D>>& position,
                          const std::vector<Vector<D>>& gravity, Boundary<D>& boundary);

/// The surface of the same window under another load: changes the flux that the particles `at_structure` see.
template <int D>
void set_surface_velocity(const std::vector<Vector<D>>& velocity, const std::vector<int>& at_structure, Boundary<D>& boundary);

}  // namespace tern::fluid
