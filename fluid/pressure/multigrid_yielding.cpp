// The structure's part in the operators of the multigrid. The matrix has the diagonal bound kappa in place of R, how the structure yields
// (yielding_surface.hpp), and so have the rows of all levels. Where both faces of a plate are wet, kappa is far above R: it ties pressures
// to zero that do not move the plate. So every level also has the difference, as a form of low rank,
//   (kappa - R)_l = P_l^T (kappa - C^T S C) P_l = P_l^T kappa P_l - V_l^T S V_l,      V_l = C P_l
// with P_l from the nodes of the level to the particles beside the structure. Residuals, and the coarsest matrix, are those with R.
// Smoothing goes on with kappa: it needs a bound of the operator only.
//
// With several ranks each has the rows of its own particles on the levels that are divided, and on the coarser ones, which are the same on
// all ranks, the rows of all.

#include "fluid/pressure/multigrid.hpp"

#include <algorithm>
#include <numeric>

#include <Eigen/Core>

#include "fluid/boundary/interface_of_ranks.hpp"

namespace tern::fluid {

template <int D>
void Multigrid<D>::build_yielding(const YieldingSurface<D>& yielding, const std::vector<int>& at_structure) {
  yielding_ = yielding.any() ? &yielding : nullptr;
  at_structure_ = &at_structure;
  if (!yielding_) return;
  const std::size_t own_rows = at_structure.size();
  auto& row_of = row_of_particle_;
  row_of.assign(matrix_->rows(), -1);
  for (std::size_t m = 0; m < own_rows; ++m) row_of[at_structure[m]] = static_cast<int>(m);
  auto& corner_of_row = corner_of_row_;
  corner_of_row.assign(own_rows, {-1, -1});
  for (std::size_t cell = 0; cell < cell_node_.size(); ++cell)
    for (int entry = cell_start_[cell]; entry < cell_start_[cell + 1]; ++entry)
      if (const int i = cell_particle_[entry]; i < matrix_->rows() && row_of[i] >= 0)
        corner_of_row[row_of[i]] = {static_cast<int>(cell), entry};
  push_.resize(yielding.lumps());
  const bool shared = !domain_->alone();
  if (shared) gather_rows_of_all(yielding);

  for (std::size_t l = 0; l < levels_.size(); ++l) {
    Level& level = levels_[l];
    Beside& beside = level.beside;
    beside.begin.assign(1, 0);
    beside.node.clear();
    beside.weight.clear();
    place_.assign(level.nodes(), -1);
    const auto add = [&](int node, float weight) {
      if (node < 0 || weight == 0) return;
      if (place_[node] < 0) {
        place_[node] = static_cast<int>(beside.node.size());
        beside.node.push_back(node);
        beside.weight.push_back(0);
      }
      beside.weight[place_[node]] += weight;
    };
    const std::size_t rows = l == 0 ? own_rows : levels_[l - 1].beside.begin.size() - 1;
    for (std::size_t m = 0; m < rows; ++m) {
      if (l == 0) {
        if (const auto [cell, entry] = corner_of_row[m]; cell >= 0)
          for (int corner = 0; corner < corners; ++corner) add(cell_node_[cell][corner], particle_weight_[entry][corner]);
      } else {
        const Level& finer = levels_[l - 1];
        for (int k = finer.beside.begin[m]; k < finer.beside.begin[m + 1]; ++k)
          for (int corner = 0; corner < corners; ++corner)
            add(finer.parent[finer.beside.node[k]][corner], finer.beside.weight[k] * finer.parent_weight[finer.beside.node[k]][corner]);
      }
      for (std::size_t k = beside.begin[m]; k < beside.node.size(); ++k) place_[beside.node[k]] = -1;
      beside.begin.push_back(static_cast<int>(beside.node.size()));
    }
    if (l > 0 && levels_[l - 1].divided && !level.divided) {
      std::vector<int> count;
      for (std::size_t m = 0; m < rows; ++m) count.push_back(beside.begin[m + 1] - beside.begin[m]);
      const Ranks& ranks = domain_->ranks();
      ranks.gather_on_all(count, beside.node, beside.weight);
      beside.begin.assign(1, 0);
      for (const int of_row : count) beside.begin.push_back(beside.begin.back() + of_row);
    }

    beside.lump_begin.assign(1, 0);
    beside.lump_node.clear();
    beside.lump_vector.clear();
    for (std::size_t a = 0; a < yielding.lumps(); ++a) {
      for_rows_of_lump(shared && !level.divided, a, [&](int m, const Vector<D>& c) {
        for (int k = beside.begin[m]; k < beside.begin[m + 1]; ++k) {
          const int node = beside.node[k];
          if (place_[node] < 0) {
            place_[node] = static_cast<int>(beside.lump_node.size());
            beside.lump_node.push_back(node);
            beside.lump_vector.push_back(Vector<D>::Zero());
          }
          beside.lump_vector[place_[node]] += beside.weight[k] * c;
        }
      });
      for (std::size_t k = beside.lump_begin[a]; k < beside.lump_node.size(); ++k) place_[beside.lump_node[k]] = -1;
      beside.lump_begin.push_back(static_cast<int>(beside.lump_node.size()));
    }
  }

  const Beside& beside = levels_.back().beside;
  const auto n = static_cast<Eigen::Index>(levels_.back().nodes());
  Eigen::Map<Eigen::MatrixXd> dense(coarsest_.data(), n, n);
  for (std::size_t m = 0; m + 1 < beside.begin.size(); ++m)
    for (int j = beside.begin[m]; j < beside.begin[m + 1]; ++j)
      for (int k = beside.begin[m]; k < beside.begin[m + 1]; ++k)
        dense(beside.node[j], beside.node[k]) -= bound_of_row(shared, m) * beside.weight[j] * beside.weight[k];
  for (std::size_t a = 0; a < yielding.lumps(); ++a)
    for (int j = beside.lump_begin[a]; j < beside.lump_begin[a + 1]; ++j)
      for (int k = beside.lump_begin[a]; k < beside.lump_begin[a + 1]; ++k)
        dense(beside.lump_node[j], beside.lump_node[k]) += yielding.scale(a) * beside.lump_vector[j].dot(beside.lump_vector[k]);
}

template <int D>
template <class Visit>
void Multigrid<D>::for_rows_of_lump(bool of_all, std::size_t a, Visit&& visit) const {
  if (!of_all) return yielding_->for_rows(a, visit);
  for (int k = rows_of_all_.first[a]; k < rows_of_all_.first[a + 1]; ++k) visit(rows_of_all_.row[k], rows_of_all_.vector[k]);
}

template <int D>
void Multigrid<D>::gather_rows_of_all(const YieldingSurface<D>& yielding) {
  const Ranks& ranks = domain_->ranks();
  std::vector<double> bound;
  for (std::size_t m = 0; m < at_structure_->size(); ++m) bound.push_back(yielding.bound(m));
  const auto before = static_cast<int>(first_interface_particle(ranks, interface_counts(ranks, bound.size())));
  // Lump by lump on each rank: the order of the ranks is made one of the lumps.
  std::vector<int> lump, row;
  std::vector<Vector<D>> vector;
  for (std::size_t a = 0; a < yielding.lumps(); ++a)
    yielding.for_rows(a, [&](int m, const Vector<D>& c) {
      lump.push_back(static_cast<int>(a));
      row.push_back(before + m);
      vector.push_back(c);
    });
  ranks.gather_on_all(bound, lump, row, vector);
  rows_of_all_.bound = bound;
  rows_of_all_.first.assign(yielding.lumps() + 1, 0);
  for (const int a : lump) ++rows_of_all_.first[a + 1];
  std::partial_sum(rows_of_all_.first.begin(), rows_of_all_.first.end(), rows_of_all_.first.begin());
  rows_of_all_.row.resize(row.size());
  rows_of_all_.vector.resize(row.size());
  std::vector<int> next(rows_of_all_.first.begin(), rows_of_all_.first.end() - 1);
  for (std::size_t k = 0; k < row.size(); ++k) {
    const int to = next[lump[k]]++;
    rows_of_all_.row[to] = row[k];
    rows_of_all_.vector[to] = vector[k];
  }
}

template <int D>
void Multigrid<D>::add_rows(const Level& level, bool of_all, const std::vector<float>& x, std::vector<float>& y) const {
  const Beside& beside = level.beside;
  for (std::size_t m = 0; m + 1 < beside.begin.size(); ++m) {
    float value = 0;
    for (int k = beside.begin[m]; k < beside.begin[m + 1]; ++k) value += beside.weight[k] * x[beside.node[k]];
    value *= static_cast<float>(bound_of_row(of_all, m));
    for (int k = beside.begin[m]; k < beside.begin[m + 1]; ++k) y[beside.node[k]] += beside.weight[k] * value;
  }
}

template <int D>
void Multigrid<D>::push_lumps(const Level& level, const std::vector<float>& x) const {
  const Beside& beside = level.beside;
  for (std::size_t a = 0; a + 1 < beside.lump_begin.size(); ++a) {
    Vector<D> push = Vector<D>::Zero();
    for (int k = beside.lump_begin[a]; k < beside.lump_begin[a + 1]; ++k) push += beside.lump_vector[k] * double(x[beside.lump_node[k]]);
    push_[a] = yielding_->scale(a) * push;
  }
}

template <int D>
void Multigrid<D>::add_lumps(const Level& level, std::vector<float>& y) const {
  const Beside& beside = level.beside;
  for (std::size_t a = 0; a + 1 < beside.lump_begin.size(); ++a)
    for (int k = beside.lump_begin[a]; k < beside.lump_begin[a + 1]; ++k)
      y[beside.lump_node[k]] -= static_cast<float>(beside.lump_vector[k].dot(push_[a]));
}

template <int D>
void Multigrid<D>::add_difference(const Level& level, const std::vector<float>& x, std::vector<float>& y) {
  if (!yielding_) return;
  if (!level.divided) {
    add_rows(level, !domain_->alone(), x, y);
    push_lumps(level, x);
    add_lumps(level, y);
    return;
  }
  // Nodes get from the particles of other ranks as well.
  difference_.assign(level.nodes(), 0);
  add_rows(level, false, x, difference_);
  push_lumps(level, x);
  domain_->ranks().sum(std::span(push_.data()->data(), D * push_.size()));
  add_lumps(level, difference_);
  level.copies.collect(difference_, [](float& own, float other) { own += other; });
  for (std::size_t node = 0; node < level.nodes(); ++node) y[node] += difference_[node];
}

template void Multigrid<2>::build_yielding(const YieldingSurface<2>&, const std::vector<int>&);
template void Multigrid<3>::build_yielding(const YieldingSurface<3>&, const std::vector<int>&);
template void Multigrid<2>::add_difference(const Level&, const std::vector<float>&, std::vector<float>&);
template void Multigrid<3>::add_difference(const Level&, const std::vector<float>&, std::vector<float>&);

}  // namespace tern::fluid
