#pragma once
// What walls and structure contribute to the sums of the fluid particles near them, through the faces these see.

#include <vector>

#include "fluid/reference.hpp"
#include "sph/convex_corner.hpp"
#include "sph/faces.hpp"

namespace tern::fluid {

/// A particle and a face of the structure that is turned away from it past a corner (convex_corner.hpp).
struct BackFacing {
  int particle, face;
  double weight;  ///< A_k w~ [1/m], whether the face is wet or not
};

/// Sums over the hidden side of all faces a particle sees; zero away from faces. set_wall_sums() comes first.
template <int D>
struct BoundarySums {
  std::vector<double> number_density;    ///< hidden part of sum V w [-]
  std::vector<Matrix<D>> moment;         ///< hidden part of sum V grad w (r_j - r_i)^T [-]
  std::vector<Vector<D>> wall_gradient;  ///< sum_hidden V grad w behind walls [1/m]
  std::vector<Matrix<D>> tangential;     ///< T = sum_hidden V grad w (r_j - r_i)_t^T, _t: along the face (beside corners: see THEORY) [-]
  std::vector<Vector<D>> mirrored_hydrostatic;  ///< sum_hidden V grad w rho (g - a_w)_n (r_j - r_i)_n behind walls [Pa/m]
  std::vector<Vector<D>> surface_gradient;      ///< sum_hidden V grad w behind the structure; empty: none is seen [1/m]
  std::vector<Vector<D>> back_facing_gradient;  ///< what back-facing faces take from both (convex_corner.hpp) [1/m]
  std::vector<Vector<D>> unborne_gradient;      ///< of the structure and of back-facing faces, what is not the interface's [1/m]
  std::vector<Vector<D>> reaction;        ///< of the same, as the interface has it under a uniform pressure; at the structure alone [1/m]
  std::vector<Vector<D>> carried_weight;  ///< what it gives back of the fluid's weight up to the faces; at the structure alone [Pa/m]
  std::vector<Matrix<D>> linear_moment;   ///< -2 sum A w~ n d^T of the structure, less what M has of it; at the structure alone [-]
  std::vector<double> swept_share;        ///< of each face of the structure: its load over what its particles fill [-]
  std::vector<double> reaction_share;     ///< of each face of the structure in that [-]
  std::vector<double> borne_share;        ///< of each face of the structure (convex_corner.hpp) [-]
  std::vector<std::uint8_t> cell_sees;    ///< by cell of the finder of faces: whether a particle in it sees one
  std::vector<CornerScratch> corner_scratch;         ///< by thread
  std::vector<std::vector<BackFacing>> back_facing;  ///< by thread: particle by particle
  std::vector<double> flux;                          ///< sum_k A_k w~_ik n_k . u_k of all faces [1/s]
  std::vector<double> back_facing_acceleration;      ///< sum_k A_k w~_ik n_k . a_k of the back-facing ones of walls that move [1/s^2]

  /// Of walls and structure.
  Vector<D> faces_gradient(std::ptrdiff_t i) const {
    return surface_gradient.empty() ? wall_gradient[i] : Vector<D>(wall_gradient[i] + surface_gradient[i]);
  }
};

/// Sums over the hidden side of the walls, and the weights of the rows. `gravity`: at each particle [m/s^2].
template <int D>
void set_wall_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                   const Faces<D>& faces, FaceRows& rows, BoundarySums<D>& sums);

/// Takes from the sums over the hidden side of walls what lies past their convex corners (convex_corner.hpp), but for what a body of the
/// structure parts from the particle. After set_wall_sums().
template <int D>
void close_round_wall_corners(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                              const Faces<D>& walls, const FaceFinder<D>& finder, const FaceRows& rows, const Faces<D>& structure,
                              const FaceRows& structure_rows, BoundarySums<D>& sums);

/// Adds the hidden side of the structure and sets the weights of the rows. Its hydrostatic part is the coupler's, as part of the interface
/// force. `covered`: faces that stand at a wall.
template <int D>
void add_surface_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                      const Faces<D>& faces, const FaceFinder<D>& finder, const std::vector<std::uint8_t>& covered, FaceRows& rows,
                      BoundarySums<D>& sums);

}  // namespace tern::fluid
