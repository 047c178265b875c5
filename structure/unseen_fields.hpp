#pragma once
// Completes the derivatives of a particle whose neighbours do not determine a quadratic fit. Two layers do not say how much thinner the
// one and how much thicker the other becomes in bending. Every fit G, K can have, with any vectors a_r, the vanishing fields p_r
// (gradient_vectors.hpp), of gradient b_r and second derivatives c_r. They take the values of the least energy of the strain gradient,
//   F = G (I + sum_r a_r x b_r),   K' = G (k + sum_r a_r x c_r),   k = G^-1 K,
//   a = arg min sum_d [ lambda (tr D_d)^2 + 2 mu D_d:D_d ],   D_d = sym(k_d + sum_r a_r x c_r d),   so  a_r = A_r k,
// with constant A_r. A rotation turns G and K and leaves k and a: the energy W(F, K') does not see it. In a homogeneous deformation k is
// zero, and nothing is added. Of a plate in bending, a is what lets the stress across it vanish.
//
// Stresses follow by the chain rule. With P = dW/dF and Q = dW/dK', w_r = P b_r + Q:c_r and t = sum_r A_r^T (G^T w_r),
//   dW/dK = Q + G^-T t,   dW/dG = P + sum_r w_r x a_r - (G^-T t):k.

#include <vector>

#include "base/lanes.hpp"
#include "structure/gradient_vectors.hpp"
#include "structure/material/hooke.hpp"

namespace tern::structure {

/// Number: Lanes for four particles, double for one.
template <int D, class Number = Lanes>
struct UnseenField {
  Number gradient[D];                               ///< b [m]
  Number curvature[curvature_components<D>];        ///< c
  Number amplitude[D][D][curvature_components<D>];  ///< A: a_c = sum_mn A_c,mn k_m,n
};

/// Those of a particle, of a body that answers small strains as `hooke`.
template <int D>
std::vector<UnseenField<D, double>> unseen_fields(const std::vector<VanishingField<D>>& vanishing, const Hooke& hooke);

/// Those of one of four particles; all zero where it has fewer of them than another.
template <int D>
UnseenField<D, double> of_lane(const UnseenField<D>& fields, int lane) {
  UnseenField<D, double> field;
  for (int b = 0; b < D; ++b) field.gradient[b] = fields.gradient[b][lane];
  for (int n = 0; n < curvature_components<D>; ++n) {
    field.curvature[n] = fields.curvature[n][lane];
    for (int c = 0; c < D; ++c)
      for (int m = 0; m < D; ++m) field.amplitude[c][m][n] = fields.amplitude[c][m][n][lane];
  }
  return field;
}

/// k = G^-1 K.
template <int D, class Number>
[[gnu::always_inline]] inline void pull_back(const Number (&inverse_transposed)[D][D], const Number (&k)[D][curvature_components<D>],
                                             Number (&pulled)[D][curvature_components<D>]) {
  for (int m = 0; m < D; ++m)
    for (int n = 0; n < curvature_components<D>; ++n) {
      pulled[m][n] = inverse_transposed[0][m] * k[0][n];
      for (int i = 1; i < D; ++i) pulled[m][n] += inverse_transposed[i][m] * k[i][n];
    }
}

/// a = A k.
template <int D, class Number>
[[gnu::always_inline]] inline void amplitude_of(const UnseenField<D, Number>& field, const Number (&pulled)[D][curvature_components<D>],
                                                Number (&a)[D]) {
  for (int c = 0; c < D; ++c) {
    a[c] = Number{};
    for (int m = 0; m < D; ++m)
      for (int n = 0; n < curvature_components<D>; ++n) a[c] += field.amplitude[c][m][n] * pulled[m][n];
  }
}

/// Turns H = G - I and K of the fit into F - I and K'.
template <int D, class Number>
[[gnu::always_inline]] inline void complete(const UnseenField<D, Number>* first, std::uint32_t count, const Number (&g)[D][D],
                                            const Number (&inverse_transposed)[D][D], Number (&h)[D][D],
                                            Number (&k)[D][curvature_components<D>]) {
  Number pulled[D][curvature_components<D>];
  pull_back<D>(inverse_transposed, k, pulled);
  for (std::uint32_t r = 0; r < count; ++r) {
    Number a[D];
    amplitude_of<D>(first[r], pulled, a);
    for (int i = 0; i < D; ++i) {
      Number turned = g[i][0] * a[0];
      for (int c = 1; c < D; ++c) turned += g[i][c] * a[c];
      for (int b = 0; b < D; ++b) h[i][b] += turned * first[r].gradient[b];
      for (int n = 0; n < curvature_components<D>; ++n) k[i][n] += turned * first[r].curvature[n];
    }
  }
}

/// Turns P = dW/dF and Q = dW/dK' into dW/dG and dW/dK; `g` and `k` of the fit.
template <int D, class Number>
[[gnu::always_inline]] inline void stress_of_fit(const UnseenField<D, Number>* first, std::uint32_t count, const Number (&g)[D][D],
                                                 const Number (&inverse_transposed)[D][D], const Number (&k)[D][curvature_components<D>],
                                                 Number (&p)[D][D], Number (&q)[D][curvature_components<D>]) {
  constexpr int pairs = curvature_components<D>;
  Number pulled[D][pairs], t[D][pairs] = {}, added[D][D] = {};
  pull_back<D>(inverse_transposed, k, pulled);
  for (std::uint32_t r = 0; r < count; ++r) {
    const UnseenField<D, Number>& field = first[r];
    Number a[D], w[D];
    amplitude_of<D>(field, pulled, a);
    for (int i = 0; i < D; ++i) {
      w[i] = p[i][0] * field.gradient[0];
      for (int b = 1; b < D; ++b) w[i] += p[i][b] * field.gradient[b];
      for (int n = 0; n < pairs; ++n) w[i] += q[i][n] * field.curvature[n];
      for (int c = 0; c < D; ++c) added[i][c] += w[i] * a[c];
    }
    for (int c = 0; c < D; ++c) {
      Number s = g[0][c] * w[0];
      for (int i = 1; i < D; ++i) s += g[i][c] * w[i];
      for (int m = 0; m < D; ++m)
        for (int n = 0; n < pairs; ++n) t[m][n] += s * field.amplitude[c][m][n];
    }
  }
  for (int i = 0; i < D; ++i) {
    for (int n = 0; n < pairs; ++n) {
      Number more = inverse_transposed[i][0] * t[0][n];
      for (int m = 1; m < D; ++m) more += inverse_transposed[i][m] * t[m][n];
      q[i][n] += more;
      for (int c = 0; c < D; ++c) added[i][c] -= more * pulled[c][n];
    }
    for (int c = 0; c < D; ++c) p[i][c] += added[i][c];
  }
}

}  // namespace tern::structure
