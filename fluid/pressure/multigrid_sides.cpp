// Where a body may part the fluid, a place of the multigrid's grids has one node for each side. What belongs to one side is
// found by connection: see multigrid.hpp.

#include <algorithm>
#include <numeric>

#include "fluid/pressure/grid_stencil.hpp"
#include "fluid/pressure/multigrid.hpp"

namespace tern::fluid {
namespace {

/// Drops beside a body are parts as well. They need no node of their own, and so many would keep the coarsest grid from
/// being small: parts beyond this number share the last node.
constexpr int most_nodes_at_a_place = 4;

/// Place of `value` in a short list, or -1.
int place_in(const std::vector<int>& list, int value) {
  const auto found = std::find(list.begin(), list.end(), value);
  return found == list.end() ? -1 : static_cast<int>(found - list.begin());
}

/// Whether there is nothing left to join: nearly everywhere after the first few edges.
bool all_in_one(ConnectedParts& parts) {
  parts.count_parts(2);
  return parts.count() == 1;
}

void sort_and_make_unique(std::vector<int>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

/// Gives the particles of a cell that are not connected within it cells of their own.
template <int D>
void Multigrid<D>::split_cells(const std::vector<int>& beside_body, int cells) {
  home_of_further_cell_.clear();
  suspect_cells_.clear();
  for (int i : beside_body)
    if (cell_of_particle_[i] >= 0) suspect_cells_.push_back(cell_of_particle_[i]);
  if (suspect_cells_.empty()) return;
  sort_and_make_unique(suspect_cells_);

  // Particles of the suspect cells, cell by cell.
  auto &suspect = compact_, &start = next_, &member = population_;
  suspect.assign(cells, -1);
  for (std::size_t k = 0; k < suspect_cells_.size(); ++k) suspect[suspect_cells_[k]] = static_cast<int>(k);
  start.assign(suspect_cells_.size() + 1, 0);
  const int n = static_cast<int>(cell_of_particle_.size());
  const auto suspect_of = [&](int i) {
    const int cell = cell_of_particle_[i];
    return cell < 0 || cell >= cells ? -1 : suspect[cell];  // those split off already lie in further cells
  };
  for (int i = 0; i < n; ++i)
    if (suspect_of(i) >= 0) ++start[suspect_of(i) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  member.resize(start.back());
  for (int i = n - 1; i >= 0; --i)
    if (suspect_of(i) >= 0) member[--start[suspect_of(i) + 1]] = i;
  // start[k + 1] is now where cell k begins.
  auto& parts = parts_;
  auto& own = around_;
  const int suspects = static_cast<int>(suspect_cells_.size());
  for (int k = 0; k < suspects; ++k) {
    const int first = start[k + 1], last = k + 2 <= suspects ? start[k + 2] : static_cast<int>(member.size());
    own.assign(member.begin() + first, member.begin() + last);
    parts.reset(static_cast<int>(own.size()));
    for (std::size_t a = 0; a < own.size(); ++a) {
      matrix_->for_edges(own[a], [&](int j, float) {
        if (suspect_of(j) == k) parts.join(static_cast<int>(a), place_in(own, j));
      });
      if (all_in_one(parts)) break;
    }
    parts.count_parts(most_nodes_at_a_place);
    const int before = cells + static_cast<int>(home_of_further_cell_.size()) - 1;
    home_of_further_cell_.insert(home_of_further_cell_.end(), parts.count() - 1, suspect_cells_[k]);
    for (std::size_t a = 0; a < own.size(); ++a)
      if (parts.number(static_cast<int>(a)) > 0) cell_of_particle_[own[a]] = before + parts.number(static_cast<int>(a));
  }
}

/// Numbers the parts of what is around the place of its node `first` and appends a node for each but the first of them. Part
/// k > 0 has the node k + what is returned.
template <int D>
int Multigrid<D>::add_further_nodes(Level& level, int first) {
  parts_.count_parts(most_nodes_at_a_place);
  const int before = static_cast<int>(level.nodes()) - 1;
  const std::array<int, D> at = level.coordinate[first];
  for (int k = 1; k < parts_.count(); ++k) {
    level.further.emplace_back(flat_index<D>(at, level.size), static_cast<int>(level.nodes()));
    level.coordinate.push_back(at);
  }
  return before;
}

/// Gives the cells around a place that are not connected with each other nodes of their own.
template <int D>
void Multigrid<D>::split_places(const std::array<int, D>& cells) {
  Level& level = levels_[0];
  level.further.clear();
  level.suspects.clear();
  if (suspect_cells_.empty()) return;
  for (int cell : suspect_cells_)
    for (int corner = 0; corner < corners; ++corner) level.suspects.push_back(cell_node_[compact_[cell]][corner]);
  sort_and_make_unique(level.suspects);

  const int grid_cells = count_places<D>(cells);
  auto& parts = parts_;
  auto &around = around_, &corner_of = corner_of_;
  for (int suspect : level.suspects) {
    around.clear();
    corner_of.clear();
    for (int corner = 0; corner < corners; ++corner) {
      std::array<int, D> at = level.coordinate[suspect];
      for (int c = 0; c < D; ++c) at[c] -= (corner >> c) & 1;
      const int home = place_at<D>(at, cells, level.periodic);
      if (home < 0 || compact_[home] < 0) continue;
      around.push_back(compact_[home]);
      corner_of.push_back(corner);
      const auto [first, last] = std::equal_range(home_of_further_cell_.begin(), home_of_further_cell_.end(), home);
      for (auto further = first; further != last; ++further) {
        around.push_back(compact_[grid_cells + (further - home_of_further_cell_.begin())]);
        corner_of.push_back(corner);
      }
    }
    parts.reset(static_cast<int>(around.size()));
    for (std::size_t a = 0; a < around.size(); ++a) {
      for (int entry = cell_start_[around[a]]; entry < cell_start_[around[a] + 1]; ++entry)
        matrix_->for_edges(cell_particle_[entry], [&](int j, float) {
          const int b = place_in(around, compact_[cell_of_particle_[j]]);
          if (b >= 0) parts.join(static_cast<int>(a), b);
        });
      if (all_in_one(parts)) break;
    }
    const int before = add_further_nodes(level, suspect);
    for (std::size_t a = 0; a < around.size(); ++a)
      if (parts.number(static_cast<int>(a)) > 0) cell_node_[around[a]][corner_of[a]] = before + parts.number(static_cast<int>(a));
  }
}

/// The same on a coarser level: what is connected are the finer nodes around a place.
template <int D>
void Multigrid<D>::split_coarse_places(Level& fine, Level& coarse, const std::array<bool, D>& halved) {
  coarse.further.clear();
  coarse.suspects.clear();
  for (int node : fine.suspects)
    for (int parent : fine.parent[node])
      if (parent >= 0) coarse.suspects.push_back(parent);
  sort_and_make_unique(coarse.suspects);

  auto& parts = parts_;
  auto &around = around_, &corner_of = corner_of_;
  for (int suspect : coarse.suspects) {
    around.clear();
    corner_of.clear();
    for (int s = 0; s < stencil; ++s) {
      const auto offset = stencil_offset<D>(s);
      std::array<int, D> at = coarse.coordinate[suspect];
      int corner = 0;  // of the finer node's cell of parents at which this place is
      bool is_finer = true;
      for (int c = 0; c < D; ++c) {
        if (halved[c]) at[c] = 2 * at[c] + offset[c];
        corner |= (offset[c] < 0) << c;
        is_finer = is_finer && (halved[c] || offset[c] == 0);
      }
      if (!is_finer) continue;
      for_nodes_at(fine, at, [&](int node) {
        around.push_back(node);
        corner_of.push_back(corner);
      });
    }
    parts.reset(static_cast<int>(around.size()));
    for (std::size_t a = 0; a < around.size(); ++a)
      for_entries(fine, around[a], [&](int other, float) {
        const int b = place_in(around, other);
        if (b >= 0) parts.join(static_cast<int>(a), b);
      });
    const int before = add_further_nodes(coarse, suspect);
    for (std::size_t a = 0; a < around.size(); ++a)
      if (parts.number(static_cast<int>(a)) > 0) fine.parent[around[a]][corner_of[a]] = before + parts.number(static_cast<int>(a));
  }
}

/// Marks the nodes whose neighbours are not all the only ones of their places.
template <int D>
void Multigrid<D>::mark_by_split(Level& level) {
  level.by_split.clear();
  if (level.further.empty()) return;
  level.by_split.assign(level.nodes(), 0);
  for (const auto& split : level.further)
    for (int s = 0; s < stencil; ++s) {
      auto at = stencil_offset<D>(s);
      for (int c = 0; c < D; ++c) at[c] += level.coordinate[split.second][c];
      for_nodes_at(level, at, [&](int node) { level.by_split[node] = 1; });
    }
}

#define TERN_INSTANTIATE(D)                                                                    \
  template void Multigrid<D>::split_cells(const std::vector<int>&, int);                       \
  template void Multigrid<D>::split_places(const std::array<int, D>&);                         \
  template int Multigrid<D>::add_further_nodes(Level&, int);                                   \
  template void Multigrid<D>::split_coarse_places(Level&, Level&, const std::array<bool, D>&); \
  template void Multigrid<D>::mark_by_split(Level&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
