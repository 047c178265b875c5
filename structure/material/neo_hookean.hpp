#pragma once
// Compressible neo-Hookean solid (seed paper eq. 4), J = det F, J_2 the determinant in the plane:
//   Psi = mu/2 (tr F^T F - 3) - mu ln J + lambda/2 (ln J)^2,   P = mu F + (lambda ln J - mu) F^-T,
//   d2Psi = mu d_ik d_JL + (mu - lambda ln J) Fi_Jk Fi_Li + lambda Fi_Ji Fi_Lk,   Fi = F^-1.

#include <cmath>

#include "base/lanes.hpp"
#include "structure/material/hooke.hpp"

namespace tern::structure {

struct NeoHookean : Hooke {
  static constexpr const char* key = "neo_hookean";
  static constexpr const char* name = "neo-Hookean";
  static constexpr const char* meaning = "compressible neo-Hookean";
  static constexpr const char* weakness = nullptr;

  using Hooke::Hooke;

  template <int D>
  double energy_density(const Matrix<D>& h, const Matrix<D>& f) const {
    // tr F^T F - D = 2 tr H + H:H, which does not lose the digits of a small strain.
    double trace = 2 * h.trace() + h.squaredNorm(), log_j = std::log(f.determinant());
    if (plane_stress) {
      const double log_f33 = log_thickness_stretch(log_j);
      trace += std::expm1(2 * log_f33);
      log_j += log_f33;
    }
    return 0.5 * mu * trace - mu * log_j + 0.5 * lambda * log_j * log_j;
  }

  template <int D, class Number>
  [[gnu::always_inline]] inline void stress(const Number (&)[D][D], const Number (&f)[D][D], const Number (&inverse_transposed)[D][D],
                                            const Number& j, Number (&p)[D][D]) const {
    using std::log;
    using tern::log;
    Number log_j = log(j);
    if (plane_stress) log_j += each_lane(log_j, [this](double log_j2) { return log_thickness_stretch(log_j2); });
    const Number factor = lambda * log_j - mu;
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) p[a][b] = mu * f[a][b] + factor * inverse_transposed[a][b];
  }

  template <int D>
  Tangent4<D> tangent(const Matrix<D>& f) const {
    const Matrix<D> inverse = f.inverse();
    double log_j = std::log(f.determinant()), thick_lambda = lambda;
    if (plane_stress) {
      // The thickness answers: d ln J / d ln J_2 = 2 mu F33^2/(2 mu F33^2 + lambda).
      const double log_f33 = log_thickness_stretch(log_j), stiffness_33 = 2 * mu * std::exp(2 * log_f33);
      log_j += log_f33;
      thick_lambda *= stiffness_33 / (stiffness_33 + lambda);
    }
    Tangent4<D> result;
    for (int i = 0; i < D; ++i)
      for (int J = 0; J < D; ++J)
        for (int k = 0; k < D; ++k)
          for (int L = 0; L < D; ++L)
            result(i * D + J, k * D + L) = mu * (i == k) * (J == L) + (mu - lambda * log_j) * inverse(J, k) * inverse(L, i) +
                                           thick_lambda * inverse(J, i) * inverse(L, k);
    return result;
  }

  double modulus_at(double stretch) const {
    const double s2 = stretch * stretch;
    return mu * (1 + 1 / s2) + plane_lambda * (1 - std::log(stretch)) / s2;
  }

  template <int D>
  OutOfPlane out_of_plane(const Matrix<D>&, double j2) const {
    const double log_j2 = std::log(j2);
    if (plane_stress) return {std::exp(log_thickness_stretch(log_j2)), 0};
    return {1, lambda * log_j2 / j2};
  }

  /// ln F33 in plane stress, mu (F33^2 - 1) + lambda ln (J_2 F33) = 0; with two `free` directions, each of this stretch, that of
  /// J_2 F33^2. Newton's method in ln F33, in which the function is convex and rising.
  double log_thickness_stretch(double log_j2, double free = 1) const {
    double y = -lambda * log_j2 / (free * lambda + 2 * mu);
    for (int n = 0; n < 50; ++n) {
      const double square = std::exp(2 * y);
      const double step = (mu * (square - 1) + lambda * (log_j2 + free * y)) / (2 * mu * square + free * lambda);
      y -= step;
      if (!(std::abs(step) > 1e-15 * (1 + std::abs(y)))) break;
    }
    return y;
  }
};

}  // namespace tern::structure
