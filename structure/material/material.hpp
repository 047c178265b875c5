#pragma once
// Isotropic hyperelastic solids, P = dPsi/dF, J = det F:
//   compressible neo-Hookean (seed paper eq. 4)  Psi = mu/2 (tr F^T F - 3) - mu ln J + lambda/2 (ln J)^2,
//   St Venant-Kirchhoff                          Psi = lambda/2 (tr E)^2 + mu E:E,   E = (F^T F - I)/2.
// 2D is plane strain (F33 = 1) or plane stress (F33 such that P33 = 0; Psi is then the minimum over F33, so that
// dPsi/dF of the plane part needs no further term).

#include <algorithm>
#include <cmath>

#include "scene/case_file.hpp"

namespace tern::structure {

struct Material {
  double density = 0;         ///< rho_0 [kg/m^3]
  double young_modulus = 0;   ///< E [Pa]
  double lambda = 0, mu = 0;  ///< Lame constants [Pa]
  double plane_lambda = 0;    ///< lambda; in plane stress 2 lambda mu/(lambda + 2 mu): Hooke's law within the plane
  MaterialLaw law = MaterialLaw::neo_hookean;
  bool plane_stress = false;

  static Material isotropic(double density, double young_modulus, double poisson_ratio, MaterialLaw law = MaterialLaw::neo_hookean,
                            bool plane_stress = false) {
    const double e = young_modulus, nu = poisson_ratio;
    const double lambda = e * nu / ((1 + nu) * (1 - 2 * nu)), mu = e / (2 * (1 + nu));
    return {density, e, lambda, mu, plane_stress ? 2 * lambda * mu / (lambda + 2 * mu) : lambda, law, plane_stress};
  }

  /// Speeds of pressure and shear waves in the reference configuration [m/s].
  double pressure_wave_speed() const { return std::sqrt((plane_lambda + 2 * mu) / density); }
  double shear_wave_speed() const { return std::sqrt(mu / density); }

  /// Wave speed along a direction stretched by `stretch`, from d2 Psi / d stretch2 [m/s].
  double wave_speed_at(double stretch) const {
    const double s2 = stretch * stretch;
    const double modulus = law == MaterialLaw::neo_hookean ? mu * (1 + 1 / s2) + plane_lambda * (1 - std::log(stretch)) / s2
                                                           : (plane_lambda + 2 * mu) * (1.5 * s2 - 0.5);
    return std::sqrt(std::max(modulus, 0.0) / density);
  }

  /// ln F33 of the neo-Hookean solid in plane stress, mu (F33^2 - 1) + lambda ln (J_2 F33) = 0, J_2 the determinant in the
  /// plane. Newton's method in ln F33, in which the function is convex and rising.
  double log_thickness_stretch(double log_j2) const {
    double y = -lambda * log_j2 / (lambda + 2 * mu);
    for (int n = 0; n < 50; ++n) {
      const double square = std::exp(2 * y);
      const double step = (mu * (square - 1) + lambda * (log_j2 + y)) / (2 * mu * square + lambda);
      y -= step;
      if (!(std::abs(step) > 1e-15 * (1 + std::abs(y)))) break;
    }
    return y;
  }
};

}  // namespace tern::structure
