#pragma once
// How the faces of a solid follow its particles, and how particles bear what loads the faces. Foot k follows the particle i behind it,
//   x_k = x_i + F_i (X_k - X_i),   F_i = I + sum_j V_j (d_j - d_i) x g_ij,
// which is X_k + sum_j w_kj d_j with the constant weights w_kj = V_j g_ij.(X_k - X_i), w_ki = 1 - sum_j w_kj. A force f on k is borne as
// w_kj f, so that its power is f.u_k, u_k = sum_j w_kj v_j.
//
// Under a uniform stress P the particles of the body push each other by -P b_j, b_j = sum_i V_i dF_i/dx_j, which is 0 inside. The load on
// the faces is P N: all is at rest if
//   sum_k A_k N_k w_kj = b_j,                                                                     (Gauss' theorem of these sums)
// and then a body of any number of particles is as long as it ought to be. The weights above are not quite so: a face would go 0.18
// spacings' strain too far. So the weights get second differences along the lattice line that goes inwards from i,
//   w_kj += sum_q c_kq (1, -2, 1 on the particles q, q + 1, q + 2 of the line),
// which no affine motion sees, with the c of least squares of what is left of b. On a plane face it is solved exactly. That is for faces
// with which the lattice lies flush, half a spacing behind; behind others the gradients are corrected (face_balance.hpp).

#include "structure/reference.hpp"
#include "structure/state.hpp"

namespace tern::structure {

/// Of each foot, a range of the rows that bear its load and their weights.
struct SurfaceWeights {
  std::vector<std::size_t> first = {0};  ///< of each foot, and one past the last
  std::vector<std::int32_t> bearer;      ///< row
  std::vector<double> weight;            ///< w_kj
};

/// Feet of free faces of solids: the particle behind, X_k - X_i [m], and A_k N_k [m^(D-1)]. A row of -1 stands for another foot: it has no
/// bearers.
template <int D>
SurfaceWeights surface_weights(const Reference<D>& reference, const std::vector<std::int32_t>& row, const std::vector<Vector<D>>& offset,
                               const std::vector<Vector<D>>& area);

}  // namespace tern::structure
