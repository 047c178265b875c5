#include "structure/shell/shell_force.hpp"

#include <complex>

#include "base/lanes.hpp"
#include "structure/shell/components.hpp"

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

/// E' [(1 - nu) A + nu tr A I], by Lame's parameters.
inline Eigen::Matrix2d hooke(const ShellLayer<3>& layer, const Eigen::Matrix2d& a) {
  const double lambda = layer.material.lambda, mu = layer.material.mu;
  return 2 * mu * a + 2 * lambda * mu / (lambda + 2 * mu) * a.trace() * Eigen::Matrix2d::Identity();
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

/// z = b/a, and what belongs to a stress s of it: Re(conj(s) dz), dz = (db - z da)/a.
struct Bend {
  Complex a, z;

  explicit Bend(const ShellDerivatives<2>& d) : a(d(0, 0), d(1, 0)), z(Complex(d(0, 1), d(1, 1)) / a) {}
  Complex change(const ShellDerivatives<2>& by) const { return (Complex(by(0, 1), by(1, 1)) - z * Complex(by(0, 0), by(1, 0))) / a; }
  void add_conjugate(const Complex& s, ShellDerivatives<2>& conjugate) const {
    const Complex q = s * std::conj(1.0 / a), p = -s * std::conj(z / a);
    conjugate.col(0) += Vector<2>(p.real(), p.imag());
    conjugate.col(1) += Vector<2>(q.real(), q.imag());
  }
};

/// E' t [c Re z + i t^2/12 Im z].
Complex cell_stress(const ShellLayer<2>& layer, const Complex& z) {
  const double t = layer.thickness;
  return layer.modulus() * t * Complex(layer.cell_squared[0] * z.real(), t * t / 12 * z.imag());
}

double bending_stiffness(const ShellLayer<2>& layer) { return layer.modulus() * std::pow(layer.thickness, 3) / 12; }

double density(const ShellLayer<2>& layer, std::size_t i, const ShellDerivatives<2>& d, std::span<const Matrix<2>> turn,
               ShellDerivatives<2>& conjugate) {
  const double t = layer.thickness;
  const ShellDerivatives<2>& r = layer.reference[i];
  const auto [psi, slope] = line_energy(layer, d.col(0).squaredNorm(), r.col(0).squaredNorm());
  const double w = t * psi;
  conjugate.col(0) = 2 * t * slope * d.col(0);
  const auto clamp = layer.particles.clamp[i];
  if (clamp >= 0) {
    const Vector<2> reference_normal = layer.particles.frame[i].col(1), normal = turn[clamp] * reference_normal;
    const double rho = normal.dot(d.col(1)) - reference_normal.dot(r.col(1)), moment = bending_stiffness(layer) * rho;
    conjugate.col(1) = moment * normal;
    return w + 0.5 * moment * rho;
  }
  conjugate.col(1).setZero();
  const Bend bend(d);
  const Complex z = bend.z - Bend(r).z, s = cell_stress(layer, z);
  bend.add_conjugate(s, conjugate);
  return w + 0.5 * (s.real() * z.real() + s.imag() * z.imag());
}

void viscous_stress(const ShellLayer<2>& layer, std::size_t i, const ShellDerivatives<2>& d, const ShellDerivatives<2>& rate,
                    std::span<const Matrix<2>> turn, std::span<const Matrix<2>> turn_rate, double time, ShellDerivatives<2>& conjugate) {
  conjugate.col(0) = time * layer.thickness * layer.modulus() * d.col(0).dot(rate.col(0)) * d.col(0);
  const auto clamp = layer.particles.clamp[i];
  if (clamp >= 0) {
    const Vector<2> normal = turn[clamp] * layer.particles.frame[i].col(1),
                    normal_rate = turn_rate[clamp] * layer.particles.frame[i].col(1);
    conjugate.col(1) = time * bending_stiffness(layer) * (normal.dot(rate.col(1)) + normal_rate.dot(d.col(1))) * normal;
    return;
  }
  conjugate.col(1).setZero();
  const Bend bend(d);
  bend.add_conjugate(time * cell_stress(layer, bend.change(rate)), conjugate);
}

/// A surface at one particle: slopes x_,a, normal, |x_,1 x x_,2| and n.x_,ab.
struct Tangents {
  using Slopes = Eigen::Matrix<double, 3, 2>;
  Slopes x;
  Vector<3> normal;
  double area;
  Eigen::Matrix2d bend;
  bool is_clamped;

  Tangents(const ShellLayer<3>& layer, std::size_t i, const ShellDerivatives<3>& d, const Matrix<3>* turn)
      : x(d.leftCols<2>()), is_clamped(turn != nullptr) {
    const Vector<3> c = x.col(0).cross(x.col(1));
    area = c.norm();
    normal = is_clamped ? Vector<3>(*turn * layer.particles.frame[i].col(2)) : Vector<3>(c / area);
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) bend(a, b) = normal.dot(d.col(second_derivative<3>(a, b)));
  }

  /// x_,ae.x_,b + x_,be.x_,a, with the slopes of `first` and the second derivatives of `second`, halved.
  static Eigen::Matrix2d gradient(const ShellDerivatives<3>& first, const ShellDerivatives<3>& second, int e) {
    Eigen::Matrix2d g;
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b)
        g(a, b) =
            0.5 * (second.col(second_derivative<3>(a, e)).dot(first.col(b)) + second.col(second_derivative<3>(b, e)).dot(first.col(a)));
    return g;
  }

  /// What is conjugate to the derivatives, by d rho_ab = n.dx_,ab + p_ab.dc, p_ab = (x_,ab - rho_ab n)/|c|, c = x_,1 x x_,2,
  /// where the stresses of E, rho and G_..1, G_..2 are these.
  void conjugate_of(const ShellDerivatives<3>& d, const Eigen::Matrix2d& stress, const Eigen::Matrix2d& moment,
                    const std::array<Eigen::Matrix2d, 2>& cell, ShellDerivatives<3>& conjugate) const {
    conjugate.leftCols<2>() = x * stress;
    conjugate.col(2) = moment(0, 0) * normal;
    conjugate.col(3) = (moment(0, 1) + moment(1, 0)) * normal;
    conjugate.col(4) = moment(1, 1) * normal;
    if (is_clamped) return;
    const Vector<3> curved = moment(0, 0) * d.col(2) + (moment(0, 1) + moment(1, 0)) * d.col(3) + moment(1, 1) * d.col(4);
    const Vector<3> p = (curved - moment.cwiseProduct(bend).sum() * normal) / area;  // sum of M_ab p_ab
    conjugate.col(0) += Vector<3>(x.col(1)).cross(p);
    conjugate.col(1) += p.cross(Vector<3>(x.col(0)));
    for (int e = 0; e < 2; ++e)
      for (int a = 0; a < 2; ++a) {
        const int ae = second_derivative<3>(a, e);
        conjugate.col(ae) += cell[e](a, 0) * x.col(0) + cell[e](a, 1) * x.col(1);
        for (int b = 0; b < 2; ++b) conjugate.col(b) += cell[e](a, b) * d.col(ae);
      }
  }
};

double density(const ShellLayer<3>& layer, std::size_t i, const ShellDerivatives<3>& d, std::span<const Matrix<3>> turn,
               ShellDerivatives<3>& conjugate) {
  const double t = layer.thickness;
  const auto clamp = layer.particles.clamp[i];
  const ShellRest& rest = layer.rest[i];
  const Tangents now(layer, i, d, clamp >= 0 ? &turn[clamp] : nullptr);
  const auto [psi, stress] = surface_energy(layer, now.x.transpose() * now.x, rest.metric);
  const Eigen::Matrix2d rho = now.bend - rest.bend, moment = t * t * t / 12 * hooke(layer, rho);
  double w = t * psi + 0.5 * moment.cwiseProduct(rho).sum();
  std::array<Eigen::Matrix2d, 2> cell;
  for (int e = 0; e < 2 && clamp < 0; ++e) {
    const Eigen::Matrix2d g = Tangents::gradient(d, d, e) - rest.gradient[e];
    cell[e] = t * layer.cell_squared[e] * hooke(layer, g);
    w += 0.5 * cell[e].cwiseProduct(g).sum();
  }
  now.conjugate_of(d, t * stress, moment, cell, conjugate);
  return w;
}

void viscous_stress(const ShellLayer<3>& layer, std::size_t i, const ShellDerivatives<3>& d, const ShellDerivatives<3>& rate,
                    std::span<const Matrix<3>> turn, std::span<const Matrix<3>> turn_rate, double time, ShellDerivatives<3>& conjugate) {
  const double t = layer.thickness;
  const auto clamp = layer.particles.clamp[i];
  const Tangents now(layer, i, d, clamp >= 0 ? &turn[clamp] : nullptr);
  const Tangents::Slopes x_rate = rate.leftCols<2>();
  const Eigen::Matrix2d product = now.x.transpose() * x_rate, strain_rate = 0.5 * (product + product.transpose());
  const Vector<3> c_rate = x_rate.col(0).cross(now.x.col(1)) + now.x.col(0).cross(x_rate.col(1));
  Eigen::Matrix2d bend_rate;
  // dn/dt.x_,ab, of the normal that turns with the surface (c_rate), or with its clamp.
  const Vector<3> turning = clamp >= 0 ? Vector<3>(turn_rate[clamp] * layer.particles.frame[i].col(2))
                                       : Vector<3>((c_rate - now.normal.dot(c_rate) * now.normal) / now.area);
  for (int a = 0; a < 2; ++a)
    for (int b = a; b < 2; ++b) {
      const int ab = second_derivative<3>(a, b);
      bend_rate(a, b) = bend_rate(b, a) = now.normal.dot(rate.col(ab)) + turning.dot(d.col(ab));
    }
  std::array<Eigen::Matrix2d, 2> cell;
  for (int e = 0; e < 2 && clamp < 0; ++e)
    cell[e] = time * t * layer.cell_squared[e] * hooke(layer, Tangents::gradient(rate, d, e) + Tangents::gradient(d, rate, e));
  now.conjugate_of(d, time * t * hooke(layer, strain_rate), time * t * t * t / 12 * hooke(layer, bend_rate), cell, conjugate);
}

}  // namespace

ShellRest shell_rest(const ShellLayer<3>& layer, std::size_t i) {
  const Matrix<3> still = Matrix<3>::Identity();
  const ShellDerivatives<3>& r = layer.reference[i];
  const Tangents before(layer, i, r, layer.particles.clamp[i] >= 0 ? &still : nullptr);
  return {before.x.transpose() * before.x, before.bend, {Tangents::gradient(r, r, 0), Tangents::gradient(r, r, 1)}};
}

template <int D>
void shell_derivatives_of(const ShellLayer<D>& layer, std::span<const Vector<D>> x, std::span<const Matrix<D>> turn,
                          std::span<ShellDerivatives<D>> derivatives) {
  constexpr int second = shell_unknowns<D> - shell_slopes<D>;
  for_each_block(static_cast<std::ptrdiff_t>(layer.size()), [&](std::ptrdiff_t i) {
    const Lanes own = components<D>(x[i].data());
    Lanes columns[shell_unknowns<D>] = {};
    const auto* weight = layer.weight.data();
    for (auto n = layer.first[i]; n < layer.first[i + 1]; ++n) {
      const Lanes from = components<D>(x[layer.neighbour[n]].data()) - own;
      for (int c = 0; c < shell_unknowns<D>; ++c) columns[c] += from * weight[n][c];
    }
    ShellDerivatives<D> sum;
    for (int c = 0; c < shell_unknowns<D>; ++c) sum.col(c) = vector_of<D>(columns[c]);
    const auto clamp = layer.particles.clamp[i];
    for (int a = 0; a < D - 1 && clamp >= 0; ++a)
      sum.template rightCols<second>() -= turn[clamp] * layer.particles.frame[i].col(a) * layer.clamp_slope[i].col(a).transpose();
    derivatives[i] = sum;
  });
}

template <int D>
double shell_energy_density(const ShellLayer<D>& layer, std::size_t i, const ShellDerivatives<D>& derivatives,
                            std::span<const Matrix<D>> turn, ShellDerivatives<D>& conjugate) {
  return density(layer, i, derivatives, turn, conjugate);
}

template <int D>
void shell_viscous_stress(const ShellLayer<D>& layer, std::size_t i, const ShellDerivatives<D>& derivatives,
                          const ShellDerivatives<D>& rate, std::span<const Matrix<D>> turn, std::span<const Matrix<D>> turn_rate,
                          double viscous_time, ShellDerivatives<D>& conjugate) {
  viscous_stress(layer, i, derivatives, rate, turn, turn_rate, viscous_time, conjugate);
}

// Of x_,ab = ... - R e_c (sum k^ab xi_c), and of n = R N in rho_ab = n.x_,ab, whose stress is n times the conjugate.
template <int D>
double shell_turning_power(const ShellLayer<D>& layer, std::size_t i, const ShellDerivatives<D>& derivatives,
                           const ShellDerivatives<D>& conjugate, std::span<const Matrix<D>> turn, std::span<const Matrix<D>> turn_rate) {
  const auto clamp = layer.particles.clamp[i];
  if (clamp < 0) return 0;
  const Matrix<D>& frame = layer.particles.frame[i];
  const Vector<D> normal = turn[clamp] * frame.col(D - 1), normal_rate = turn_rate[clamp] * frame.col(D - 1);
  double power = 0;
  for (int ab = 0; ab < shell_unknowns<D> - shell_slopes<D>; ++ab) {
    const Vector<D> q = conjugate.col(shell_slopes<D> + ab);
    power += q.dot(normal) * normal_rate.dot(derivatives.col(shell_slopes<D> + ab));
    for (int c = 0; c < D - 1; ++c) power -= layer.clamp_slope[i](ab, c) * q.dot(turn_rate[clamp] * frame.col(c));
  }
  return power;
}

// f_i = sum_j (A_i dW_i w_ij - A_j dW_j w_ji). Columns that follow each other have sums of their own: one would wait for itself.
template <int D, std::size_t N>
std::array<Vector<D>, N> shell_force(const ShellLayer<D>& layer, std::size_t i,
                                     const std::array<std::span<const ShellDerivatives<D>>, N>& conjugate) {
  Lanes sums[N][2] = {};
  const auto add = [&](std::size_t j, const typename ShellLayer<D>::Weights& weight) {
    for (int c = 0; c < shell_unknowns<D>; ++c)
      for (std::size_t m = 0; m < N; ++m) sums[m][c % 2] += components<D>(conjugate[m][j].data() + D * c) * weight[c];
  };
  add(i, layer.weight_sum[i]);
  for (auto n = layer.first[i]; n < layer.first[i + 1]; ++n) add(layer.neighbour[n], layer.mirror_weight[n]);
  std::array<Vector<D>, N> force;
  for (std::size_t m = 0; m < N; ++m) force[m] = vector_of<D>(sums[m][0] + sums[m][1]);
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
                 [&](std::ptrdiff_t i) { force[i] = shell_force<D, 1>(layer, static_cast<std::size_t>(i), {conjugate})[0]; });
  return energy;
}

#define TERN_INSTANTIATE(D)                                                                                                          \
  template void shell_derivatives_of<D>(const ShellLayer<D>&, std::span<const Vector<D>>, std::span<const Matrix<D>>,                \
                                        std::span<ShellDerivatives<D>>);                                                             \
  template double shell_energy_density<D>(const ShellLayer<D>&, std::size_t, const ShellDerivatives<D>&, std::span<const Matrix<D>>, \
                                          ShellDerivatives<D>&);                                                                     \
  template void shell_viscous_stress<D>(const ShellLayer<D>&, std::size_t, const ShellDerivatives<D>&, const ShellDerivatives<D>&,   \
                                        std::span<const Matrix<D>>, std::span<const Matrix<D>>, double, ShellDerivatives<D>&);       \
  template double shell_turning_power<D>(const ShellLayer<D>&, std::size_t, const ShellDerivatives<D>&, const ShellDerivatives<D>&,  \
                                         std::span<const Matrix<D>>, std::span<const Matrix<D>>);                                    \
  template std::array<Vector<D>, 1> shell_force<D, 1>(const ShellLayer<D>&, std::size_t,                                             \
                                                      const std::array<std::span<const ShellDerivatives<D>>, 1>&);                   \
  template std::array<Vector<D>, 2> shell_force<D, 2>(const ShellLayer<D>&, std::size_t,                                             \
                                                      const std::array<std::span<const ShellDerivatives<D>>, 2>&);                   \
  template double shell_forces<D>(const ShellLayer<D>&, std::span<const Vector<D>>, std::span<const Matrix<D>>,                      \
                                  std::span<ShellDerivatives<D>>, std::span<ShellDerivatives<D>>, std::span<Vector<D>>);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::structure
