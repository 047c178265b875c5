// The V-cycle of the multigrid: Jacobi on the particles, Gauss-Seidel by colours on the grids, the coarsest solved directly.

#include <algorithm>
#include <cmath>

#include "fluid/pressure/grid_stencil.hpp"
#include "fluid/pressure/multigrid.hpp"

namespace tern::fluid {
namespace {

constexpr float jacobi_weight = 0.9f;  ///< positive definite for any weight < 1: lambda_max(D^-1 A) <= 2

}  // namespace

template <int D>
void Multigrid<D>::smooth(Level& level, bool forward) {
  for (int k = 0; k < colors; ++k) {
    const auto& nodes = level.color[forward ? k : colors - 1 - k];
    const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(nodes.size());
    parallel_for(n, [&](std::ptrdiff_t m) {
      const int node = nodes[m];
      const auto& row = level.row[node];
      const auto& neighbour = level.neighbour[node];
      float sum = level.b[node];
      for (int s = 0; s < stencil; ++s) sum -= row[s] * level.x[neighbour[s]];
      level.x[node] += sum * level.inverse_diagonal[node];
    });
    for (const auto& [row, first, last] : level.further_rows[forward ? k : colors - 1 - k])
      level.x[row] -= level.inverse_diagonal[row] * further_product(level, first, last);
  }
}

template <int D>
float Multigrid<D>::further_product(const Level& level, int first, int last) {
  float sum = 0;
  for (int k = first; k < last; ++k) sum += level.further_entries[k].value * level.x[level.further_entries[k].column];
  return sum;
}

template <int D>
void Multigrid<D>::compute_residual(Level& level) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(level.nodes());
  parallel_for(n, [&](std::ptrdiff_t node) {
    float sum = level.b[node];
    for (int s = 0; s < stencil; ++s) sum -= level.row[node][s] * level.x[level.neighbour[node][s]];
    level.residual[node] = sum;
  });
  for (const auto& rows : level.further_rows)
    for (const auto& [row, first, last] : rows) level.residual[row] -= further_product(level, first, last);
  add_difference(level, level.x, level.residual);
}

template <int D>
void Multigrid<D>::cycle(std::size_t l) {
  Level& level = levels_[l];
  if (l + 1 == levels_.size()) {
    const auto n = static_cast<Eigen::Index>(level.nodes());
    const Eigen::Map<const Eigen::MatrixXd> factor(coarsest_.data(), n, n);
    Eigen::Map<Eigen::VectorXd> x(coarsest_solution_.data(), n);
    for (Eigen::Index a = 0; a < n; ++a) x[a] = level.b[a];
    factor.template triangularView<Eigen::Lower>().solveInPlace(x);
    factor.template triangularView<Eigen::Lower>().transpose().solveInPlace(x);
    for (Eigen::Index a = 0; a < n; ++a) level.x[a] = static_cast<float>(x[a]);
    return;
  }
  std::fill(level.x.begin(), level.x.end(), 0.0f);
  smooth(level, true);
  if (level.divided) level.copies.update(level.x);
  compute_residual(level);
  Level& coarse = levels_[l + 1];
  std::fill(coarse.b.begin(), coarse.b.end(), 0.0f);
  for (std::size_t node = 0; node < level.nodes(); ++node)
    for (int corner = 0; corner < corners; ++corner)
      if (level.parent[node][corner] >= 0 && level.own(node))
        coarse.b[level.parent[node][corner]] += level.parent_weight[node][corner] * level.residual[node];
  if (coarse.divided)
    coarse.copies.collect(coarse.b, [](float& own, float other) { own += other; });
  else if (level.divided)
    domain_->ranks().sum(std::span(coarse.b));
  cycle(l + 1);
  for (std::size_t node = 0; node < level.nodes(); ++node)
    for (int corner = 0; corner < corners; ++corner)
      if (level.parent[node][corner] >= 0) level.x[node] += level.parent_weight[node][corner] * coarse.x[level.parent[node][corner]];
  add_difference(level, level.x, level.b);  // so that the last smoothing starts from the residual with R
  smooth(level, false);
  if (level.divided) level.copies.update(level.x);
}

template <int D>
void Multigrid<D>::apply(double largest, const std::vector<double>& r, std::vector<double>& z) {
  const std::ptrdiff_t n = matrix_->rows(), all = static_cast<std::ptrdiff_t>(r_.size());
  if (!(largest > 0)) largest = 1;
  const double inverse_largest = 1 / largest;
  const auto& diagonal = matrix_->diagonal();
  const auto multiply = [&] {
    matrix_->multiply(z_, az_);
    if (yielding_) yielding_->add_difference(*at_structure_, z_, az_);
  };
  parallel_for(n, [&](std::ptrdiff_t i) {
    r_[i] = static_cast<float>(r[i] * inverse_largest);
    z_[i] = jacobi_weight * r_[i] / diagonal[i];
  });
  domain_->particles().update(r_);
  for (std::ptrdiff_t i = n; i < all; ++i) z_[i] = jacobi_weight * r_[i] / diagonal[i];
  multiply();
  for (std::ptrdiff_t i = n; i < all; ++i) az_[i] = r_[i];  // the residual of a ghost comes to the nodes from its owner

  Level& finest = levels_[0];
  const std::ptrdiff_t cells = static_cast<std::ptrdiff_t>(cell_node_.size());
  parallel_for(cells, n, [&](std::ptrdiff_t cell) {
    std::array<float, corners> sum{};
    for (int entry = cell_start_[cell]; entry < cell_start_[cell + 1]; ++entry) {
      const int i = cell_particle_[entry];
      const float q = r_[i] - az_[i];
      for (int corner = 0; corner < corners; ++corner) sum[corner] += particle_weight_[entry][corner] * q;
    }
    cell_sum_[cell] = sum;
  });
  const std::ptrdiff_t nodes = static_cast<std::ptrdiff_t>(finest.nodes());
  parallel_for(nodes, [&](std::ptrdiff_t node) {
    float sum = 0;
    for (int corner = 0; corner < corners; ++corner)
      if (node_cell_[node][corner] >= 0) sum += cell_sum_[node_cell_[node][corner]][corner];
    finest.b[node] = sum;
  });
  for (const auto& [node, corner, cell] : further_cells_) finest.b[node] += cell_sum_[cell][corner];
  if (finest.divided) finest.copies.collect(finest.b, [](float& own, float other) { own += other; });
  cycle(0);
  parallel_for(cells, n, [&](std::ptrdiff_t cell) {
    for (int entry = cell_start_[cell]; entry < cell_start_[cell + 1]; ++entry) {
      float sum = 0;
      for (int corner = 0; corner < corners; ++corner) sum += particle_weight_[entry][corner] * finest.x[cell_node_[cell][corner]];
      z_[cell_particle_[entry]] += sum;
    }
  });
  multiply();
  parallel_for(n, [&](std::ptrdiff_t i) { z[i] = largest * (double(z_[i]) + double(jacobi_weight) * (r_[i] - az_[i]) / diagonal[i]); });
}

template void Multigrid<2>::apply(double, const std::vector<double>&, std::vector<double>&);
template void Multigrid<3>::apply(double, const std::vector<double>&, std::vector<double>&);

}  // namespace tern::fluid
