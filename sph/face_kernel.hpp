#pragma once
// A wall or a structure enters the fluid's sums as a surface, not as layers of particles. For a fluid particle i and a
// flat face patch k (centre x_k, unit normal n_k towards the fluid, area A_k) the hidden side contributes
//   sum_hidden grad w       = - A_k w~(r) n_k                          (Gauss' theorem)
//   sum_hidden f            =   Omega_k  Int_r^2h f(s) s^(D-1) ds      (cone of solid angle Omega_k behind the patch)
// with f = w for the particle number density and f = s|w'| (times e e^T) for the correction matrix. The sums on the fluid
// side run over particles, not over a continuum; multiplying w and f by a polynomial in s, chosen such that the layers of a
// lattice resting on a plane see what a continued lattice would give them, removes the mismatch: on that lattice
// sum grad w = 0 to 1e-6, and n = n_ref, tr M = D up to the size of the patches (3e-3 with patches of dx/2 in 2D).
//
// A whole plane at the distance y hides from i the cones of a half space. With the calibrated f and cos = y/s for a shell of radius s,
//   sum_hidden f        = 2 pi Int_y^2h f(s) s^2 (1 - y/s) ds
//   sum_hidden f e_n^2  = 2 pi / 3 Int_y^2h f(s) s^2 (1 - y^3/s^3) ds
//   sum A w~            = 2 pi Int_y^2h w~(s) s ds
// in 3D: functions of y alone, without an error by the size of patches.

#include <algorithm>
#include <array>
#include <numbers>
#include <vector>

#include "base/vector.hpp"
#include "sph/kernel.hpp"
#include "sph/lattice_sums.hpp"
#include "sph/polar_angle.hpp"

namespace tern {

/// What a cone behind a face adds to the sum of w~, in single precision, so that eight are computed at a time.
struct ConeKernel {
  float inverse_h, value, gradient, table_scale, support, rest;
  std::array<float, 3> surface;
  std::vector<float> beyond;

  /// Of a cone of this solid angle behind a face of this area that is seen at this cosine, `r` away [-]: the volume in it from there on,
  /// less what the sum over a lattice lacks (FaceKernel::midpoint_rest()).
  [[gnu::always_inline]] float operator()(float r, float angle, float area, float cosine) const {
    const float q = r * inverse_h, s = std::max(0.0F, 1 - 0.5F * q), s3 = s * s * s;
    const float bent = surface[0] + r * (surface[1] + r * surface[2]);
    const float slope = value * s3 * s * (2 * q + 1) * (surface[1] + 2 * r * surface[2]) - r * gradient * s3 * bent;
    const float at = std::min(r, support) * table_scale;
    const int k = static_cast<int>(at);
    const float f = at - static_cast<float>(k);
    const float* before = beyond.data();
    return angle * (before[k] * (1 - f) + before[k + 1] * f) - area * cosine * rest * slope;
  }
};

template <int D>
class FaceKernel {
 public:
  /// `spacing`: of the fluid particles [m]. Uses the calibrated gradient |w'|/M_xx throughout.
  FaceKernel(const Kernel<D>& kernel, double spacing);

  double support() const { return support_; }

  /// w~(r) [1/m^D]: sum_hidden grad w = -A w~ n.
  double surface_weight(double r) const { return kernel_.value(r) * evaluate(surface_, r); }
  /// Int_r^2h w~ s^(D-1) ds [-]; times a solid angle: what the volume in it, from r on, adds to the sum of w~ at a face.
  double surface_weight_beyond(double r) const { return interpolate(beyond_, r); }
  const ConeKernel& cones() const { return cones_; }
  /// -(dx^2/24) dw~/dr [1/m^(D-1)]. The sum of V w~ over a lattice is a midpoint rule: it lacks the integral of (dx^2/24) lap w~ over the
  /// volume, which is this times the area of each patch and the cosine at which it is seen (Gauss' theorem).
  double midpoint_rest(double r) const {
    const double slope = kernel_.value(r) * (surface_[1] + 2 * r * surface_[2]) - r * kernel_.gradient_weight(r) * evaluate(surface_, r);
    return -spacing_ * spacing_ / 24 * slope;
  }
  /// Int_r^2h of the calibrated w s^(D-1) ds [-]; times the solid angle: hidden part of sum V w.
  double hidden_density(double r) const { return interpolate(density_, r); }
  /// Int_r^2h of the calibrated s|w'|/M_xx s^(D-1) ds [-]; times the solid angle: hidden part of tr M.
  double hidden_moment(double r) const { return interpolate(moment_, r); }

  /// What all patches of a whole plane add up to, as these become small.
  struct PlaneSums {
    double density;        ///< hidden part of sum V w [-]
    double normal, along;  ///< of M: along the normal, and along either direction of the plane [-]
    double weight;         ///< sum A w~ [1/m]
  };
  /// Of a plane at this distance. In 3D.
  PlaneSums behind_plane(double height) const requires(D == 3) {
    const double s = std::min(height, support_) * table_scale_;
    const int k = static_cast<int>(s);
    const double f = s - k;
    const PlaneSums &a = plane_[k], &b = plane_[k + 1];
    const auto between = [f](double before, double after) { return before * (1 - f) + after * f; };
    return {between(a.density, b.density), between(a.normal, b.normal), between(a.along, b.along), between(a.weight, b.weight)};
  }

 private:
  static constexpr int terms = 3;
  using Polynomial = std::array<double, terms>;
  static double evaluate(const Polynomial& p, double s) { return p[0] + s * (p[1] + s * p[2]); }

  /// Tables end with two zeros, at the support and beyond.
  double interpolate(const std::vector<double>& table, double r) const {
    const double s = std::min(r, support_) * table_scale_;
    const int k = static_cast<int>(s);
    const double f = s - k;
    return table[k] * (1 - f) + table[k + 1] * f;
  }

  Kernel<D> kernel_;
  double spacing_, support_, table_scale_;
  Polynomial surface_{};
  std::vector<double> density_, moment_, beyond_;
  std::vector<PlaneSums> plane_;  ///< empty in 2D
  ConeKernel cones_;
};

/// Sets what subtended_angle() needs of a patch wherever it is seen from: its length in 2D. In 3D, with e the axis most nearly along the
/// patch less its part along the normal, the length of e, which is the scale of all lengths, and half a side in that scale.
template <int D, class Normal>
[[gnu::always_inline]] inline void set_patch_sides(const Normal& normal, double area, double (&sides)[D - 1]) {
  if constexpr (D == 2) {
    sides[0] = area;
  } else {
    double tilt = std::abs(normal[1]) < std::abs(normal[0]) ? normal[1] : normal[0];
    tilt = std::abs(normal[2]) < std::abs(tilt) ? normal[2] : tilt;
    const double scale = std::sqrt(1 - tilt * tilt);
    sides[0] = scale, sides[1] = 0.5 * scale * std::sqrt(area);
  }
}

/// Angle (2D) or solid angle (3D) that a patch with these sides subtends at distance vector d = x_k - x_i (i on the side of the normal).
/// Exact for a straight segment in 2D, for a square in 3D whose sides follow the coordinate axes as closely as the normal allows. Without
/// branches and calls, so that loops over patches are computed many at a time; `d` and `normal` are vectors, or arrays in such a loop.
template <int D, class Distance, class Normal>
[[gnu::always_inline]] inline double subtended_angle(const Distance& d, const Normal& normal, const double (&sides)[D - 1]) {
  if constexpr (D == 2) {
    const double area = sides[0], height = -(d[0] * normal[0] + d[1] * normal[1]);
    // Between the directions to the two ends: tan = cross product / dot product.
    const double along = d[0] * -normal[1] + d[1] * normal[0];
    const double angle = polar_angle(height * height + along * along - 0.25 * area * area, area * height);
    return height > 0 ? angle : 0.0;
  } else {
    // The sides are along e and normal x e, both of the length `scale`. The angle does not change with the scale of all lengths, so the
    // others take it on instead of a division. The sign of v does not matter.
    const double height = -(d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2]);
    const double cross[] = {d[1] * normal[2] - d[2] * normal[1], d[2] * normal[0] - d[0] * normal[2], d[0] * normal[1] - d[1] * normal[0]};
    const bool second = std::abs(normal[1]) < std::abs(normal[0]);
    double along = second ? d[1] : d[0], tilt = second ? normal[1] : normal[0], v = second ? cross[1] : cross[0];
    const bool third = std::abs(normal[2]) < std::abs(tilt);
    along = third ? d[2] : along, tilt = third ? normal[2] : tilt, v = third ? cross[2] : v;
    const double u = along + tilt * height, half = sides[1], level = sides[0] * height;
    // Signed sum of atan(a b / (level distance)) over the four corners (a, b), as the argument of a product of complex
    // numbers: one arc tangent in place of four.
    struct Complex {
      double re, im;
      Complex operator*(const Complex& o) const { return {re * o.re - im * o.im, re * o.im + im * o.re}; }
    };
    const auto corner = [level](double a, double b, double sign) {
      return Complex{level * std::sqrt(a * a + b * b + level * level), sign * a * b};
    };
    const Complex product =
        corner(u + half, v + half, 1) * corner(u - half, v + half, -1) * (corner(u + half, v - half, -1) * corner(u - half, v - half, 1));
    const double angle = polar_angle(product.re, product.im);
    // Beyond pi only from close above the patch; elsewhere a negative angle is zero but for rounding.
    const bool close_above = (level < half) & (std::abs(u) < half) & (std::abs(v) < half);
    const double seen = angle >= 0 ? angle : close_above ? angle + 2 * std::numbers::pi : 0.0;
    return height > 0 ? seen : 0.0;
  }
}

template <int D, class Distance, class Normal>
[[gnu::always_inline]] inline double subtended_angle(const Distance& d, const Normal& normal, double area) {
  double sides[D - 1];
  set_patch_sides<D>(normal, area, sides);
  return subtended_angle<D>(d, normal, sides);
}

/// The same in single precision, to 1e-5 of itself from a twentieth of a side away: in 3D as that of two triangles (Van Oosterom &
/// Strackee 1983), whose small angles are no differences of large ones.
template <int D>
[[gnu::always_inline]] inline float subtended_angle(const float (&d)[D], const float (&normal)[D], float area) {
  if constexpr (D == 2) {
    const float height = -(d[0] * normal[0] + d[1] * normal[1]), along = d[0] * -normal[1] + d[1] * normal[0];
    const float angle = polar_angle(height * height + along * along - 0.25F * area * area, area * height);
    return height > 0 ? angle : 0.0F;
  } else {
    const float height = -(d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2]);
    const float cross[] = {d[1] * normal[2] - d[2] * normal[1], d[2] * normal[0] - d[0] * normal[2], d[0] * normal[1] - d[1] * normal[0]};
    const bool second = std::abs(normal[1]) < std::abs(normal[0]);
    float along = second ? d[1] : d[0], tilt = second ? normal[1] : normal[0], v = second ? cross[1] : cross[0];
    const bool third = std::abs(normal[2]) < std::abs(tilt);
    along = third ? d[2] : along, tilt = third ? normal[2] : tilt, v = third ? cross[2] : v;
    // In half sides.
    const float scale = std::sqrt(1 - tilt * tilt), unit = 2 / (scale * std::sqrt(area));
    const float u = unit * (along + tilt * height), w = unit * v, level = unit * scale * height, level2 = level * level;
    const float a = u - 1, b = u + 1, c = w - 1, e = w + 1;
    const float ac = std::sqrt(a * a + c * c + level2), bc = std::sqrt(b * b + c * c + level2);
    const float be = std::sqrt(b * b + e * e + level2), ae = std::sqrt(a * a + e * e + level2);
    const float diagonal = a * b + c * e + level2;
    const float first = ac * bc * be + (a * b + c * c + level2) * be + diagonal * bc + (b * b + c * e + level2) * ac;
    const float other = ac * be * ae + (a * a + c * e + level2) * be + diagonal * ae + (a * b + e * e + level2) * ac;
    const float triple = 4 * level;
    const float angle = polar_angle(first * other - triple * triple, std::abs(triple * (first + other)));
    return height > 0 ? 2 * angle : 0.0F;
  }
}

}  // namespace tern
