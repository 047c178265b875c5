// Where a body may part the fluid, a place of the multigrid's grids has one node for each side. What belongs to one side is
// found by connection: see multigrid.hpp.

#include <algorithm>
#include <numeric>

#include "fluid/pressure/grid_stencil.hpp"
#include "fluid/pressure/multigrid.hpp"

namespace tern::fluid {
namespace {

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
void Multigrid<D>::split_cells(const std::vector<int>& beside_body, const std::array<int, D>& cells) {
  home_of_further_cell_.clear();
  part_of_further_cell_.clear();
  suspect_cells_.clear();
  part_of_suspect_cell_.clear();
  if (!parted_) return;
  const int n = static_cast<int>(cell_of_particle_.size()), count = count_places<D>(cells);
  const bool shared = !domain_->alone();
  auto &suspect = compact_, &start = next_, &member = population_;
  auto& own = around_;
  // Particles of the suspect cells, cell by cell: start[k + 1] is where those of cell k begin.
  const auto list_members = [&] {
    sort_and_make_unique(suspect_cells_);
    suspect.assign(count, -1);
    for (std::size_t k = 0; k < suspect_cells_.size(); ++k) suspect[suspect_cells_[k]] = static_cast<int>(k);
    start.assign(suspect_cells_.size() + 1, 0);
    const auto suspect_of = [&](int i) { return cell_of_particle_[i] < 0 ? -1 : suspect[cell_of_particle_[i]]; };
    for (int i = 0; i < n; ++i)
      if (suspect_of(i) >= 0) ++start[suspect_of(i) + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    member.resize(start.back());
    for (int i = n - 1; i >= 0; --i)
      if (suspect_of(i) >= 0) member[--start[suspect_of(i) + 1]] = i;
  };
  const auto take_members = [&](std::size_t k) {
    own.assign(member.begin() + start[k + 1], k + 2 < start.size() ? member.begin() + start[k + 2] : member.end());
  };

  if (shared) {
    tell_ghosts_beside_body(beside_body);
    for (int i = 0; i < n; ++i)
      if (beside_[i] && cell_of_particle_[i] >= 0) suspect_cells_.push_back(cell_of_particle_[i]);
  } else {
    for (int i : beside_body)
      if (cell_of_particle_[i] >= 0) suspect_cells_.push_back(cell_of_particle_[i]);
  }
  list_members();
  auto& parts = parts_;
  part_in_cell_.assign(n, shared ? no_part : 0);
  sides_.link.clear();
  for (std::size_t k = 0; k < suspect_cells_.size(); ++k) {
    take_members(k);
    parts.reset(static_cast<int>(own.size()));
    for (std::size_t a = 0; a < own.size(); ++a) {
      if (own[a] >= matrix_->rows()) continue;
      matrix_->for_edges(own[a], [&](int j, float) {
        if (cell_of_particle_[j] == suspect_cells_[k]) parts.join(static_cast<int>(a), place_in(own, j));
      });
      if (all_in_one(parts)) break;
    }
    if (!shared) {
      parts.count_parts(most_nodes_at_a_place);
      for (std::size_t a = 0; a < own.size(); ++a) part_in_cell_[own[a]] = static_cast<std::uint8_t>(parts.number(static_cast<int>(a)));
      continue;
    }
    thing_.clear();
    for (const int i : own) thing_.push_back(name_[i]);
    note_links(place_of_all(levels_[0], coordinate_of<D>(suspect_cells_[k], cells)));
  }
  if (shared) {
    share_parts_of_cells();
    suspect_cells_.clear();
    for (int i = 0; i < n; ++i)
      if (part_in_cell_[i] != no_part && cell_of_particle_[i] >= 0) suspect_cells_.push_back(cell_of_particle_[i]);
    list_members();
  }
  // The first part that is here keeps the cell.
  for (std::size_t k = 0; k < suspect_cells_.size(); ++k) {
    take_members(k);
    std::uint8_t least = no_part;
    for (const int i : own) least = std::min(least, part_in_cell_[i]);
    part_of_suspect_cell_.push_back(least);
    const std::size_t before = home_of_further_cell_.size();
    for (int part = least + 1; part < most_nodes_at_a_place; ++part)
      if (std::any_of(own.begin(), own.end(), [&](int i) { return part_in_cell_[i] == part; })) {
        home_of_further_cell_.push_back(suspect_cells_[k]);
        part_of_further_cell_.push_back(static_cast<std::uint8_t>(part));
      }
    for (std::size_t further = before; further < home_of_further_cell_.size(); ++further)
      for (const int i : own)
        if (part_in_cell_[i] == part_of_further_cell_[further]) cell_of_particle_[i] = count + static_cast<int>(further);
  }
}

/// What this rank knows of the things around a place, whose parts have been joined as far as its own rows go.
template <int D>
void Multigrid<D>::note_links(std::int64_t place) {
  const int n = static_cast<int>(thing_.size());
  parts_.count_parts(n + 1);
  auto& first = place_;
  first.assign(static_cast<std::size_t>(n), -1);
  for (int a = 0; a < n; ++a) {
    int& of_part = first[static_cast<std::size_t>(parts_.number(a))];
    if (of_part < 0) of_part = a;
    sides_.link.push_back({place, thing_[static_cast<std::size_t>(a)], thing_[static_cast<std::size_t>(of_part)]});
  }
}

/// Takes down what is around the next suspect place of a level, when what belongs together there has been joined.
template <int D>
void Multigrid<D>::note_sides(const Level& level, int suspect, bool shared) {
  sides_.thing.insert(sides_.thing.end(), around_.begin(), around_.end());
  sides_.corner.insert(sides_.corner.end(), corner_of_.begin(), corner_of_.end());
  sides_.begin.push_back(sides_.thing.size());
  if (shared) {
    note_links(place_of_all(level, level.coordinate[suspect]));
    return;
  }
  parts_.count_parts(most_nodes_at_a_place);
  for (std::size_t a = 0; a < around_.size(); ++a) sides_.part.push_back(static_cast<std::uint8_t>(parts_.number(static_cast<int>(a))));
  sides_.count.push_back(static_cast<std::uint8_t>(parts_.count()));
}

template <int D>
void Multigrid<D>::clear_sides(Level& level) {
  level.further.clear();
  level.side.clear();
  sides_.begin.assign(1, 0);
  sides_.thing.clear();
  sides_.corner.clear();
  sides_.part.clear();
  sides_.count.clear();
  sides_.link.clear();
}

/// Appends a node for each part but the first at a suspect place. Calls assign(thing, corner, node) for what takes one of these.
template <int D>
template <class Assign>
void Multigrid<D>::give_nodes_to_parts(Level& level, bool shared, Assign&& assign) {
  if (shared) join_with_other_ranks(level);
  for (std::size_t k = 0; k < level.suspects.size(); ++k) {
    const int first = level.suspects[k], before = static_cast<int>(level.nodes()) - 1;
    const std::array<int, D> at = level.coordinate[first];
    for (int part = 1; part < sides_.count[k]; ++part) {
      level.side.resize(level.nodes(), 0);
      level.side.push_back(static_cast<std::uint8_t>(part));
      level.further.emplace_back(flat_index<D>(at, level.size), static_cast<int>(level.nodes()));
      level.coordinate.push_back(at);
      if (!level.foreign.empty()) level.foreign.push_back(level.foreign[first]);
    }
    for (std::size_t a = sides_.begin[k]; a < sides_.begin[k + 1]; ++a)
      if (sides_.part[a] > 0) assign(sides_.thing[a], sides_.corner[a], before + sides_.part[a]);
  }
}

/// Gives the cells around a place that are not connected with each other nodes of their own.
template <int D>
void Multigrid<D>::split_places(const std::array<int, D>& cells) {
  Level& level = levels_[0];
  clear_sides(level);
  level.suspects.clear();
  if (!parted_) return;
  for (int cell : suspect_cells_)
    for (int corner = 0; corner < corners; ++corner) level.suspects.push_back(cell_node_[compact_[cell]][corner]);
  sort_and_make_unique(level.suspects);
  if (level.divided) ask_which_are_suspect(level);

  const int grid_cells = count_places<D>(cells);
  auto& parts = parts_;
  auto &around = around_, &corner_of = corner_of_;
  const auto part_of = [&](int cell) {
    const auto found = std::lower_bound(suspect_cells_.begin(), suspect_cells_.end(), cell);
    return found != suspect_cells_.end() && *found == cell ? part_of_suspect_cell_[found - suspect_cells_.begin()] : 0;
  };
  for (int suspect : level.suspects) {
    around.clear();
    corner_of.clear();
    thing_.clear();
    for (int corner = 0; corner < corners; ++corner) {
      std::array<int, D> at = level.coordinate[suspect];
      for (int c = 0; c < D; ++c) at[c] -= (corner >> c) & 1;
      const int home = place_at<D>(at, cells, level.periodic);
      if (home < 0 || compact_[home] < 0) continue;
      const std::int64_t name = most_nodes_at_a_place * place_of_all(level, at);
      const auto add = [&](int cell, int part) {
        around.push_back(compact_[cell]);
        corner_of.push_back(corner);
        thing_.push_back(name + part);
      };
      add(home, part_of(home));
      const auto [first, last] = std::equal_range(home_of_further_cell_.begin(), home_of_further_cell_.end(), home);
      for (auto further = first; further != last; ++further) {
        const int k = static_cast<int>(further - home_of_further_cell_.begin());
        add(grid_cells + k, part_of_further_cell_[k]);
      }
    }
    parts.reset(static_cast<int>(around.size()));
    for (std::size_t a = 0; a < around.size(); ++a) {
      for (int entry = cell_start_[around[a]]; entry < cell_start_[around[a] + 1]; ++entry) {
        if (cell_particle_[entry] >= matrix_->rows()) continue;
        matrix_->for_edges(cell_particle_[entry], [&](int j, float) {
          if (cell_of_particle_[j] < 0) return;
          const int b = place_in(around, compact_[cell_of_particle_[j]]);
          if (b >= 0) parts.join(static_cast<int>(a), b);
        });
      }
      if (all_in_one(parts)) break;
    }
    note_sides(level, suspect, level.divided);
  }
  give_nodes_to_parts(level, level.divided, [&](int cell, int corner, int node) { cell_node_[cell][corner] = node; });
}

/// The same on a coarser level: what is connected are the finer nodes around a place.
template <int D>
void Multigrid<D>::split_coarse_places(Level& fine, Level& coarse, const std::array<bool, D>& halved) {
  clear_sides(coarse);
  if (!parted_) return;
  if (!fine.divided) {
    for (int node : fine.suspects)
      for (int parent : fine.parent[node])
        if (parent >= 0) coarse.suspects.push_back(parent);
    sort_and_make_unique(coarse.suspects);
  }

  auto& parts = parts_;
  auto &around = around_, &corner_of = corner_of_;
  for (int suspect : coarse.suspects) {
    around.clear();
    corner_of.clear();
    thing_.clear();
    for (int s = 0; s < stencil; ++s) {
      const auto offset = stencil_offset<D>(s);
      std::array<int, D> at = coarse.coordinate[suspect];
      int corner = 0;  // of the finer node's cell of parents at which this place is
      bool is_finer = true;
      for (int c = 0; c < D; ++c) {
        at[c] += coarse.first[c];
        if (halved[c]) at[c] = 2 * at[c] + offset[c];
        at[c] -= fine.first[c];
        corner |= (offset[c] < 0) << c;
        is_finer = is_finer && (halved[c] || offset[c] == 0);
      }
      if (!is_finer) continue;
      for_nodes_at(fine, at, [&](int node) {
        around.push_back(node);
        corner_of.push_back(corner);
        if (fine.divided) thing_.push_back(node_of_all(fine, node));
      });
    }
    parts.reset(static_cast<int>(around.size()));
    for (std::size_t a = 0; a < around.size(); ++a)
      if (fine.own(static_cast<std::size_t>(around[a])))
        for_entries(fine, around[a], [&](int other, float) {
          const int b = place_in(around, other);
          if (b >= 0) parts.join(static_cast<int>(a), b);
        });
    note_sides(coarse, suspect, fine.divided);
  }
  give_nodes_to_parts(coarse, fine.divided, [&](int node, int corner, int parent) { fine.parent[node][corner] = parent; });
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
  template void Multigrid<D>::split_cells(const std::vector<int>&, const std::array<int, D>&); \
  template void Multigrid<D>::split_places(const std::array<int, D>&);                         \
  template void Multigrid<D>::split_coarse_places(Level&, Level&, const std::array<bool, D>&); \
  template void Multigrid<D>::mark_by_split(Level&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
