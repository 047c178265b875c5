#pragma once
// What walls and structure contribute to the sums of the fluid particles near them, through the faces these see.

#include <vector>

#include "fluid/neighbours.hpp"
#include "fluid/state.hpp"
#include "particles/faces.hpp"

namespace tern::fluid {

/// Sums over the hidden side of all faces a particle sees; zero away from faces.
template <int D>
struct BoundarySums {
  std::vector<double> number_density;       ///< hidden part of sum V w [-]
  std::vector<Matrix<D>> moment;            ///< hidden part of sum V grad w (r_j - r_i)^T [-]
  std::vector<Vector<D>> wall_gradient;     ///< sum_hidden V grad w behind walls [1/m]
  std::vector<Matrix<D>> tangential;        ///< T = sum_hidden V grad w (r_j - r_i)_t^T, _t: along the face [-]
  std::vector<Vector<D>> wall_hydrostatic;  ///< sum_hidden V grad w rho (g - a_w)_n (r_j - r_i)_n behind walls [Pa/m]
  std::vector<Vector<D>> surface_gradient;  ///< sum_hidden V grad w behind the structure [1/m]

  void reset(std::size_t n);
};

/// Fills `rows` with the faces every particle sees, in the order of the particles.
template <int D>
void see_faces(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& faces,
               const FaceFinder<D>& finder, FaceRows& rows);

/// Part of sum V w that walls leave open in front of each of their patches. For walls that stand, once and for all.
template <int D>
void space_before_walls(const Constants<D>& constants, const Faces<D>& walls, const FaceFinder<D>& finder, std::vector<double>& space);

/// A wall mirrors the fluid in front of it; where there is none, above the water or beside a jet, nothing is behind it
/// either. Sets `wall_rows.wet` to the share of each wall patch that is wet, from the filled share of the `space` in front of
/// it, less what the structure takes of that, and weighs the rows with it.
template <int D>
void leave_out_dry_walls(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& walls,
                         const std::vector<double>& space, const Faces<D>& structure, const FaceFinder<D>& structure_finder,
                         FaceRows& wall_rows);

/// Adds the hidden side of the walls. `gravity`: at each particle [m/s^2].
template <int D>
void add_wall_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                   const Faces<D>& faces, const FaceRows& rows, BoundarySums<D>& sums);

/// Adds the hidden side of the structure. Its hydrostatic part is the coupler's, as part of the interface force.
template <int D>
void add_surface_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& faces,
                      const FaceRows& rows, BoundarySums<D>& sums);

}  // namespace tern::fluid
