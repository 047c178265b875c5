// With the strains of shell_force.hpp, W = sum of C(e, e)/2 over the strains e:  d2W = de:C:de + C e:d2e.
//   d2E_ab = dx_,a.dx_,b,   d2G_abc = 2 sym_ab(dx_,ac.dx_,b),
//   d2rho = 2 dn.dk + 2 p.(dx_,1 x dx_,2) - (2/l)(n.dc)(p.dc) - (rho/l^2)(|dc|^2 - (n.dc)^2),
// c = x_,1 x x_,2, l = |c|, n = c/l, k = x_,ab, p = (k - (n.k) n)/l, dn = (dc - n n.dc)/l, and n.k in place of rho.
//   2D: d2z = 2 b/a^3 da da - 2/a^2 da db.

#include "structure/shell/shell_hessian.hpp"

#include <complex>

namespace tern::structure {
namespace {

using Complex = std::complex<double>;

/// The matrix of the real part of w u v, u and v complex numbers as vectors.
Eigen::Matrix2d real_of_product(const Complex& w) {
  Eigen::Matrix2d m;
  m << w.real(), -w.imag(), -w.imag(), -w.real();
  return m;
}

/// The product with w as a matrix.
Eigen::Matrix2d times(const Complex& w) {
  Eigen::Matrix2d m;
  m << w.real(), -w.imag(), w.imag(), w.real();
  return m;
}

/// How ln J answers the ln J of the layer, whose thickness (and width, `free` directions) are free of stress.
double answer_of_thickness(const NeoHookean& law, double log_stretch, double free) {
  const double stiffness = 2 * law.mu * std::exp(2 * log_stretch);
  return stiffness / (stiffness + free * law.lambda);
}

/// dPsi/dC and d2Psi/dC2 of a stretched line, C the squared stretch [Pa].
std::pair<double, double> line_stiffness(const ShellLayer<2>& layer, double c, double reference) {
  if (const auto* law = std::get_if<NeoHookean>(&layer.material.law)) {
    const double free = law->plane_stress ? 2 : 1, log_l = 0.5 * std::log(c / reference);
    const double y = law->log_thickness_stretch(log_l, free), factor = law->lambda * (log_l + free * y) - law->mu;
    const double rate = 0.5 / c * answer_of_thickness(*law, y, free);  // d ln J/dC
    return {0.5 * (law->mu / reference + factor / c), 0.5 * (law->lambda * rate / c - factor / (c * c))};
  }
  return {0.25 * layer.modulus() * (c - reference), 0.25 * layer.modulus()};
}

ShellHessian<2> hessian(const ShellLayer<2>& layer, std::size_t i, const ShellDerivatives<2>& d, std::span<const Matrix<2>> turn) {
  const double t = layer.thickness, bending = layer.modulus() * t * t * t / 12;
  const ShellDerivatives<2>& r = layer.reference[i];
  const Vector<2> slope = d.col(0);
  ShellHessian<2> h = ShellHessian<2>::Zero();
  const auto [first, second] = line_stiffness(layer, slope.squaredNorm(), r.col(0).squaredNorm());
  h.topLeftCorner<2, 2>() = 2 * t * first * Eigen::Matrix2d::Identity() + 4 * t * second * slope * slope.transpose();
  if (const auto clamp = layer.particles.clamp[i]; clamp >= 0) {
    const Vector<2> normal = turn[clamp] * layer.particles.frame[i].col(1);
    h.bottomRightCorner<2, 2>() += bending * normal * normal.transpose();
    return h;
  }
  const Complex a(d(0, 0), d(1, 0)), b(d(0, 1), d(1, 1)), z = b / a - Complex(r(0, 1), r(1, 1)) / Complex(r(0, 0), r(1, 0));
  Eigen::Matrix<double, 2, 4> change;
  change << times(-b / (a * a)), times(1.0 / a);
  const Eigen::DiagonalMatrix<double, 2> stiffness(layer.modulus() * t * layer.cell_squared[0], bending);
  h += change.transpose() * stiffness * change;
  const Complex stress = std::conj(Complex(stiffness.diagonal()[0] * z.real(), stiffness.diagonal()[1] * z.imag()));
  h.topLeftCorner<2, 2>() += real_of_product(2.0 * stress * b / (a * a * a));
  const Eigen::Matrix2d mixed = real_of_product(-stress / (a * a));
  h.topRightCorner<2, 2>() += mixed;
  h.bottomLeftCorner<2, 2>() += mixed.transpose();
  return h;
}

using Row = Eigen::Matrix<double, 1, 15>;
using Three = Eigen::Matrix3d;

constexpr std::array<std::array<int, 2>, 3> pairs{{{0, 0}, {1, 1}, {0, 1}}};  // of a symmetric tensor, in the order of its entries below

/// Of strains as (e_11, e_22, e_12): C(e, e) = e^T M e.
Three hooke_matrix(const ShellLayer<3>& layer) {
  const double nu = layer.poisson_ratio();
  Three m;
  m << 1, nu, 0, nu, 1, 0, 0, 0, 2 * (1 - nu);
  return layer.modulus() * m;
}

/// S_11, S_22, 2 S_12 conjugate to (E_11, E_22, E_12), and their derivatives by these, of the energy in the plane [Pa].
std::pair<Vector<3>, Three> surface_stiffness(const ShellLayer<3>& layer, const Eigen::Matrix2d& c, const Eigen::Matrix2d& reference) {
  const auto entries = [](const Eigen::Matrix2d& m) { return Vector<3>(m(0, 0), m(1, 1), 2 * m(0, 1)); };
  if (const auto* law = std::get_if<NeoHookean>(&layer.material.law)) {
    const double log_j2 = 0.5 * std::log(c.determinant() / reference.determinant()), y = law->log_thickness_stretch(log_j2);
    const double factor = law->lambda * (log_j2 + y) - law->mu;
    const Eigen::Matrix2d inverse = c.inverse();
    Three stiffness;
    for (int n = 0; n < 3; ++n) {
      Eigen::Matrix2d by = Eigen::Matrix2d::Zero();  // dC of dE of this entry
      by(pairs[n][0], pairs[n][1]) = by(pairs[n][1], pairs[n][0]) = 2;
      const double rate = 0.5 * (inverse * by).trace() * answer_of_thickness(*law, y, 1);
      stiffness.col(n) = entries(law->lambda * rate * inverse - factor * inverse * by * inverse);
    }
    return {entries(law->mu * reference.inverse() + factor * inverse), stiffness};
  }
  const Eigen::Matrix2d e = 0.5 * (c - reference);
  const Three m = hooke_matrix(layer);
  return {m * Vector<3>(e(0, 0), e(1, 1), e(0, 1)), m};
}

Three cross_matrix(const Vector<3>& v) {
  Three m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

ShellHessian<3> hessian(const ShellLayer<3>& layer, std::size_t i, const ShellDerivatives<3>& d, std::span<const Matrix<3>> turn) {
  const double t = layer.thickness;
  const auto clamp = layer.particles.clamp[i];
  const ShellDerivatives<3>& r = layer.reference[i];
  ShellHessian<3> h = ShellHessian<3>::Zero();
  const auto block = [&](int s, int u) { return h.block<3, 3>(3 * s, 3 * u); };
  const auto add_both = [&](int s, int u, const Three& m) {
    block(s, u) += m;
    block(u, s) += m.transpose();
  };
  const Three unit = Three::Identity(), material = hooke_matrix(layer);
  const std::array<Vector<3>, 2> x{d.col(0), d.col(1)};
  const auto metric = [](const ShellDerivatives<3>& q) { return Eigen::Matrix2d(q.leftCols<2>().transpose() * q.leftCols<2>()); };

  // In the plane.
  Eigen::Matrix<double, 3, 15> change = Eigen::Matrix<double, 3, 15>::Zero();
  for (int n = 0; n < 3; ++n) {
    const auto [a, b] = pairs[n];
    change.block<1, 3>(n, 3 * a) += 0.5 * x[b].transpose();
    change.block<1, 3>(n, 3 * b) += 0.5 * x[a].transpose();
  }
  const auto [stress, stiffness] = surface_stiffness(layer, metric(d), metric(r));
  h += t * change.transpose() * stiffness * change;
  block(0, 0) += t * stress[0] * unit;
  block(1, 1) += t * stress[1] * unit;
  add_both(0, 1, 0.5 * t * stress[2] * unit);

  // Bending.
  const Vector<3> c = x[0].cross(x[1]);
  const double l = c.norm();
  const Vector<3> before = Vector<3>(r.col(0)).cross(Vector<3>(r.col(1))).normalized();
  const Vector<3> normal = clamp >= 0 ? Vector<3>(turn[clamp] * layer.particles.frame[i].col(2)) : Vector<3>(c / l);
  const Vector<3> reference_normal = clamp >= 0 ? Vector<3>(layer.particles.frame[i].col(2)) : before;
  Eigen::Matrix<double, 3, 15> turn_of = Eigen::Matrix<double, 3, 15>::Zero();  // dc
  turn_of.block<3, 3>(0, 0) = -cross_matrix(x[1]);
  turn_of.block<3, 3>(0, 3) = cross_matrix(x[0]);
  const Three across = unit - normal * normal.transpose();
  Eigen::Matrix<double, 3, 15> bend = Eigen::Matrix<double, 3, 15>::Zero();
  Vector<3> rho;
  std::array<Vector<3>, 3> p;
  std::array<double, 3> curvature{};
  for (int n = 0; n < 3; ++n) {
    const int column = second_derivative<3>(pairs[n][0], pairs[n][1]);
    const Vector<3> k = d.col(column);
    curvature[n] = normal.dot(k);
    rho[n] = curvature[n] - reference_normal.dot(r.col(column));
    p[n] = (k - curvature[n] * normal) / l;
    bend.block<1, 3>(n, 3 * column) = normal.transpose();
    if (clamp < 0) bend.row(n) += p[n].transpose() * turn_of;
  }
  const Three rigidity = t * t * t / 12 * material;
  h += bend.transpose() * rigidity * bend;
  if (clamp >= 0) return h;
  const Vector<3> moment = rigidity * rho;
  for (int n = 0; n < 3; ++n) {
    const int column = second_derivative<3>(pairs[n][0], pairs[n][1]);
    const Eigen::Matrix<double, 3, 15> turned = moment[n] / l * across * turn_of;  // of dn
    h.middleRows<3>(3 * column) += turned;
    h.middleCols<3>(3 * column) += turned.transpose();
    add_both(0, 1, -moment[n] * cross_matrix(p[n]));
    const Three of_turn = (normal * p[n].transpose() + p[n] * normal.transpose()) / l + curvature[n] / (l * l) * across;
    h -= moment[n] * turn_of.transpose() * of_turn * turn_of;
  }

  // The cell.
  for (int e = 0; e < 2; ++e) {
    Eigen::Matrix<double, 3, 15> gradient = Eigen::Matrix<double, 3, 15>::Zero();
    Vector<3> g;
    for (int n = 0; n < 3; ++n) {
      const auto [a, b] = pairs[n];
      const int ae = second_derivative<3>(a, e), be = second_derivative<3>(b, e);
      g[n] = 0.5 * (d.col(ae).dot(d.col(b)) + d.col(be).dot(d.col(a))) - 0.5 * (r.col(ae).dot(r.col(b)) + r.col(be).dot(r.col(a)));
      gradient.block<1, 3>(n, 3 * ae) += 0.5 * d.col(b).transpose();
      gradient.block<1, 3>(n, 3 * b) += 0.5 * d.col(ae).transpose();
      gradient.block<1, 3>(n, 3 * be) += 0.5 * d.col(a).transpose();
      gradient.block<1, 3>(n, 3 * a) += 0.5 * d.col(be).transpose();
    }
    const Three cell = t * layer.cell_squared[e] * material;
    h += gradient.transpose() * cell * gradient;
    const Vector<3> s = cell * g;
    for (int n = 0; n < 3; ++n) {
      const auto [a, b] = pairs[n];
      add_both(second_derivative<3>(a, e), b, 0.5 * s[n] * unit);
      add_both(second_derivative<3>(b, e), a, 0.5 * s[n] * unit);
    }
  }
  return h;
}

}  // namespace

template <int D>
ShellHessian<D> shell_energy_hessian(const ShellLayer<D>& layer, std::size_t i, const ShellDerivatives<D>& derivatives,
                                     std::span<const Matrix<D>> turn) {
  return hessian(layer, i, derivatives, turn);
}

template ShellHessian<2> shell_energy_hessian<2>(const ShellLayer<2>&, std::size_t, const ShellDerivatives<2>&, std::span<const Matrix<2>>);
template ShellHessian<3> shell_energy_hessian<3>(const ShellLayer<3>&, std::size_t, const ShellDerivatives<3>&, std::span<const Matrix<3>>);

}  // namespace tern::structure
