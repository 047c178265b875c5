#pragma once
// Cofactors of the deformation gradients of four particles, for F^-T = cof F / J.

#include "base/lanes.hpp"

namespace tern::structure {

/// Cofactors c of F; returns J.
inline Lanes cofactor(const Lanes (&f)[2][2], Lanes (&c)[2][2]) {
  c[0][0] = f[1][1];
  c[0][1] = -f[1][0];
  c[1][0] = -f[0][1];
  c[1][1] = f[0][0];
  return f[0][0] * c[0][0] + f[0][1] * c[0][1];
}

inline Lanes cofactor(const Lanes (&f)[3][3], Lanes (&c)[3][3]) {
  for (int a = 0; a < 3; ++a) {
    const int p = (a + 1) % 3, q = (a + 2) % 3;
    for (int b = 0; b < 3; ++b) {
      const int r = (b + 1) % 3, s = (b + 2) % 3;
      c[a][b] = f[p][r] * f[q][s] - f[p][s] * f[q][r];
    }
  }
  return f[0][0] * c[0][0] + f[0][1] * c[0][1] + f[0][2] * c[0][2];
}

}  // namespace tern::structure
