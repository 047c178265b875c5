#pragma once
// What a window did to momentum and energy (docs/THEORY.md, section 3).

#include "base/vector.hpp"

namespace tern::coupler {

template <int D>
struct Setup;
template <int D>
struct Workspace;

/// Momentum errors are relative to the sum of the force magnitudes.
struct WindowAudit {
  double force_error = 0;                                   ///< |sum of all forces| / sum of |force|
  double force_sum = 0, force_size = 0;                     ///< numerator and denominator of force_error [N/m^(3-D)]
  double moment_error = 0;                                  ///< the same for moments about the origin, relative to sum |x| |force|
  double work_on_fluid = 0;                                 ///< by the surface moving at the velocity that the fluid saw [J/m^(3-D)]
  double riemann_dissipation = 0, contact_dissipation = 0;  ///< >= 0 [J/m^(3-D)]
  /// [J/m^(3-D)]; negative where the fluid alone squeezes a particle while the face recedes.
  double mitigation_dissipation = 0;
  int particles = 0, pairs = 0, contacts = 0;
};

/// Sums forces, moments and work of the window into its audit. Throws NumericalFailure when a load is not finite.
template <int D>
void audit_balance(Workspace<D>& window);

}  // namespace tern::coupler
