#pragma once
// Velocity-divergence-error-mitigating (VEM) pressure of a fluid particle at the interface (seed paper eq. 7):
//   p_i = -rho_i C h |u|max div_i(u)
// As printed, the paper's switch gives the two sides of a pair different forces. Here a pair uses max(p_i, 0) mirrored on
// the surface, so both sides receive the same force and the term only ever pushes apart.

#include <algorithm>

namespace tern::coupler {

/// [Pa], >= 0.
inline double mitigation_pressure(double coefficient, double density, double smoothing_length, double largest_speed,
                                  double divergence) {
  return std::max(0.0, -density * coefficient * smoothing_length * largest_speed * divergence);
}

}  // namespace tern::coupler
