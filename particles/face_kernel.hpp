#pragma once
// A wall or a structure enters the fluid's sums as a surface, not as layers of particles. For a fluid particle i and a
// flat face patch k (centre x_k, unit normal n_k towards the fluid, area A_k) the hidden side contributes
//   sum_hidden grad w       = - A_k w~(r) n_k                          (Gauss' theorem)
//   sum_hidden f            =   Omega_k  Int_r^2h f(s) s^(D-1) ds      (cone of solid angle Omega_k behind the patch)
// with f = w for the particle number density and f = s|w'| (times e e^T) for the correction matrix. The sums on the fluid
// side run over particles, not over a continuum; multiplying w and f by a polynomial in s, chosen such that the layers of a
// lattice resting on a plane see what a continued lattice would give them, removes the mismatch: on that lattice
// sum grad w = 0 to 1e-6, and n = n_ref, tr M = D up to the size of the patches (3e-3 with patches of dx/2 in 2D).

#include <algorithm>
#include <array>
#include <numbers>
#include <vector>

#include "particles/kernel.hpp"
#include "particles/lattice_sums.hpp"
#include "particles/vector.hpp"

namespace tern {

template <int D>
class FaceKernel {
 public:
  /// `spacing`: of the fluid particles [m]. Uses the calibrated gradient |w'|/M_xx throughout.
  FaceKernel(const Kernel<D>& kernel, double spacing);

  double support() const { return support_; }

  /// w~(r) [1/m^D]: sum_hidden grad w = -A w~ n.
  double surface_weight(double r) const { return kernel_.value(r) * evaluate(surface_, r); }
  /// Int_r^2h of the calibrated w s^(D-1) ds [-]; times the solid angle: hidden part of sum V w.
  double hidden_density(double r) const { return interpolate(density_, r); }
  /// Int_r^2h of the calibrated s|w'|/M_xx s^(D-1) ds [-]; times the solid angle: hidden part of tr M.
  double hidden_moment(double r) const { return interpolate(moment_, r); }

 private:
  static constexpr int terms = 3;
  using Polynomial = std::array<double, terms>;
  static double evaluate(const Polynomial& p, double s) { return p[0] + s * (p[1] + s * p[2]); }

  double interpolate(const std::vector<double>& table, double r) const {
    const double s = r * table_scale_;
    const auto k = static_cast<std::size_t>(s);
    if (k + 1 >= table.size()) return 0;
    const double f = s - static_cast<double>(k);
    return table[k] * (1 - f) + table[k + 1] * f;
  }

  Kernel<D> kernel_;
  double support_, table_scale_;
  Polynomial surface_{};
  std::vector<double> density_, moment_;
};

/// Angle (2D) or solid angle (3D) that a patch subtends at distance vector d = x_k - x_i (i on the side of the normal).
/// Exact for a straight segment of length `area` in 2D, for a square of that area in 3D whose sides follow the
/// coordinate axes as closely as the normal allows.
template <int D>
double subtended_angle(const Vector<D>& d, const Vector<D>& normal, double area) {
  const double height = -d.dot(normal);
  if (height <= 0) return 0;
  if constexpr (D == 2) {
    // Between the directions to the two ends: tan = cross product / dot product.
    const double along = d[0] * -normal[1] + d[1] * normal[0];
    return std::atan2(area * height, height * height + along * along - 0.25 * area * area);
  } else {
    int axis = 0;
    for (int c = 1; c < 3; ++c)
      if (std::abs(normal[c]) < std::abs(normal[axis])) axis = c;
    const Vector<3> first = Vector<3>(Vector<3>::Unit(axis) - normal[axis] * normal).normalized();
    const Vector<3> second = normal.cross(first);
    const double half = 0.5 * std::sqrt(area), u = d.dot(first), v = d.dot(second);
    // Signed sum of atan(a b / (height distance)) over the four corners (a, b), as the argument of a product of complex
    // numbers: one arc tangent in place of four.
    struct Complex {
      double re, im;
      Complex operator*(const Complex& o) const { return {re * o.re - im * o.im, re * o.im + im * o.re}; }
    };
    const auto corner = [height](double a, double b, double sign) {
      return Complex{height * std::sqrt(a * a + b * b + height * height), sign * a * b};
    };
    const Complex product = corner(u + half, v + half, 1) * corner(u - half, v + half, -1) *
                            (corner(u + half, v - half, -1) * corner(u - half, v - half, 1));
    const double angle = std::atan2(product.im, product.re);
    // Beyond pi only from close above the patch; elsewhere a negative angle is zero but for rounding.
    const bool close_above = height < half && std::abs(u) < half && std::abs(v) < half;
    return close_above && angle < 0 ? angle + 2 * std::numbers::pi : std::max(angle, 0.0);
  }
}

}  // namespace tern
