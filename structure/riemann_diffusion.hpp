#pragma once
// Dissipation of velocity jumps between particles, as the upwind part of a Riemann solver has it (Lee, Gil, Ghavamian,
// Bonet 2019; "complete": both characteristics). It is the gradient of the dissipation function
//   R = 1/2 sum_pairs Dv_ij . Z_ij Dv_ij,   Z_ij = chi rho_0 V_i V_j |w'_ij| [ c_p n x n + c_s (I - n x n) ],
//   Dv_ij = v_j - v_i - (l_i + l_j)/2 x_ji,   n = direction of x_ji = x_j - x_i,   l = dv/dx,
//   f_i = -dR/dv_i = sum_j Z_ij Dv_ij + div P_i,   P_i = -1/(2 V_i) (sum_j Z_ij Dv_ij x x_ji) F_i^-T.
// The reconstructed jump Dv vanishes in every affine velocity field over a uniform deformation, and in every rigid motion of any
// deformation. P is what the reconstruction itself answers with; its divergence is that of the elastic force. So f takes
// energy from every other motion, and neither linear nor angular momentum.

#include "base/lanes.hpp"

namespace tern::structure {

/// Z_ij Dv_ij divided by chi rho_0 V_i V_j |w'|. `x`: x_j - x_i, `inverse_square`: 1/|x|^2, `reconstructed`: Dv_ij.
template <int D>
inline void riemann_diffusion(const Lanes (&x)[D], const Lanes& inverse_square, const Lanes (&reconstructed)[D], double pressure_speed,
                              double shear_speed, Lanes (&force)[D]) {
  Lanes normal = x[0] * reconstructed[0];
  for (int a = 1; a < D; ++a) normal += x[a] * reconstructed[a];
  const Lanes along = (pressure_speed - shear_speed) * normal * inverse_square;
  for (int a = 0; a < D; ++a) force[a] = along * x[a] + shear_speed * reconstructed[a];
}

}  // namespace tern::structure
