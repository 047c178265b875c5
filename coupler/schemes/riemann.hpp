#pragma once
// Dissipative part of the interface pressure from a Riemann problem between fluid and structure (seed paper eq. 6):
//   p* = (p_i + p_j)/2 + beta rho_bar c0 du / 2,   du = approach velocity of the two sides along the normal,
// with the limiter beta = min(eta max(du, 0)/c0, 1) (Zhang, Hu & Adams 2017): it acts on approach only, grows with du^2,
// and below du = c0/eta the sound speed c0 drops out.

#include <algorithm>

namespace tern::coupler {

/// Of two sides with the same sound speed, as the waves from their contact have it: 2 Z_1 Z_2/(Z_1 + Z_2) of their impedances rho c.
/// Beside a heavy side it is at most twice the density of the light one, whose particles the force stops. The arithmetic mean, as in the
/// seed paper, would throw those of a gas back.
inline double mean_density(double one, double other) { return 2 * one * other / (one + other); }

/// [Pa]. `approach` > 0: the sides move towards each other [m/s]; density: mean of both sides [kg/m^3]; sound speed [m/s].
inline double riemann_pressure(double limiter, double mean_density, double sound_speed, double approach) {
  if (approach <= 0) return 0;
  const double beta = std::min(limiter * approach / sound_speed, 1.0);
  return 0.5 * beta * mean_density * sound_speed * approach;
}

}  // namespace tern::coupler
