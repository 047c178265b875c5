// How the grids of the multigrid and their operators are built; multigrid_cycle.cpp solves on them.

#include "fluid/pressure/multigrid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "fluid/pressure/grid_stencil.hpp"

namespace tern::fluid {
namespace {

constexpr int coarsest_nodes = 150;  ///< solved directly
constexpr int most_levels = 12;
constexpr float diagonal_shift = 2e-6f;  ///< relative; makes the coarse operators of a sealed tank regular

/// Cells of a period of `length`: m 2^k with m = 4 .. 7, nearest to `width` on a logarithmic scale.
int cells_of_period(double length, double width) {
  int best = 4;
  const auto distance = [&](int n) { return std::abs(std::log(n * width / length)); };
  for (int factor = 1; factor * width < length; factor *= 2)
    for (int m = 4; m < 8; ++m)
      if (distance(m * factor) < distance(best)) best = m * factor;
  return best;
}

}  // namespace

template <int D>
void Multigrid<D>::build(const Domain<D>& domain, EdgeMatrix& matrix, const std::vector<Vector<D>>& position,
                         const std::vector<ParticleClass>& particle_class, const std::vector<int>& beside_body, double spacing,
                         double gradient_scale, const YieldingSurface<D>& yielding, const std::vector<int>& at_structure) {
  matrix_ = &matrix;
  domain_ = &domain;
  if (!domain.alone()) matrix.with_ghosts(position.size(), [&](auto&... values) { domain.particles().update(values...); });
  if (levels_.empty()) levels_.resize(1);
  build_finest(matrix, position, particle_class, beside_body, spacing, gradient_scale);
  std::size_t level = 0;
  while (levels_[level].divided || (levels_[level].nodes() > coarsest_nodes && level < most_levels)) {
    if (levels_.size() == level + 1) levels_.emplace_back();
    levels_[level + 1].divided = coarser_is_divided(level);
    build_next(levels_[level], levels_[level + 1]);
    ++level;
    if (!levels_[level - 1].divided && levels_[level].nodes() == levels_[level - 1].nodes()) break;
  }
  levels_.resize(level + 1);

  const Level& last = levels_.back();
  const auto n = static_cast<Eigen::Index>(last.nodes());
  coarsest_.assign(last.nodes() * last.nodes(), 0);
  Eigen::Map<Eigen::MatrixXd> dense(coarsest_.data(), n, n);
  for (Eigen::Index a = 0; a < n; ++a)
    for (int s = 0; s < stencil; ++s)
      if (last.row[a][s] != 0) dense(a, last.neighbour[a][s]) += last.row[a][s];
  for (const Entry& entry : last.further_entries) dense(entry.row, entry.column) += entry.value;
  build_yielding(yielding, at_structure);
  for (auto* v : {&r_, &z_, &az_}) v->assign(position.size(), 0);
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> in_place(dense);
  coarsest_solution_.resize(last.nodes());
  find_parts();
}

/// Whether the grid after this one has so many nodes that they are worth dividing.
template <int D>
bool Multigrid<D>::coarser_is_divided(std::size_t level) const {
  if (!levels_[level].divided || level + 2 >= most_levels) return false;
  const auto& foreign = levels_[level].foreign;
  const auto own = std::count(foreign.begin(), foreign.end(), std::uint8_t{0});
  return domain_->ranks().sum(static_cast<std::int64_t>(own)) > coarsest_nodes << D;
}

template <int D>
void Multigrid<D>::find_parts() {
  const Level& last = levels_.back();
  const int n = static_cast<int>(last.nodes());
  parts_.reset(n);
  for (int a = 0; a < n; ++a) for_entries(last, a, [&](int b, float) { parts_.join(a, b); });
  parts_.count_parts(n);
  part_of_particle_.assign(r_.size(), 0);
  if (parts_.count() < 2) return;
  auto &part = part_of_node_, &finer = part_of_finer_node_;
  part.resize(n);
  for (int a = 0; a < n; ++a) part[a] = parts_.number(a);
  for (std::size_t level = levels_.size() - 1; level-- > 0;) {
    finer.resize(levels_[level].nodes());
    for (std::size_t a = 0; a < finer.size(); ++a)
      for (int parent : levels_[level].parent[a])
        if (parent >= 0) finer[a] = part[parent];
    part.swap(finer);
  }
  for (std::size_t cell = 0; cell < cell_node_.size(); ++cell)
    for (int entry = cell_start_[cell]; entry < cell_start_[cell + 1]; ++entry)
      part_of_particle_[cell_particle_[entry]] = part[cell_node_[cell][0]];
}

template <int D>
void Multigrid<D>::build_finest(const EdgeMatrix& matrix, const std::vector<Vector<D>>& position,
                                const std::vector<ParticleClass>& particle_class, const std::vector<int>& beside_body, double spacing,
                                double gradient_scale) {
  Level& level = levels_[0];
  const int n = static_cast<int>(position.size());
  Vector<D> low = Vector<D>::Constant(1e300), high = Vector<D>::Constant(-1e300);
  for (int i = 0; i < n; ++i)
    if (particle_class[i].pressure_unknown()) low = low.cwiseMin(position[i]), high = high.cwiseMax(position[i]);
  std::array<double, D + 1> least{}, most{};  // and whether any rank has particles beside a body
  for (int c = 0; c < D; ++c) least[c] = low[c], most[c] = high[c];
  most[D] = beside_body.empty() ? 0 : 1;
  domain_->ranks().extremes(std::span(least), std::span(most));
  for (int c = 0; c < D; ++c) low[c] = least[c], high[c] = most[c];
  parted_ = most[D] > 0;
  if (low[0] > high[0]) low = high = Vector<D>::Zero();
  Vector<D>& origin = origin_;
  Vector<D> inverse_width;
  std::array<int, D> cells;
  for (int c = 0; c < D; ++c) {
    level.periodic[c] = period_.repeats(c);
    double width = 2 * spacing;
    if (level.periodic[c]) {
      cells[c] = cells_of_period(period_.length(c), width);
      width = period_.length(c) / cells[c];
      low[c] = period_.begin(c);
    }
    origin[c] = low[c] - 0.37 * width;  // off the lattice, so that no particle sits on a grid line at rest
    inverse_width[c] = 1 / width;
    level.width[c] = width;
    if (!level.periodic[c]) cells[c] = static_cast<int>((high[c] - origin[c]) * inverse_width[c]) + 1;
    level.size[c] = level.periodic[c] ? cells[c] : cells[c] + 1;
  }
  level.first = {};
  level.whole = level.size;
  level.divided = !domain_->alone();
  if (level.divided) {
    std::array<int, D> last{};
    level.first.fill(std::numeric_limits<int>::max() - 1);
    for (int i = 0; i < n; ++i)
      for (int c = 0; c < D && particle_class[i].pressure_unknown(); ++c) {
        const int cell = static_cast<int>((position[i][c] - origin[c]) * inverse_width[c]);
        level.first[c] = std::min(level.first[c], cell);
        last[c] = std::max(last[c], cell);
      }
    for (int c = 0; c < D; ++c) {
      if (level.periodic[c]) {
        level.first[c] = 0;
        continue;
      }
      level.first[c] = std::min(level.first[c], last[c]) & ~1;
      cells[c] = last[c] - level.first[c] + 1;
      level.size[c] = cells[c] + 1;
    }
  }
  const int count = count_places<D>(cells);

  // Particles by cell; only cells that hold one are kept, in order.
  auto &cell_of = cell_of_particle_, &population = population_, &compact = compact_, &next = next_;
  cell_of.assign(n, -1);
  for (int i = 0; i < n; ++i) {
    if (!particle_class[i].pressure_unknown()) continue;
    std::array<int, D> cell;
    for (int c = 0; c < D; ++c) {
      cell[c] = static_cast<int>((position[i][c] - origin[c]) * inverse_width[c]) - level.first[c];
      if (level.periodic[c]) cell[c] %= cells[c];
    }
    cell_of[i] = flat_index<D>(cell, cells);
  }
  split_cells(beside_body, cells);
  const int all_cells = count + static_cast<int>(home_of_further_cell_.size());
  const auto coordinates_of = [&](int flat) { return coordinate_of<D>(flat < count ? flat : home_of_further_cell_[flat - count], cells); };
  population.assign(all_cells, 0);
  compact.assign(all_cells, -1);
  for (int i = 0; i < n; ++i)
    if (cell_of[i] >= 0) ++population[cell_of[i]];
  level.map.assign(count_places<D>(level.size), -1);
  cell_start_.clear();
  cell_node_.clear();
  int filled = 0;
  for (int flat = 0; flat < all_cells; ++flat) {
    if (population[flat] == 0) continue;
    const std::array<int, D> cell = coordinates_of(flat);
    for (int corner = 0; corner < corners; ++corner) {
      std::array<int, D> node = cell;
      for (int c = 0; c < D; ++c) node[c] += (corner >> c) & 1;
      level.map[place_at<D>(node, level.size, level.periodic)] = 0;
    }
    compact[flat] = static_cast<int>(cell_start_.size());
    cell_start_.push_back(filled);
    filled += population[flat];
  }
  cell_start_.push_back(filled);
  number_places(level);

  const int used = static_cast<int>(cell_start_.size()) - 1;
  cell_node_.resize(used);
  cell_sum_.resize(used);
  for (int flat = 0; flat < all_cells; ++flat) {
    if (compact[flat] < 0) continue;
    const std::array<int, D> cell = coordinates_of(flat);
    for (int corner = 0; corner < corners; ++corner) {
      std::array<int, D> node = cell;
      for (int c = 0; c < D; ++c) node[c] += (corner >> c) & 1;
      cell_node_[compact[flat]][corner] = node_at(level, node);
    }
  }
  cell_particle_.resize(filled);
  particle_weight_.resize(filled);
  next.assign(cell_start_.begin(), cell_start_.end() - 1);
  for (int i = 0; i < n; ++i)
    if (cell_of[i] >= 0) cell_particle_[next[compact[cell_of[i]]]++] = i;
  find_owners(level);
  split_places(cells);
  finish_copies(level);
  mark_by_split(level);
  connect(level);
  node_cell_.resize(level.nodes());
  for (auto& cells_around : node_cell_) cells_around.fill(-1);
  further_cells_.clear();
  for (int cell = 0; cell < used; ++cell)
    for (int corner = 0; corner < corners; ++corner) {
      const int number = cell_node_[cell][corner];
      int& place = node_cell_[number][corner];
      if (place < 0)
        place = cell;
      else
        further_cells_.push_back({number, corner, cell});
    }

  // Element matrices cell by cell, then rows by gathering from the cells around each node.
  auto& element = element_;
  element.resize(used);
  const Vector<D> scale = gradient_scale * inverse_width.cwiseAbs2();
  parallel_for(used, n, [&](int cell) {
    double sum[corners * corners] = {};
    for (int entry = cell_start_[cell]; entry < cell_start_[cell + 1]; ++entry) {
      const int i = cell_particle_[entry];
      double f[D];
      for (int c = 0; c < D; ++c) {
        const double at = (position[i][c] - origin[c]) * inverse_width[c];
        f[c] = at - static_cast<int>(at);
      }
      double phi[corners], gradient[corners][D];
      for (int corner = 0; corner < corners; ++corner) {
        phi[corner] = 1;
        for (int c = 0; c < D; ++c) phi[corner] *= (corner >> c) & 1 ? f[c] : 1 - f[c];
        for (int c = 0; c < D; ++c) {
          gradient[corner][c] = (corner >> c) & 1 ? 1 : -1;
          for (int o = 0; o < D; ++o)
            if (o != c) gradient[corner][c] *= (corner >> o) & 1 ? f[o] : 1 - f[o];
        }
        particle_weight_[entry][corner] = static_cast<float>(phi[corner]);
      }
      const double constant = matrix.constant()[i];
      for (int a = 0; a < corners; ++a)
        for (int b = a; b < corners; ++b) {
          double product = 0;
          for (int c = 0; c < D; ++c) product += scale[c] * gradient[a][c] * gradient[b][c];
          sum[a * corners + b] += product + constant * phi[a] * phi[b];
        }
    }
    for (int a = 0; a < corners; ++a)
      for (int b = 0; b < corners; ++b) element[cell][a * corners + b] = static_cast<float>(sum[std::min(a, b) * corners + std::max(a, b)]);
  });
  level.row.assign(level.nodes(), {});
  const auto add_cell = [&](int node, int a, int cell) {
    for (int b = 0; b < corners; ++b) {
      std::array<int, D> offset;
      for (int c = 0; c < D; ++c) offset[c] = ((b >> c) & 1) - ((a >> c) & 1);
      const float value = element[cell][a * corners + b];
      if (level.by_split.empty() || !level.by_split[node])
        level.row[node][stencil_entry<D>(offset)] += value;
      else
        add_entry(level, node, offset, cell_node_[cell][b], value);
    }
  };
  for (std::size_t node = 0; node < level.nodes(); ++node)
    for (int a = 0; a < corners && level.own(node); ++a)
      if (node_cell_[node][a] >= 0) add_cell(static_cast<int>(node), a, node_cell_[node][a]);
  for (const auto& [node, a, cell] : further_cells_)
    if (level.own(static_cast<std::size_t>(node))) add_cell(node, a, cell);
  finish(level);
}

template <int D>
void Multigrid<D>::number_places(Level& level) {
  level.coordinate.clear();
  for (int place = 0; place < static_cast<int>(level.map.size()); ++place) {
    if (level.map[place] < 0) continue;
    level.map[place] = static_cast<int>(level.nodes());
    level.coordinate.push_back(coordinate_of<D>(place, level.size));
  }
}

template <int D>
int Multigrid<D>::node_at(const Level& level, const std::array<int, D>& at) {
  const int place = place_at<D>(at, level.size, level.periodic);
  return place < 0 ? -1 : level.map[place];
}

template <int D>
int Multigrid<D>::color_of(const Level& level, int node) {
  const auto& at = level.coordinate[node];
  int color = 0;
  for (int c = D - 1; c >= 0; --c) {
    const bool last_of_odd = level.periodic[c] && level.size[c] % 2 == 1 && level.size[c] > 1 && at[c] == level.size[c] - 1;
    color = color * 3 + (last_of_odd ? 2 : at[c] & 1);
  }
  return color;
}

template <int D>
void Multigrid<D>::connect(Level& level) {
  level.further_entries.clear();
  level.neighbour.resize(level.nodes());
  for (auto& nodes : level.color) nodes.clear();
  for (int node = 0; node < static_cast<int>(level.nodes()); ++node) {
    if (level.own(static_cast<std::size_t>(node))) level.color[color_of(level, node)].push_back(node);
    if (!level.by_split.empty() && level.by_split[node]) {
      level.neighbour[node].fill(undecided);
      continue;
    }
    for (int s = 0; s < stencil; ++s) {
      auto other = stencil_offset<D>(s);
      for (int c = 0; c < D; ++c) other[c] += level.coordinate[node][c];
      const int number = node_at(level, other);
      level.neighbour[node][s] = number < 0 ? node : number;
    }
  }
}

template <int D>
void Multigrid<D>::add_entry(Level& level, int row, const std::array<int, D>& offset, int column, float value) {
  const int s = stencil_entry<D>(offset);
  int& neighbour = level.neighbour[row][s];
  if (neighbour == undecided) neighbour = column;
  if (neighbour == column)
    level.row[row][s] += value;
  else
    level.further_entries.push_back({row, column, value});
}

template <int D>
void Multigrid<D>::finish(Level& level) {
  constexpr int centre = stencil / 2;
  level.inverse_diagonal.resize(level.nodes());
  for (std::size_t node = 0; node < level.nodes(); ++node) {
    float& diagonal = level.row[node][centre];
    diagonal *= 1 + diagonal_shift;
    level.inverse_diagonal[node] = diagonal > 0 ? 1 / diagonal : 0;
  }
  for (auto& rows : level.further_rows) rows.clear();
  if (!level.by_split.empty()) {
    for (std::size_t node = 0; node < level.nodes(); ++node)
      for (int& neighbour : level.neighbour[node])
        if (neighbour == undecided) neighbour = static_cast<int>(node);
    auto& entries = level.further_entries;
    add_up(entries);
    const std::size_t kept = entries.size();
    for (std::size_t first = 0, last; first < kept; first = last) {
      for (last = first; last < kept && entries[last].row == entries[first].row;) ++last;
      level.further_rows[color_of(level, entries[first].row)].push_back(
          {entries[first].row, static_cast<int>(first), static_cast<int>(last)});
    }
  }
  for (auto* v : {&level.x, &level.b, &level.residual}) v->assign(level.nodes(), 0);
}

template <int D>
void Multigrid<D>::build_next(Level& fine, Level& coarse) {
  // Nodes with even coordinates; a fine node between them has the 2, 4 or 8 around it as parents, all of them active.
  std::array<bool, D> halved;
  for (int c = 0; c < D; ++c) {
    coarse.periodic[c] = fine.periodic[c];
    halved[c] = !fine.periodic[c] || (fine.size[c] % 2 == 0 && fine.size[c] > 2);
    coarse.whole[c] = fine.periodic[c] ? (halved[c] ? fine.whole[c] / 2 : fine.whole[c]) : (fine.whole[c] + 2) / 2;
    coarse.width[c] = halved[c] ? 2 * fine.width[c] : fine.width[c];
  }
  coarse.first = {};
  coarse.size = coarse.whole;

  fine.parent.resize(fine.nodes());
  fine.parent_weight.resize(fine.nodes());
  // Among the places of all ranks.
  const auto parent_of = [&](const std::array<int, D>& at, int corner, std::array<int, D>& parent) {
    float weight = 1;
    for (int c = 0; c < D; ++c) {
      const bool odd = halved[c] && at[c] & 1, upper = (corner >> c) & 1;
      if (!odd && upper) return 0.0f;
      parent[c] = halved[c] ? wrapped((at[c] + fine.first[c]) / 2 + (upper ? 1 : 0), coarse.whole[c], coarse.periodic[c]) : at[c];
      if (odd) weight *= 0.5f;
    }
    return weight;
  };
  const auto for_parents = [&](auto&& visit) {
    for (std::size_t node = 0; node < fine.nodes(); ++node)
      for (int corner = 0; corner < corners; ++corner) {
        std::array<int, D> parent;
        if (parent_of(fine.coordinate[node], corner, parent) > 0) visit(node, parent);
      }
  };
  coarse.foreign.clear();
  coarse.suspects.clear();
  if (fine.divided) {
    parents_.clear();
    place_.assign(fine.nodes(), 0);
    for (const int node : fine.suspects) place_[node] = 1;
    for_parents([&](std::size_t node, const std::array<int, D>& parent) { parents_.push_back({parent, place_[node]}); });
  }
  if (coarse.divided) {
    share_places(coarse, parents_);
  } else {
    coarse.map.assign(count_places<D>(coarse.size), -1);
    if (fine.divided) {
      mark_on_all_ranks(coarse, parents_);
    } else {
      for_parents([&](std::size_t, const std::array<int, D>& parent) { coarse.map[flat_index<D>(parent, coarse.size)] = 0; });
      number_places(coarse);
    }
  }
  for (std::size_t node = 0; node < fine.nodes(); ++node)
    for (int corner = 0; corner < corners; ++corner) {
      std::array<int, D> parent;
      const float weight = parent_of(fine.coordinate[node], corner, parent);
      for (int c = 0; c < D; ++c) parent[c] -= coarse.first[c];
      fine.parent_weight[node][corner] = weight;
      fine.parent[node][corner] = weight > 0 ? coarse.map[flat_index<D>(parent, coarse.size)] : -1;
    }
  split_coarse_places(fine, coarse, halved);
  finish_copies(coarse);
  mark_by_split(coarse);
  share_by_split(coarse);
  connect(coarse);

  int halved_bits = 0;
  for (int c = 0; c < D; ++c) halved_bits |= halved[c] << c;
  std::optional<GalerkinTerms<D>>& terms = galerkin_terms_[halved_bits];
  if (!terms) terms.emplace(halved);
  coarse.row.assign(coarse.nodes(), {});
  const auto is_by_split = [](const Level& level, int node) { return !level.by_split.empty() && level.by_split[node]; };
  far_entries_.clear();
  const auto is_far = [&](int row) {
    return fine.divided && is_by_split(coarse, row) && (!coarse.divided || !coarse.own(static_cast<std::size_t>(row)));
  };
  for (int a = 0; a < static_cast<int>(fine.nodes()); ++a) {
    if (!fine.own(static_cast<std::size_t>(a))) continue;
    bool by_split = is_by_split(fine, a);
    for (int parent : fine.parent[a]) by_split = by_split || (parent >= 0 && is_by_split(coarse, parent));
    if (by_split) {
      for_entries(fine, a, [&](int b, float value) {
        for (int ca = 0; ca < corners; ++ca)
          for (int cb = 0; cb < corners; ++cb) {
            const int row = fine.parent[a][ca], column = fine.parent[b][cb];
            if (row < 0 || column < 0) continue;
            const float part = fine.parent_weight[a][ca] * fine.parent_weight[b][cb] * value;
            if (is_far(row))
              far_entries_.push_back({node_of_all(coarse, row), node_of_all(coarse, column), part});
            else
              add_entry(coarse, row, step_between<D>(coarse.coordinate[row], coarse.coordinate[column], coarse.size), column, part);
          }
      });
      continue;
    }
    int parity = 0;
    for (int c = 0; c < D; ++c) parity |= (halved[c] && (fine.coordinate[a][c] & 1)) << c;
    for (const GalerkinTerm& term : terms->of(parity))
      coarse.row[fine.parent[a][term.parent]][term.coarse] += term.weight * fine.row[a][term.fine];
  }
  if (coarse.divided)
    coarse.copies.collect(coarse.row, [](auto& own, const auto& other) {
      for (int s = 0; s < stencil; ++s) own[s] += other[s];
    });
  else if (fine.divided)
    domain_->ranks().sum(std::span(coarse.row.data()->data(), coarse.nodes() * stencil));
  if (fine.divided) share_entries(coarse);
  finish(coarse);
}

template class Multigrid<2>;
template class Multigrid<3>;

}  // namespace tern::fluid
