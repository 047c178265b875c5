#pragma once
// Restoring force against motions that the deformation gradient does not see (Ganzenmueller 2015): a bond whose length
// differs from what F of its ends says is pulled back, centrally and with opposite forces on both ends:
//   f_i = sum_j (alpha E/2) V_i V_j (w_ij/|X_ij|^2) (delta^i_ij + delta^j_ij) (x_i - x_j)/|x_ij|,
//   delta^k_ij = (F_k X_ji - x_ji) . x_ji/|x_ij|.

#include "base/lanes.hpp"

namespace tern::structure {

/// Force on i divided by alpha E V_i V_j w_ij/|X_ij|^2. `x`: x_j - x_i, `inverse_square`: 1/|x|^2,
/// `mismatch`: (F_i + F_j)/2 X_ji - x_ji.
template <int D>
inline void hourglass_penalty(const Lanes (&x)[D], const Lanes& inverse_square, const Lanes (&mismatch)[D], Lanes (&force)[D]) {
  Lanes along = x[0] * mismatch[0];
  for (int a = 1; a < D; ++a) along += x[a] * mismatch[a];
  along *= inverse_square;
  for (int a = 0; a < D; ++a) force[a] = -along * x[a];
}

}  // namespace tern::structure
