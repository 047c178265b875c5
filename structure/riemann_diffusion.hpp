#pragma once
// Dissipation of velocity jumps between particles, as the upwind part of a Riemann solver does it (Lee, Gil, Ghavamian,
// Bonet 2019; "complete": both characteristics):
//   f_i += sum_j chi rho_0 V_i V_j |w'_ij| [ c_p n x n + c_s (I - n x n) ] Dv_ij,
//   Dv_ij = v_j - v_i - (L_i + L_j)/2 X_ji,   n = current direction of the pair.
// The reconstructed jump Dv vanishes in every affine velocity field. Limiter: its normal (tangential) part is dropped where
// it opposes that of the plain jump v_j - v_i, so that every pair dissipates.

#include "base/lanes.hpp"

namespace tern::structure {

/// Force on i divided by chi rho_0 V_i V_j |w'|. `x`: x_j - x_i, `inverse_square`: 1/|x|^2, `jump`: v_j - v_i,
/// `reconstructed`: Dv_ij.
template <int D>
inline void riemann_diffusion(const Lanes (&x)[D], const Lanes& inverse_square, const Lanes (&jump)[D], const Lanes (&reconstructed)[D],
                              double pressure_speed, double shear_speed, Lanes (&force)[D]) {
  Lanes normal = x[0] * reconstructed[0], plain_normal = x[0] * jump[0], product = jump[0] * reconstructed[0];
  for (int a = 1; a < D; ++a) {
    normal += x[a] * reconstructed[a];
    plain_normal += x[a] * jump[a];
    product += jump[a] * reconstructed[a];
  }
  const Lanes normal_product = normal * plain_normal * inverse_square;
  const Lanes zero = {};
  const Lanes c_n = normal_product > zero ? broadcast(pressure_speed) : zero;
  const Lanes c_t = product > normal_product ? broadcast(shear_speed) : zero;
  const Lanes along = (c_n - c_t) * normal * inverse_square;
  for (int a = 0; a < D; ++a) force[a] = along * x[a] + c_t * reconstructed[a];
}

}  // namespace tern::structure
