// Tangent of the elastic force. With c = dx^2/12, G_a = dF/dX_a, Fi = F^-1, B_a = G_a Fi, D_a = sym(B_a), S_a = C:D_a (C Hooke's law),
//   d2W = dF:d2Psi:dF + c sum_a [ dD_a:C:dD_a - 2 S_a:(dB_a dF Fi) ],   dB_a = (dG_a - B_a dF) Fi,   dD_a = sym(dB_a),
// d2Psi is that of the material (structure/material/registry.hpp). Where the derivatives G, K of the fit are completed (unseen_fields.hpp),
// with F and K' linear in a_r = A_r k, k = G^-1 K, the chain rule adds
//   dW:d2(F, K') = 2 sum_r w_r . (dG da_r - G A_r (G^-1 dG dk)),   da_r = A_r dk,   dk = G^-1 (dK - dG k).

#include "structure/implicit/tangent.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <map>

#include "structure/cofactor.hpp"
#include "structure/shell/shell_hessian.hpp"
#include "structure/strain_gradient.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {

template <int D>
CellHessian<D> energy_hessian(const Body& body, const Workspace<D>& work, std::int32_t row) {
  constexpr int first = D * D, pairs = curvature_components<D>, size = first + D * pairs;
  const Material& m = body.material;
  const Matrix<D> f = deformation_gradient_of<D>(work, row), inverse = f.inverse();
  Eigen::Matrix<double, size, size> hessian = Eigen::Matrix<double, size, size>::Zero();

  hessian.template topLeftCorner<first, first>() = std::visit([&](const auto& law) { return law.template tangent<D>(f); }, m.law);

  const double c = body.spacing * body.spacing / 12;
  using Rows = Eigen::Matrix<double, D * D, size>;
  Eigen::Matrix<double, D * D, D * D> stiffness;
  for (int i = 0; i < D; ++i)
    for (int J = 0; J < D; ++J)
      for (int k = 0; k < D; ++k)
        for (int L = 0; L < D; ++L) stiffness(i * D + J, k * D + L) = m.stiffness(i, J, k, L);
  for (int direction = 0; direction < D; ++direction) {
    Matrix<D> g;
    for (int i = 0; i < D; ++i)
      for (int b = 0; b < D; ++b) g(i, b) = work.curvature[i][curvature_index<D>(direction, b)][row];
    const Matrix<D> b = g * inverse;
    // dB, its symmetric part, and dF F^-1 as rows over (dF, dG).
    Rows change = Rows::Zero(), strain, rate = Rows::Zero();
    for (int i = 0; i < D; ++i)
      for (int l = 0; l < D; ++l)
        for (int J = 0; J < D; ++J) {
          rate(i * D + l, i * D + J) = inverse(J, l);
          change(i * D + l, first + i * pairs + curvature_index<D>(direction, J)) += inverse(J, l);
          for (int k = 0; k < D; ++k) change(i * D + l, k * D + J) -= b(i, k) * inverse(J, l);
        }
    for (int i = 0; i < D; ++i)
      for (int l = 0; l < D; ++l) strain.row(i * D + l) = 0.5 * (change.row(i * D + l) + change.row(l * D + i));
    hessian += c * strain.transpose() * stiffness * strain;
    const Matrix<D> stress = m.strain_stress<D>(0.5 * (b + b.transpose()));
    // S:(dB dF Fi) = sum_ik dB_ik sum_l S_il (dF Fi)_kl.
    Rows weighted = Rows::Zero();
    for (int i = 0; i < D; ++i)
      for (int k = 0; k < D; ++k)
        for (int l = 0; l < D; ++l) weighted.row(i * D + k) += stress(i, l) * rate.row(k * D + l);
    const Eigen::Matrix<double, size, size> product = change.transpose() * weighted;
    hessian -= c * (product + product.transpose());
  }
  return hessian;
}

template <int D>
CellHessian<D> energy_hessian_of_fit(const std::vector<UnseenField<D, double>>& unseen, const Body& body, const Workspace<D>& work,
                                     std::int32_t row) {
  constexpr int first = D * D, pairs = curvature_components<D>, size = first + D * pairs;
  using Change = Eigen::Matrix<double, 1, size>;  // of a number over (dG, dK)
  // P and Q, four times the same.
  Lanes h[D][D], f[D][D], inverse_transposed[D][D], k_full[D][pairs], p[D][D], q[D][pairs] = {};
  Matrix<D> g;
  for (int a = 0; a < D; ++a) {
    for (int b = 0; b < D; ++b) {
      h[a][b] = broadcast(work.displacement_gradient[a][b][row]);
      f[a][b] = h[a][b] + (a == b ? 1.0 : 0.0);
      g(a, b) = work.fitted_gradient[a][b][row] + (a == b ? 1.0 : 0.0);
    }
    for (int n = 0; n < pairs; ++n) k_full[a][n] = broadcast(work.curvature[a][n][row]);
  }
  const Lanes j = cofactor(f, inverse_transposed);
  for (auto& rows : inverse_transposed)
    for (Lanes& entry : rows) entry /= j;
  std::visit([&](const auto& law) { law.template stress<D>(h, f, inverse_transposed, j, p); }, body.material.law);
  strain_gradient<D>(body.material, body.spacing * body.spacing / 12, inverse_transposed, k_full, p, q);

  const Matrix<D> inverse = g.inverse();
  double pulled[D][pairs];
  Change pulled_change[D][pairs];
  for (int m = 0; m < D; ++m)
    for (int n = 0; n < pairs; ++n) {
      pulled[m][n] = 0;
      for (int i = 0; i < D; ++i) pulled[m][n] += inverse(m, i) * work.fitted_curvature[i][n][row];
    }
  for (int m = 0; m < D; ++m)
    for (int n = 0; n < pairs; ++n) {
      Change& change = pulled_change[m][n];
      change.setZero();
      for (int i = 0; i < D; ++i) {
        change[first + i * pairs + n] += inverse(m, i);
        for (int c = 0; c < D; ++c) change[i * D + c] -= inverse(m, i) * pulled[c][n];
      }
    }
  CellHessian<D> to_full = CellHessian<D>::Identity(), half = CellHessian<D>::Zero();
  for (const UnseenField<D, double>& field : unseen) {
    double a[D];
    amplitude_of<D>(field, pulled, a);
    Change a_change[D], turned[D];  // da, and d(G a)
    for (int c = 0; c < D; ++c) {
      a_change[c].setZero();
      for (int m = 0; m < D; ++m)
        for (int n = 0; n < pairs; ++n) a_change[c] += field.amplitude[c][m][n] * pulled_change[m][n];
    }
    Vector<D> w = Vector<D>::Zero();
    for (int i = 0; i < D; ++i) {
      turned[i].setZero();
      for (int c = 0; c < D; ++c) {
        turned[i] += g(i, c) * a_change[c];
        turned[i][i * D + c] += a[c];
        w[i] += p[i][c][0] * field.gradient[c];
      }
      for (int n = 0; n < pairs; ++n) w[i] += q[i][n][0] * field.curvature[n];
      for (int b = 0; b < D; ++b) to_full.row(i * D + b) += field.gradient[b] * turned[i];
      for (int n = 0; n < pairs; ++n) to_full.row(first + i * pairs + n) += field.curvature[n] * turned[i];
      for (int c = 0; c < D; ++c) half.row(i * D + c) += w[i] * a_change[c];
    }
    const Vector<D> s = g.transpose() * w;
    for (int m = 0; m < D; ++m)
      for (int n = 0; n < pairs; ++n) {
        double t = 0;
        for (int c = 0; c < D; ++c) t += s[c] * field.amplitude[c][m][n];
        for (int i = 0; i < D; ++i)
          for (int c = 0; c < D; ++c) half.row(i * D + c) -= t * inverse(m, i) * pulled_change[c][n];
      }
  }
  const CellHessian<D> hessian = energy_hessian<D>(body, work, row);
  return to_full.transpose() * hessian * to_full + half + half.transpose();
}

template <int D>
Tangent<D>::Tangent(const Reference<D>& reference) {
  std::vector<std::int32_t> node_of_row(reference.rows, -1);
  for (const auto row : reference.particle_row) {
    if (reference.inverse_mass[row] == 0) continue;
    node_of_row[row] = static_cast<std::int32_t>(free_rows_.size());
    free_rows_.push_back(row);
  }
  const auto nodes = static_cast<std::int32_t>(free_rows_.size());

  const auto add_particle = [&](std::int32_t row, std::uint32_t body, const auto& column) -> Particle& {
    const auto rows = column.begin()->second.size();
    Particle particle{row, body, {}, Eigen::MatrixXd(rows, static_cast<Eigen::Index>(column.size())), {}, {}};
    for (const auto& [node, values] : column) {
      particle.derivative.col(static_cast<Eigen::Index>(particle.node.size())) = values;
      particle.node.push_back(node);
    }
    assembly_size_ += static_cast<double>(column.size() * column.size()) * D * D * static_cast<double>(rows) / 2;
    return particles_.emplace_back(std::move(particle));
  };
  for (const ShellBody<D>& shell : reference.shells)
    for (std::size_t i = 0; i < shell.layer.size(); ++i) {
      using Operators = Eigen::Matrix<double, shell_unknowns<D>, 1>;
      std::map<std::int32_t, Operators> column;
      Operators own = Operators::Zero();
      for (auto n = shell.layer.first[i]; n < shell.layer.first[i + 1]; ++n) {
        own -= shell.layer.weight[n];
        const auto node = node_of_row[shell.first_row + static_cast<std::int32_t>(shell.layer.neighbour[n])];
        if (node >= 0) column[node] = shell.layer.weight[n];
      }
      const std::int32_t row = shell.first_row + static_cast<std::int32_t>(i);
      if (node_of_row[row] >= 0) column[node_of_row[row]] = own;
      if (shell.layer.particles.area[i] > 0 && !column.empty()) add_particle(row, shell.body, column);
    }
  for (const Block& block : reference.blocks) {
    if (reference.bodies[block.body].shell >= 0) continue;
    const Stencil<D>& stencil = reference.stencils[block.stencil];
    for (int lane = 0; lane < lane_count; ++lane) {
      const std::int32_t row = block.row + lane;
      if (node_of_row[row] < 0) continue;
      std::map<std::int32_t, Eigen::Matrix<double, operators, 1>> column;
      Eigen::Matrix<double, operators, 1> own = Eigen::Matrix<double, operators, 1>::Zero();
      for (std::uint32_t k = stencil.first; k < stencil.first + stencil.count; ++k) {
        Eigen::Matrix<double, operators, 1> values;
        for (int a = 0; a < D; ++a) values[a] = reference.neighbours[k].gradient[a][lane];
        for (int c = 0; c < curvature_components<D>; ++c) values[D + c] = reference.neighbours[k].curvature[c][lane];
        own -= values;
        const std::int32_t node = values.isZero(0) ? -1 : node_of_row[row + reference.row_offset[k]];
        if (node >= 0) column[node] = values;
      }
      column[node_of_row[row]] = own;
      Particle& particle = add_particle(row, block.body, column);
      for (std::uint32_t r = stencil.first_unseen; r < stencil.first_unseen + stencil.unseen; ++r)
        particle.unseen.push_back(of_lane<D>(reference.unseen[r], lane));
    }
  }

  // Pattern: the nodes below the diagonal of each node's columns.
  std::vector<std::vector<std::int32_t>> below(nodes);
  for (const Particle& particle : particles_)
    for (std::size_t l = 0; l < particle.node.size(); ++l)
      below[particle.node[l]].insert(below[particle.node[l]].end(), particle.node.begin() + l + 1, particle.node.end());
  Eigen::VectorXi sizes(nodes * D);
  for (std::int32_t l = 0; l < nodes; ++l) {
    std::sort(below[l].begin(), below[l].end());
    below[l].erase(std::unique(below[l].begin(), below[l].end()), below[l].end());
    for (int c = 0; c < D; ++c) sizes[l * D + c] = static_cast<int>(below[l].size()) * D + D - c;
  }
  matrix_.resize(nodes * D, nodes * D);
  matrix_.reserve(sizes);
  for (std::int32_t l = 0; l < nodes; ++l)
    for (int c = 0; c < D; ++c) {
      for (int a = c; a < D; ++a) matrix_.insert(l * D + a, l * D + c) = 0;
      for (const auto j : below[l])
        for (int a = 0; a < D; ++a) matrix_.insert(j * D + a, l * D + c) = 0;
    }
  matrix_.makeCompressed();
  for (Particle& particle : particles_)
    for (std::size_t l = 0; l < particle.node.size(); ++l) {
      const auto& column = below[particle.node[l]];
      for (std::size_t j = l; j < particle.node.size(); ++j)
        particle.place.push_back(
            j == l ? -1 : static_cast<std::int32_t>(std::lower_bound(column.begin(), column.end(), particle.node[j]) - column.begin()));
    }
  factor_.cholmod().print = 0;  // a tangent that is not positive definite is an answer, not a message
  factor_.analyzePattern(matrix_);
  factor_size_ = factor_.cholmod().lnz;
  factor_work_ = factor_.cholmod().fl;
}

template <int D>
template <int Operators, class Hessian, class Index>
void Tangent<D>::add(const Particle& particle, const Hessian& hessian, double size, const Index& index) {
  double* values = matrix_.valuePtr();
  const auto* outer = matrix_.outerIndexPtr();
  const auto count = static_cast<Eigen::Index>(particle.node.size());
  using Derivative = Eigen::Matrix<double, Operators, Eigen::Dynamic>;
  const Eigen::Map<const Derivative> derivative(particle.derivative.data(), Operators, count);
  // S^T A^ac of every pair of components: A^ac over the derivatives of component a and c.
  Eigen::Matrix<double, Eigen::Dynamic, Operators> left[D][D];
  for (int a = 0; a < D; ++a)
    for (int c = 0; c < D; ++c) {
      Eigen::Matrix<double, Operators, Operators> part;
      for (int s = 0; s < Operators; ++s)
        for (int t = 0; t < Operators; ++t) part(s, t) = size * hessian(index(a, s), index(c, t));
      left[a][c].noalias() = derivative.transpose() * part;
    }
  const std::int32_t* place = particle.place.data();
  for (Eigen::Index l = 0; l < count; ++l) {
    const auto right = derivative.col(l);
    for (Eigen::Index j = l; j < count; ++j, ++place)
      for (int c = 0; c < D; ++c) {
        double* column = values + outer[particle.node[l] * D + c];
        if (*place < 0) {
          for (int a = c; a < D; ++a) column[a - c] += left[a][c].row(j).dot(right);
        } else {
          for (int a = 0; a < D; ++a) column[D - c + *place * D + a] += left[a][c].row(j).dot(right);
        }
      }
  }
}

template <int D>
void Tangent<D>::assemble(const Reference<D>& reference, const Workspace<D>& work, double mass_factor) {
  std::fill(matrix_.valuePtr(), matrix_.valuePtr() + matrix_.nonZeros(), 0.0);
  for (const Particle& particle : particles_) {
    const Body& body = reference.bodies[particle.body];
    if (const ShellBody<D>* shell = reference.shell_of(body)) {
      const auto i = static_cast<std::size_t>(particle.row - shell->first_row);
      const ShellWork<D>& own = work.shells[shell->index];
      add<shell_unknowns<D>>(particle, shell_energy_hessian<D>(shell->layer, i, own.derivatives[i], own.turn),
                             shell->layer.particles.area[i], [](int component, int s) { return D * s + component; });
      continue;
    }
    const CellHessian<D> hessian = particle.unseen.empty() ? energy_hessian<D>(body, work, particle.row)
                                                           : energy_hessian_of_fit<D>(particle.unseen, body, work, particle.row);
    add<operators>(particle, hessian, reference.volume[particle.row],
                   [](int component, int s) { return s < D ? component * D + s : D * D + component * curvature_components<D> + s - D; });
  }
  for (std::size_t n = 0; n < free_rows_.size(); ++n)
    for (int a = 0; a < D; ++a) matrix_.valuePtr()[matrix_.outerIndexPtr()[n * D + a]] += mass_factor * reference.mass[free_rows_[n]];
}

namespace {

/// OpenBLAS, where that is the BLAS, multiplies the blocks of a factor in as many parts as it has threads: other sums for other numbers.
void give_blas_one_thread() {
  static const auto set_threads = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (set_threads) set_threads(1);
}

}  // namespace

template <int D>
bool Tangent<D>::factorise() {
  if (D == 3) give_blas_one_thread();
  factor_.factorize(matrix_);
  return factor_.info() == Eigen::Success;
}

template class Tangent<2>;
template class Tangent<3>;

}  // namespace tern::structure
