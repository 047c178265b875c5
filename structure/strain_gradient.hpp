#pragma once
// The part of the strain gradient in the stresses of a cell, see first_piola_kirchhoff.cpp.

#include "base/lanes.hpp"
#include "structure/gradient_vectors.hpp"
#include "structure/material/hooke.hpp"

namespace tern::structure {

/// Adds the part of the strain gradient K to P, and gives Q. `factor` = dx^2/12.
template <int D>
[[gnu::always_inline]] inline void strain_gradient(const Hooke& hooke, double factor, const Lanes (&inverse_transposed)[D][D],
                                                   const Lanes (&k)[D][curvature_components<D>], Lanes (&p)[D][D],
                                                   Lanes (&q)[D][curvature_components<D>]) {
  for (int direction = 0; direction < D; ++direction) {
    Lanes b[D][D], d[D][D], s[D][D];
    for (int i = 0; i < D; ++i)
      for (int l = 0; l < D; ++l) {
        b[i][l] = k[i][curvature_index<D>(direction, 0)] * inverse_transposed[l][0];
        for (int m = 1; m < D; ++m) b[i][l] += k[i][curvature_index<D>(direction, m)] * inverse_transposed[l][m];
      }
    for (int i = 0; i < D; ++i)
      for (int l = 0; l <= i; ++l) d[i][l] = d[l][i] = (0.5 * factor) * (b[i][l] + b[l][i]);
    hooke.strain_stress<D>(d, s);
    for (int m = 0; m < D; ++m) {
      Lanes stress[D];
      for (int i = 0; i < D; ++i) {
        stress[i] = s[i][0] * inverse_transposed[0][m];
        for (int l = 1; l < D; ++l) stress[i] += s[i][l] * inverse_transposed[l][m];
        q[i][curvature_index<D>(direction, m)] += stress[i];
      }
      for (int i = 0; i < D; ++i)
        for (int l = 0; l < D; ++l) p[i][m] -= b[l][i] * stress[l];
    }
  }
}

}  // namespace tern::structure
