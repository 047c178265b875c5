#pragma once
// Compressible Mooney-Rivlin solid (Rivlin and Saunders 1951; the volumetric part uncoupled, Simo and Taylor 1982):
//   Psi = C10 (I1 J^-2/3 - 3) + C01 (I2 J^-4/3 - 3) + kappa/2 (J - 1)^2,   I1 = tr C,  I2 = (I1^2 - tr C^2)/2,  C = F^T F,
//   P = 2 (a + b I1) F - 2 b F C + [ kappa (J - 1) J - 2/3 a I1 - 4/3 b I2 ] F^-T,   a = C10 J^-2/3,  b = C01 J^-4/3.
// C10 + C01 = mu/2 and kappa = lambda + 2 mu/3 make it Hooke's law at small strain; C01/(C10 + C01) is `mooney_ratio`.
// C is that of space: in 2D it has the entry F33^2 across the plane.

#include <algorithm>
#include <cmath>

#include "base/lanes.hpp"
#include "structure/material/hooke.hpp"

namespace tern::structure {

struct MooneyRivlin : Hooke {
  static constexpr const char* key = "mooney_rivlin";
  static constexpr const char* name = "Mooney-Rivlin";
  static constexpr const char* meaning = "compressible Mooney-Rivlin (with `mooney_ratio`)";
  static constexpr const char* weakness = nullptr;

  double c10, c01, kappa;  ///< [Pa]

  explicit MooneyRivlin(const MaterialParameters& parameters)
      : Hooke(parameters),
        c10(0.5 * mu * (1 - parameters.mooney_ratio)),
        c01(0.5 * mu * parameters.mooney_ratio),
        kappa(lambda + 2 * mu / 3) {}

  template <int D>
  double energy_density(const Matrix<D>& h, const Matrix<D>& f) const {
    // From C - I = H + H^T + H^T H and ln J, which do not lose the digits of a small strain.
    Matrix<D> strain = h + h.transpose() + h.transpose() * h;
    double log_j = std::log(f.determinant()), across = 0;
    if (plane_stress) {
      const double y = log_thickness_stretch(invariants_in_plane(f));
      across = std::expm1(2 * y);
      log_j += y;
    }
    const double trace = strain.trace() + across, squares = strain.squaredNorm() + across * across;
    const double second = 2 * trace + 0.5 * (trace * trace - squares);  // I2 - 3
    const auto isochoric = [](double above_three, double m) { return 3 * std::expm1(m) + above_three * std::exp(m); };
    const double volume_change = std::expm1(log_j);
    return c10 * isochoric(trace, -2.0 / 3 * log_j) + c01 * isochoric(second, -4.0 / 3 * log_j) +
           0.5 * kappa * volume_change * volume_change;
  }

  template <int D, class Number>
  [[gnu::always_inline]] inline void stress(const Number (&)[D][D], const Number (&f)[D][D], const Number (&inverse_transposed)[D][D],
                                            const Number& j_plane, Number (&p)[D][D]) const {
    using std::exp;
    using std::log;
    using tern::exp;
    using tern::log;
    Number c[D][D], i1 = {}, squares = {};
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) {
        c[a][b] = f[0][a] * f[0][b];
        for (int k = 1; k < D; ++k) c[a][b] += f[k][a] * f[k][b];
        squares += c[a][b] * c[a][b];
        if (a == b) i1 += c[a][a];
      }
    Number j = j_plane;
    if constexpr (D == 2) {
      Number thickness = j_plane / j_plane;
      if (plane_stress) thickness = thickness_stretches(i1, j_plane);
      const Number square = thickness * thickness;
      i1 += square;
      squares += square * square;
      j *= thickness;
    }
    const Number i2 = 0.5 * (i1 * i1 - squares), root = exp(-2.0 / 3 * log(j));
    const Number a10 = c10 * root, b01 = c01 * root * root;
    const Number of_f = 2 * (a10 + b01 * i1), of_fc = -2 * b01, of_inverse = kappa * (j - 1) * j - 2.0 / 3 * a10 * i1 - 4.0 / 3 * b01 * i2;
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) {
        Number fc = f[a][0] * c[0][b];
        for (int k = 1; k < D; ++k) fc += f[a][k] * c[k][b];
        p[a][b] = of_f * f[a][b] + of_fc * fc + of_inverse * inverse_transposed[a][b];
      }
  }

  /// In space, direction by direction; in plane stress without F33, which answers so that P33 stays 0.
  template <int D>
  Tangent4<D> tangent(const Matrix<D>& f) const {
    Matrix<3> full = Matrix<3>::Identity();
    full.topLeftCorner<D, D>() = f;
    if (D == 2 && plane_stress) full(2, 2) = std::exp(log_thickness_stretch(invariants_in_plane(f)));
    const Differential of(*this, full);
    const auto unit = [](int i, int J) {
      Matrix<3> direction = Matrix<3>::Zero();
      direction(i, J) = 1;
      return direction;
    };
    Tangent4<D> result;
    for (int k = 0; k < D; ++k)
      for (int L = 0; L < D; ++L) {
        const Matrix<3> change = of.stress(unit(k, L));
        for (int i = 0; i < D; ++i)
          for (int J = 0; J < D; ++J) result(i * D + J, k * D + L) = change(i, J);
      }
    if (D == 2 && plane_stress) {
      const Matrix<3> change = of.stress(unit(2, 2));
      for (int n = 0; n < D * D; ++n)
        for (int m = 0; m < D * D; ++m) result(n, m) -= change(n / D, n % D) * change(m / D, m % D) / change(2, 2);
    }
    return result;
  }

  /// Of F = diag(s, 1, 1), but for the part of the volume, kappa (J/s)^2 along s. Its bound is that of the stiffest direction:
  /// along a compression that keeps the volume, across an extension that does not.
  double modulus_at(double stretch) const {
    const double third = std::cbrt(stretch), s2 = stretch * stretch, volumetric = plane_lambda + 2 * mu / 3;
    const double first = (4.0 / 9 + 20.0 / 9 / s2) / (third * third);
    const double second = (28.0 / 9 / s2 - 4.0 / 9) / (third * stretch);
    return c10 * first + c01 * second + volumetric * std::max(s2, 1 / s2);
  }

  template <int D>
  OutOfPlane out_of_plane(const Matrix<D>& h, double j2) const {
    Matrix<3> f = Matrix<3>::Identity();
    f.topLeftCorner<D, D>() += h;
    if (plane_stress) return {std::exp(log_thickness_stretch({(f.transpose() * f).trace() - 1, j2})), 0};
    return {1, Differential(*this, f).p(2, 2) / j2};
  }

  /// tr C and det F of the plane part.
  struct InPlane {
    double trace, j;
  };
  template <int D>
  static InPlane invariants_in_plane(const Matrix<D>& f) {
    return {f.squaredNorm(), f.determinant()};
  }

  /// ln F33 of P33 = 0 in plane stress: F33 P33 changes its sign once. Newton's method in ln F33, kept between the ends of an
  /// interval with the change of sign.
  double log_thickness_stretch(const InPlane& plane) const {
    double value, slope;
    const auto evaluate = [&](double y) {
      const double square = std::exp(2 * y), j = plane.j * std::exp(y), root = std::exp(-2.0 / 3 * std::log(j));
      const double i1 = plane.trace + square, i2 = plane.j * plane.j + plane.trace * square, a = c10 * root, b = c01 * root * root;
      const double d1 = 2 * square, d2 = 2 * plane.trace * square;  // of I1 and I2 in y
      value = a * (d1 - 2.0 / 3 * i1) + b * (d2 - 4.0 / 3 * i2) + kappa * (j - 1) * j;
      slope = a * (2 * d1 - 4.0 / 3 * d1 + 4.0 / 9 * i1) + b * (2 * d2 - 8.0 / 3 * d2 + 16.0 / 9 * i2) + kappa * (2 * j - 1) * j;
    };
    double y = -lambda * std::log(plane.j) / (lambda + 2 * mu), low = y - 1, high = y + 1;
    for (evaluate(low); value > 0 && low > -300; evaluate(low)) low -= 1;
    for (evaluate(high); value < 0 && high < 300; evaluate(high)) high += 1;
    for (int n = 0; n < 100; ++n) {
      evaluate(y);
      (value > 0 ? high : low) = y;
      double next = y - value / slope;
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      const double step = next - y;
      y = next;
      if (!(std::abs(step) > 1e-15 * (1 + std::abs(y)))) break;
    }
    return y;
  }

 private:
  Lanes thickness_stretches(const Lanes& trace, const Lanes& j) const {
    Lanes result;
    for (int lane = 0; lane < lane_count; ++lane) result[lane] = std::exp(log_thickness_stretch({trace[lane], j[lane]}));
    return result;
  }
  double thickness_stretches(double trace, double j) const { return std::exp(log_thickness_stretch({trace, j})); }

  /// P in space and its change with F.
  struct Differential {
    double j, i1, i2, a, b, kappa;
    Matrix<3> f, g, c, p1, p2, d2, p;  // g = F^-T; d2 = dI2/dF; p1, p2: dPsi/dF of the terms of C10 and C01

    Differential(const MooneyRivlin& law, const Matrix<3>& at)
        : j(at.determinant()), kappa(law.kappa), f(at), g(at.inverse().transpose()), c(at.transpose() * at) {
      i1 = c.trace();
      i2 = 0.5 * (i1 * i1 - c.squaredNorm());
      const double root = std::exp(-2.0 / 3 * std::log(j));
      a = law.c10 * root;
      b = law.c01 * root * root;
      d2 = 2 * (i1 * f - f * c);
      p1 = a * (2 * f - 2.0 / 3 * i1 * g);
      p2 = b * (d2 - 4.0 / 3 * i2 * g);
      p = p1 + p2 + kappa * (j - 1) * j * g;
    }

    /// dP for dF.
    Matrix<3> stress(const Matrix<3>& df) const {
      const double log_j = g.cwiseProduct(df).sum(), di1 = 2 * f.cwiseProduct(df).sum(), di2 = d2.cwiseProduct(df).sum();
      const Matrix<3> dg = -g * df.transpose() * g;
      const Matrix<3> dd2 = 2 * (di1 * f + i1 * df - df * c - f * (df.transpose() * f + f.transpose() * df));
      return -2.0 / 3 * log_j * p1 + a * (2 * df - 2.0 / 3 * (di1 * g + i1 * dg)) - 4.0 / 3 * log_j * p2 +
             b * (dd2 - 4.0 / 3 * (di2 * g + i2 * dg)) + kappa * ((2 * j - 1) * j * log_j * g + (j - 1) * j * dg);
    }
  };
};

}  // namespace tern::structure
