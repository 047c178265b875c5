#pragma once
// The arc tangent of two arguments without calls and branches, so that loops over it are computed many at a time.

#include <array>
#include <cmath>
#include <numbers>

namespace tern {

/// Angle of the vector (x, y) from the x axis in [-pi, pi], within two units in the last place; not for the zero vector. In double or
/// single precision.
template <class Real>
[[gnu::always_inline]] inline Real polar_angle(Real x, Real y) {
  // (arctan t - t) / t^3 as a polynomial of t^2 that interpolates it at the Chebyshev nodes of |t| <= tan(pi/8): 5e-18.
  constexpr std::array<Real, 11> coefficient = {Real(-0.3333333333333333),  Real(0.1999999999999552),   Real(-0.14285714284666542),
                                                Real(0.11111111015256361),  Real(-0.09090904578123903), Real(0.07692183190826087),
                                                Real(-0.06664511447381948), Real(0.0585814891280221),   Real(-0.0508544973794026),
                                                Real(0.03923165829558719),  Real(-0.01917688711906226)};
  constexpr Real pi = std::numbers::pi_v<Real>, tan_of_eighth = Real(0.41421356237309503);
  const Real ax = std::abs(x), ay = std::abs(y);
  const bool steep = ay > ax;
  const Real small = steep ? ax : ay, large = steep ? ay : ax;
  // Beyond pi/8 the angle is that from the diagonal, so that the polynomial is short.
  const bool beyond = small > tan_of_eighth * large;
  const Real t = (beyond ? small - large : small) / (beyond ? small + large : large);
  const Real t2 = t * t;
  Real sum = coefficient[10];
  for (int k = 9; k >= 0; --k) sum = sum * t2 + coefficient[k];
  Real angle = t + t * t2 * sum;
  angle = beyond ? angle + pi / 4 : angle;
  angle = steep ? pi / 2 - angle : angle;
  angle = x < 0 ? pi - angle : angle;
  return std::copysign(angle, y);
}

}  // namespace tern
