#include "structure/shell/shell_force.hpp"

#include <complex>

#include "base/lanes.hpp"

namespace tern::structure {
namespace {

using Complex = std::complex<double>;

/// Psi [J/m^3] of a stretched line, and dPsi/dC [Pa] with C the squared stretch.
std::pair<double, double> line_energy(const ShellLayer<2>& layer, double c, double reference) {
  if (const auto* law = std::get_if<NeoHookean>(&layer.material.law)) {
    const double free = law->plane_stress ? 2 : 1, stretch = c / reference, log_l = 0.5 * std::log(stretch);
    const double y = law->log_thickness_stretch(log_l, free), log_j = log_l + free * y;
    const double psi = 0.5 * law->mu * (stretch - 1 + free * std::expm1(2 * y)) - law->mu * log_j + 0.5 * law->lambda * log_j * log_j;
    return {psi, 0.5 * (law->mu / reference + (law->lambda * log_j - law->mu) / c)};
  }
  const double e = 0.5 * (c - reference);
  return {0.5 * layer.modulus() * e * e, 0.5 * layer.modulus() * e};
}

/// E' [(1 - nu) A + nu tr A I].
Eigen::Matrix2d hooke(const ShellLayer<3>& layer, const Eigen::Matrix2d& a) {
  const double nu = layer.poisson_ratio();
  return layer.modulus() * ((1 - nu) * a + nu * a.trace() * Eigen::Matrix2d::Identity());
}

/// Psi [J/m^3] of a stretched surface of metric c, and 2 dPsi/dC [Pa].
std::pair<double, Eigen::Matrix2d> surface_energy(const ShellLayer<3>& layer, const Eigen::Matrix2d& c, const Eigen::Matrix2d& reference) {
  if (const auto* law = std::get_if<NeoHookean>(&layer.material.law)) {
    const Eigen::Matrix2d inverse = reference.inverse();
    const double log_j2 = 0.5 * std::log(c.determinant() / reference.determinant());
    const double y = law->log_thickness_stretch(log_j2), log_j = log_j2 + y;
    const double trace = (inverse * (c - reference)).trace() + std::expm1(2 * y);  // tr C - 3
    const double psi = 0.5 * law->mu * trace - law->mu * log_j + 0.5 * law->lambda * log_j * log_j;
    return {psi, law->mu * inverse + (law->lambda * log_j - law->mu) * c.inverse()};
  }
  const Eigen::Matrix2d e = 0.5 * (c - reference), s = hooke(layer, e);
  return {0.5 * s.cwiseProduct(e).sum(), s};
}

double line_density(const ShellLayer<2>& layer, std::size_t i, const ShellDerivatives<2>& d, std::span<const Matrix<2>> turn,
                    ShellDerivatives<2>& conjugate) {
  const double t = layer.thickness, modulus = layer.modulus();
  const ShellDerivatives<2>& r = layer.reference[i];
  const auto [psi, slope] = line_energy(layer, d.col(0).squaredNorm(), r.col(0).squaredNorm());
  double w = t * psi;
  conjugate.col(0) = 2 * t * slope * d.col(0);
  const auto clamp = layer.particles.clamp[i];
  if (clamp >= 0) {
    const Vector<2> reference_normal = layer.particles.frame[i].col(1), normal = turn[clamp] * reference_normal;
    const double rho = normal.dot(d.col(1)) - reference_normal.dot(r.col(1)), moment = modulus * t * t * t / 12 * rho;
    conjugate.col(1) = moment * normal;
    return w + 0.5 * moment * rho;
  }
  const Complex a(d(0, 0), d(1, 0)), b(d(0, 1), d(1, 1)), a0(r(0, 0), r(1, 0)), b0(r(0, 1), r(1, 1));
  const Complex z = b / a - b0 / a0, s = modulus * t * Complex(layer.cell_squared[0] * z.real(), t * t / 12 * z.imag());
  // dW = Re(conj(s) dz),  dz = db/a - b da/a^2
  const Complex q = s * std::conj(1.0 / a), p = -s * std::conj(b / (a * a));
  conjugate.col(0) += Vector<2>(p.real(), p.imag());
  conjugate.col(1) = Vector<2>(q.real(), q.imag());
  return w + 0.5 * (s.real() * z.real() + s.imag() * z.imag());
}

double surface_density(const ShellLayer<3>& layer, std::size_t i, const ShellDerivatives<3>& d, std::span<const Matrix<3>> turn,
                       ShellDerivatives<3>& conjugate) {
  using Slopes = Eigen::Matrix<double, 3, 2>;
  const double t = layer.thickness;
  const ShellDerivatives<3>& r = layer.reference[i];
  const Slopes x = d.leftCols<2>(), reference = r.leftCols<2>();
  const auto [psi, stress] = surface_energy(layer, x.transpose() * x, reference.transpose() * reference);
  double w = t * psi;
  conjugate.leftCols<2>() = t * x * stress;
  conjugate.rightCols<3>().setZero();

  const auto clamp = layer.particles.clamp[i];
  const Vector<3> c = x.col(0).cross(x.col(1)), reference_c = reference.col(0).cross(reference.col(1));
  const double l = c.norm();
  const Vector<3> normal = clamp >= 0 ? Vector<3>(turn[clamp] * layer.particles.frame[i].col(2)) : Vector<3>(c / l);
  const Vector<3> reference_normal = clamp >= 0 ? Vector<3>(layer.particles.frame[i].col(2)) : Vector<3>(reference_c.normalized());
  Eigen::Matrix2d bend, rho;  // n.x_,ab, and its change
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b) {
      const int ab = second_derivative<3>(a, b);
      bend(a, b) = normal.dot(d.col(ab));
      rho(a, b) = bend(a, b) - reference_normal.dot(r.col(ab));
    }
  const Eigen::Matrix2d moment = t * t * t / 12 * hooke(layer, rho);
  w += 0.5 * moment.cwiseProduct(rho).sum();
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b) {
      const int ab = second_derivative<3>(a, b);
      conjugate.col(ab) += moment(a, b) * normal;
      if (clamp >= 0) continue;
      const Vector<3> p = (d.col(ab) - bend(a, b) * normal) / l;  // d rho = n.dx_,ab + p.dc
      conjugate.col(0) += moment(a, b) * x.col(1).cross(p);
      conjugate.col(1) += moment(a, b) * p.cross(x.col(0));
    }
  if (clamp >= 0) return w;

  for (int e = 0; e < 2; ++e) {
    Eigen::Matrix2d g;
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) {
        const int ae = second_derivative<3>(a, e), be = second_derivative<3>(b, e);
        g(a, b) =
            0.5 * (d.col(ae).dot(x.col(b)) + d.col(be).dot(x.col(a)) - r.col(ae).dot(reference.col(b)) - r.col(be).dot(reference.col(a)));
      }
    const Eigen::Matrix2d s = t * layer.cell_squared[e] * hooke(layer, g);
    w += 0.5 * s.cwiseProduct(g).sum();
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) {
        conjugate.col(second_derivative<3>(a, e)) += s(a, b) * x.col(b);
        conjugate.col(b) += s(a, b) * d.col(second_derivative<3>(a, e));
      }
  }
  return w;
}

}  // namespace

template <int D>
void shell_derivatives_of(const ShellLayer<D>& layer, std::span<const Vector<D>> x, std::span<const Matrix<D>> turn,
                          std::span<ShellDerivatives<D>> derivatives) {
  constexpr int second = shell_derivatives<D> - shell_slopes<D>;
  for_each_block(static_cast<std::ptrdiff_t>(layer.size()), [&](std::ptrdiff_t i) {
    ShellDerivatives<D> sum = ShellDerivatives<D>::Zero();
    for (auto n = layer.first[i]; n < layer.first[i + 1]; ++n) sum += (x[layer.neighbour[n]] - x[i]) * layer.weight[n].transpose();
    const auto clamp = layer.particles.clamp[i];
    for (int a = 0; a < D - 1 && clamp >= 0; ++a)
      sum.template rightCols<second>() -= turn[clamp] * layer.particles.frame[i].col(a) * layer.clamp_slope[i].col(a).transpose();
    derivatives[i] = sum;
  });
}

template <int D>
double shell_energy_density(const ShellLayer<D>& layer, std::size_t i, const ShellDerivatives<D>& derivatives,
                            std::span<const Matrix<D>> turn, ShellDerivatives<D>& conjugate) {
  if constexpr (D == 2)
    return line_density(layer, i, derivatives, turn, conjugate);
  else
    return surface_density(layer, i, derivatives, turn, conjugate);
}

template <int D>
Vector<D> shell_force(const ShellLayer<D>& layer, std::size_t i, std::span<const ShellDerivatives<D>> conjugate) {
  Vector<D> force = Vector<D>::Zero();
  for (auto n = layer.first[i]; n < layer.first[i + 1]; ++n) {
    const auto j = layer.neighbour[n];
    force += layer.particles.area[i] * (conjugate[i] * layer.weight[n]);
    force -= layer.particles.area[j] * (conjugate[j] * layer.weight[layer.mirror[n]]);
  }
  return force;
}

template <int D>
double shell_forces(const ShellLayer<D>& layer, std::span<const Vector<D>> x, std::span<const Matrix<D>> turn,
                    std::span<ShellDerivatives<D>> derivatives, std::span<ShellDerivatives<D>> conjugate, std::span<Vector<D>> force) {
  shell_derivatives_of(layer, x, turn, derivatives);
  double energy = 0;
  for (std::size_t i = 0; i < layer.size(); ++i)
    energy += layer.particles.area[i] * shell_energy_density(layer, i, derivatives[i], turn, conjugate[i]);
  for_each_block(static_cast<std::ptrdiff_t>(layer.size()),
                 [&](std::ptrdiff_t i) { force[i] = shell_force<D>(layer, static_cast<std::size_t>(i), conjugate); });
  return energy;
}

#define TERN_INSTANTIATE(D)                                                                                                          \
  template void shell_derivatives_of<D>(const ShellLayer<D>&, std::span<const Vector<D>>, std::span<const Matrix<D>>,                \
                                        std::span<ShellDerivatives<D>>);                                                             \
  template double shell_energy_density<D>(const ShellLayer<D>&, std::size_t, const ShellDerivatives<D>&, std::span<const Matrix<D>>, \
                                          ShellDerivatives<D>&);                                                                     \
  template Vector<D> shell_force<D>(const ShellLayer<D>&, std::size_t, std::span<const ShellDerivatives<D>>);                        \
  template double shell_forces<D>(const ShellLayer<D>&, std::span<const Vector<D>>, std::span<const Matrix<D>>,                      \
                                  std::span<ShellDerivatives<D>>, std::span<ShellDerivatives<D>>, std::span<Vector<D>>);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::structure
