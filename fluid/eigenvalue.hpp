#pragma once
// A bound on the smallest eigenvalue of a symmetric matrix.

#include "base/vector.hpp"

namespace tern::fluid {

/// True when no eigenvalue of m is below `least`, that is, when the leading minors of m - least are not negative (a zero in
/// between is rounded to either side). Takes the part above the diagonal.
template <int D>
bool eigenvalues_reach(const Matrix<D>& m, double least) {
  const double a = m(0, 0) - least, b = m(0, 1), c = m(1, 1) - least, minor = a * c - b * b;
  if constexpr (D == 2) {
    return a >= 0 && minor >= 0 && c >= 0;
  } else {
    const double d = m(0, 2), e = m(1, 2), f = m(2, 2) - least;
    return a >= 0 && minor >= 0 && f >= 0 && minor * f - a * e * e + 2 * b * d * e - c * d * d >= 0;
  }
}

}  // namespace tern::fluid
