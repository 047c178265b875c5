#pragma once
// St Venant-Kirchhoff solid, Hooke's law between E = (F^T F - I)/2 and the second Piola-Kirchhoff stress S:
//   Psi = lambda/2 (tr E)^2 + mu E:E,   P = F S,   d2Psi = d_ik S_JL + F_iM C_MJNL F_kN.

#include <algorithm>
#include <cmath>

#include "structure/material/hooke.hpp"

namespace tern::structure {

struct StVenantKirchhoff : Hooke {
  static constexpr const char* key = "st_venant_kirchhoff";
  static constexpr const char* name = "St Venant-Kirchhoff";
  static constexpr const char* meaning = "St Venant-Kirchhoff (which gives way under strong compression)";
  static constexpr const char* weakness =
      "the St Venant-Kirchhoff solid softens under compression and has no resistance left below 0.58 of its length";

  using Hooke::Hooke;

  template <int D>
  double energy_density(const Matrix<D>& h, const Matrix<D>&) const {
    const Matrix<D> e = 0.5 * (h + h.transpose() + h.transpose() * h);
    return strain_energy<D>(e);
  }

  template <int D, class Number>
  [[gnu::always_inline]] inline void stress(const Number (&h)[D][D], const Number (&f)[D][D], const Number (&)[D][D], const Number&,
                                            Number (&p)[D][D]) const {
    Number e[D][D], s[D][D];
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) {
        e[a][b] = h[a][b] + h[b][a];
        for (int c = 0; c < D; ++c) e[a][b] += h[c][a] * h[c][b];
        e[a][b] *= 0.5;
      }
    strain_stress<D>(e, s);
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) {
        p[a][b] = f[a][0] * s[0][b];
        for (int c = 1; c < D; ++c) p[a][b] += f[a][c] * s[c][b];
      }
  }

  template <int D>
  Tangent4<D> tangent(const Matrix<D>& f) const {
    const Matrix<D> second = strain_stress<D>(0.5 * (f.transpose() * f - Matrix<D>::Identity()));
    Tangent4<D> result;
    for (int i = 0; i < D; ++i)
      for (int J = 0; J < D; ++J)
        for (int k = 0; k < D; ++k)
          for (int L = 0; L < D; ++L) {
            double& entry = result(i * D + J, k * D + L);
            entry = (i == k) * second(J, L);
            for (int M = 0; M < D; ++M)
              for (int N = 0; N < D; ++N) entry += f(i, M) * stiffness(M, J, N, L) * f(k, N);
          }
    return result;
  }

  double modulus_at(double stretch) const { return (plane_lambda + 2 * mu) * (1.5 * stretch * stretch - 0.5); }

  template <int D>
  OutOfPlane out_of_plane(const Matrix<D>& h, double j2) const {
    const Matrix<D> e = 0.5 * (h + h.transpose() + h.transpose() * h);
    if (plane_stress) return {std::sqrt(std::max(1 - 2 * lambda / (lambda + 2 * mu) * e.trace(), 0.0)), 0};
    return {1, lambda * e.trace() / j2};
  }
};

}  // namespace tern::structure
