#pragma once
// Hooke's law, S = lambda tr(E) I + 2 mu E: what every material is at small strain. In plane stress
// lambda becomes 2 lambda mu/(lambda + 2 mu).

#include <cmath>

#include "base/vector.hpp"
#include "structure/material/parameters.hpp"

namespace tern::structure {

struct Hooke {
  double density = 0;         ///< rho_0 [kg/m^3]
  double young_modulus = 0;   ///< E [Pa]
  double lambda = 0, mu = 0;  ///< Lame constants [Pa]
  double plane_lambda = 0;    ///< lambda; in plane stress that within the plane
  bool plane_stress = false;

  explicit Hooke(const MaterialParameters& parameters)
      : density(parameters.density), young_modulus(parameters.young_modulus), plane_stress(parameters.plane_stress) {
    const double e = young_modulus, nu = parameters.poisson_ratio;
    lambda = e * nu / ((1 + nu) * (1 - 2 * nu));
    mu = e / (2 * (1 + nu));
    plane_lambda = plane_stress ? 2 * lambda * mu / (lambda + 2 * mu) : lambda;
  }

  /// Speeds of pressure and shear waves in the reference configuration [m/s].
  double pressure_wave_speed() const { return std::sqrt((plane_lambda + 2 * mu) / density); }
  double shear_wave_speed() const { return std::sqrt(mu / density); }

  /// Energy [J/m^3] and stress [Pa] of the strain e.
  template <int D>
  double strain_energy(const Matrix<D>& e) const {
    return 0.5 * plane_lambda * e.trace() * e.trace() + mu * e.squaredNorm();
  }
  template <int D>
  Matrix<D> strain_stress(const Matrix<D>& e) const {
    return plane_lambda * e.trace() * Matrix<D>::Identity() + 2 * mu * e;
  }
  /// The same, s and e four particles at once or one.
  template <int D, class Number>
  [[gnu::always_inline]] inline void strain_stress(const Number (&e)[D][D], Number (&s)[D][D]) const {
    Number trace = e[0][0];
    for (int a = 1; a < D; ++a) trace += e[a][a];
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) s[a][b] = 2 * mu * e[a][b];
    for (int a = 0; a < D; ++a) s[a][a] += plane_lambda * trace;
  }
  /// Stiffness C_abcd.
  double stiffness(int a, int b, int c, int d) const {
    return plane_lambda * (a == b) * (c == d) + mu * ((a == c) * (b == d) + (a == d) * (b == c));
  }
};

/// d2Psi/dF dF with the rows and columns of F one after the other: entry (i D + J, k D + L).
template <int D>
using Tangent4 = Eigen::Matrix<double, D * D, D * D>;

/// What happens across the plane in 2D.
struct OutOfPlane {
  double stretch = 1;  ///< F33
  double stress = 0;   ///< sigma_33 [Pa]
};

}  // namespace tern::structure
