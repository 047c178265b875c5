#pragma once
// The arc tangent of two arguments without calls and branches, so that loops over it are computed many at a time.

#include <array>
#include <cmath>
#include <numbers>

namespace tern {

/// Angle of the vector (x, y) from the x axis in [-pi, pi], within two units in the last place; not for the zero vector.
inline double polar_angle(double x, double y) {
  // (arctan t - t) / t^3 as a polynomial of t^2 that interpolates it at the Chebyshev nodes of |t| <= tan(pi/8): 5e-18.
  constexpr std::array<double, 11> coefficient = {-0.3333333333333333,  0.1999999999999552,  -0.14285714284666542, 0.11111111015256361,
                                                  -0.09090904578123903, 0.07692183190826087, -0.06664511447381948, 0.0585814891280221,
                                                  -0.0508544973794026,  0.03923165829558719, -0.01917688711906226};
  constexpr double pi = std::numbers::pi, tan_of_eighth = 0.41421356237309503;
  const double ax = std::abs(x), ay = std::abs(y);
  const bool steep = ay > ax;
  const double small = steep ? ax : ay, large = steep ? ay : ax;
  // Beyond pi/8 the angle is that from the diagonal, so that the polynomial is short.
  const bool beyond = small > tan_of_eighth * large;
  const double t = (beyond ? small - large : small) / (beyond ? small + large : large);
  const double t2 = t * t;
  double sum = coefficient[10];
  for (int k = 9; k >= 0; --k) sum = sum * t2 + coefficient[k];
  double angle = t + t * t2 * sum;
  angle = beyond ? angle + pi / 4 : angle;
  angle = steep ? pi / 2 - angle : angle;
  angle = x < 0 ? pi - angle : angle;
  return std::copysign(angle, y);
}

}  // namespace tern
