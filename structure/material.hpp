#pragma once
// Compressible neo-Hookean solid (seed paper eq. 4): energy density
//   Psi = mu/2 (tr F^T F - D) - mu ln J + lambda/2 (ln J)^2,   J = det F,
// P = dPsi/dF. 2D is plane strain (F33 = 1).

#include <cmath>

namespace tern::structure {

struct Material {
  double density = 0;        ///< rho_0 [kg/m^3]
  double young_modulus = 0;  ///< E [Pa]
  double lambda = 0, mu = 0; ///< Lame constants [Pa]

  static Material isotropic(double density, double young_modulus, double poisson_ratio) {
    const double e = young_modulus, nu = poisson_ratio;
    return {density, e, e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu))};
  }

  /// Speeds of pressure and shear waves in the reference configuration [m/s].
  double pressure_wave_speed() const { return std::sqrt((lambda + 2 * mu) / density); }
  double shear_wave_speed() const { return std::sqrt(mu / density); }

  /// Largest wave speed along a direction stretched by `stretch`, from d2 Psi / d stretch2 [m/s].
  double wave_speed_at(double stretch) const {
    const double s2 = 1 / (stretch * stretch);
    return std::sqrt((mu * (1 + s2) + lambda * (1 - std::log(stretch)) * s2) / density);
  }
};

}  // namespace tern::structure
