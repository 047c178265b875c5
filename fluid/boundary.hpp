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
  std::vector<Vector<D>> wall_hydrostatic;  ///< sum_hidden V grad w rho (g - a_w) . (r_j - r_i) behind walls [Pa/m]
  std::vector<Vector<D>> surface_gradient;  ///< sum_hidden V grad w behind the structure [1/m]

  void reset(std::size_t n);
};

/// Fills `rows` with the faces every particle sees, in the order of the particles.
template <int D>
void see_faces(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& faces,
               const FaceFinder<D>& finder, FaceRows& rows);

/// Adds the hidden side of the walls. `gravity`: at each particle [m/s^2].
template <int D>
void add_wall_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                   const Faces<D>& faces, const FaceRows& rows, BoundarySums<D>& sums);

/// Adds the hidden side of the structure. Its hydrostatic part is the coupler's, as part of the interface force.
template <int D>
void add_surface_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& faces,
                      const FaceRows& rows, BoundarySums<D>& sums);

}  // namespace tern::fluid
