// How several ranks divide the grids of the multigrid among them.

#include <algorithm>

#include "fluid/pressure/grid_stencil.hpp"
#include "fluid/pressure/multigrid.hpp"

namespace tern::fluid {
namespace {

/// answers[r] goes to rank r, what rank r answers comes into got[r], which has its size.
void exchange_answers(const Ranks& ranks, std::vector<std::vector<std::uint8_t>>& answers, std::vector<std::vector<std::uint8_t>>& got) {
  std::vector<RankMessage> give, take;
  for (std::size_t r = 0; r < answers.size(); ++r) {
    const int rank = static_cast<int>(r);
    if (!answers[r].empty()) give.push_back({rank, answers[r].data(), answers[r].size()});
    if (!got[r].empty()) take.push_back({rank, got[r].data(), got[r].size()});
  }
  ranks.exchange(give, take, Subject::nodes);
}

}  // namespace

template <int D>
int Multigrid<D>::owner(const Level& level, const std::array<int, D>& at) const {
  Vector<D> x;
  for (int c = 0; c < D; ++c) x[c] = origin_[c] + at[c] * level.width[c];
  return domain_->owner(x + period_.into(x));
}

/// Which nodes of the finest level are of other ranks; these know them as well.
template <int D>
void Multigrid<D>::find_owners(Level& level) {
  level.foreign.clear();
  if (!level.divided) return;
  const Ranks& ranks = domain_->ranks();
  level.foreign.resize(level.nodes());
  auto &take = take_, &give = give_;
  take.assign(static_cast<std::size_t>(ranks.count()), {});
  give.assign(take.size(), {});
  std::vector<std::vector<std::array<int, D>>> wanted(take.size()), asked;
  for (std::size_t node = 0; node < level.nodes(); ++node) {
    std::array<int, D> at = level.coordinate[node];
    for (int c = 0; c < D; ++c) at[c] += level.first[c];
    const int of = owner(level, at);
    level.foreign[node] = of != ranks.own();
    if (!level.foreign[node]) continue;
    take[of].push_back(static_cast<int>(node));
    wanted[of].push_back(at);
  }
  ranks.deal(wanted, asked, Subject::nodes);
  for (std::size_t r = 0; r < asked.size(); ++r)
    for (std::array<int, D> at : asked[r]) {
      for (int c = 0; c < D; ++c) at[c] -= level.first[c];
      give[r].push_back(node_at(level, at));
    }
}

/// Of the finest level: whether a place may have two sides is known to its owner, which sees all that is around it.
template <int D>
void Multigrid<D>::ask_which_are_suspect(Level& level) const {
  std::vector<std::uint8_t> suspect(level.nodes(), 0);
  for (const int node : level.suspects) suspect[node] = 1;
  Halo first_nodes;
  first_nodes.reset(domain_->ranks(), Subject::nodes, give_, take_);
  first_nodes.update(suspect);
  level.suspects.clear();
  for (std::size_t node = 0; node < suspect.size(); ++node)
    if (suspect[node]) level.suspects.push_back(static_cast<int>(node));
}

/// Whoever has copies of the nodes of a place has all of them.
template <int D>
void Multigrid<D>::finish_copies(Level& level) {
  if (!level.divided) return;
  if (!level.further.empty()) {
    std::vector<int> all;
    for (auto* by_rank : {&take_, &give_})
      for (auto& nodes : *by_rank) {
        all.clear();
        for (const int first : nodes) for_nodes_at(level, level.coordinate[first], [&](int node) { all.push_back(node); });
        nodes = all;
      }
  }
  level.copies.reset(domain_->ranks(), Subject::nodes, give_, take_);
}

template <int D>
std::int64_t Multigrid<D>::place_of_all(const Level& level, std::array<int, D> at) {
  std::int64_t place = 0;
  for (int c = D - 1; c >= 0; --c) place = place * level.whole[c] + wrapped(at[c] + level.first[c], level.whole[c], level.periodic[c]);
  return place;
}

template <int D>
std::int64_t Multigrid<D>::node_of_all(const Level& level, int node) {
  return most_nodes_at_a_place * place_of_all(level, level.coordinate[node]) + (level.side.empty() ? 0 : level.side[node]);
}

template <int D>
std::array<int, D> Multigrid<D>::at_place_of_all(const Level& level, std::int64_t place) {
  std::array<int, D> at;
  for (int c = 0; c < D; place /= level.whole[c++]) at[c] = static_cast<int>(place % level.whole[c]);
  return at;
}

/// Of a node that this rank has.
template <int D>
int Multigrid<D>::node_from_all(const Level& level, std::int64_t node) {
  std::array<int, D> at = at_place_of_all(level, node / most_nodes_at_a_place);
  for (int c = 0; c < D; ++c) at[c] -= level.first[c];
  std::int64_t before = node % most_nodes_at_a_place;
  int found = -1;
  for_nodes_at(level, at, [&](int other) {
    if (before-- == 0) found = other;
  });
  return found;
}

/// A name for every particle and ghost, and whether it is beside a body that may part the fluid.
template <int D>
void Multigrid<D>::tell_ghosts_beside_body(const std::vector<int>& beside_body) {
  const std::size_t all = cell_of_particle_.size();
  name_.assign(all, 0);
  beside_.assign(all, 0);
  for (int i = 0; i < matrix_->rows(); ++i) name_[i] = (std::int64_t{domain_->ranks().own()} << 32) + i;
  for (const int i : beside_body) beside_[i] = 1;
  domain_->particles().update(name_, beside_);
}

/// Parts of the suspect cells, from what all ranks know of them: of own particles, then of ghosts.
template <int D>
void Multigrid<D>::share_parts_of_cells() {
  join_at_owners(levels_[0], {});
  for (std::size_t k = 0; k < sides_.link.size(); ++k) {
    const std::int64_t name = sides_.link[k].thing;
    if (name >> 32 == domain_->ranks().own()) part_in_cell_[name & 0xffffffff] = sides_.part[k];
  }
  sides_.part.clear();
  domain_->particles().update(part_in_cell_);
}

/// Takes what this rank knows of things around places to the owners of these, which join what all know. The part of each thing comes back.
/// `counted`: first nodes of each rank whose number of parts comes with it, into sides_.count_of, in the order of take_.
template <int D>
void Multigrid<D>::join_at_owners(const Level& level, const std::vector<std::uint8_t>& counted) {
  const Ranks& ranks = domain_->ranks();
  const auto count = static_cast<std::size_t>(ranks.count());
  std::vector<std::vector<Link>> links(count), told;
  std::vector<int> owner_of_link;
  for (const Link& link : sides_.link) {
    owner_of_link.push_back(owner(level, at_place_of_all(level, link.place)));
    links[owner_of_link.back()].push_back(link);
  }
  ranks.deal(links, told, Subject::nodes);
  std::vector<Link> all;
  for (const auto& some : told) all.insert(all.end(), some.begin(), some.end());
  joined_.join(all, most_nodes_at_a_place);

  std::vector<std::vector<std::uint8_t>> answers(count), got(count);
  const auto for_counted = [&](const std::vector<std::vector<int>>& first_nodes, std::size_t r, auto&& visit) {
    if (counted.empty()) return;
    for (const int node : first_nodes[r])
      if (counted[node]) visit(node);
  };
  for (std::size_t r = 0; r < count; ++r) {
    for (const Link& link : told[r]) answers[r].push_back(static_cast<std::uint8_t>(joined_.part(link.place, link.thing)));
    for_counted(give_, r, [&](int node) {
      answers[r].push_back(static_cast<std::uint8_t>(joined_.count(place_of_all(level, level.coordinate[node]))));
    });
    std::size_t size = links[r].size();
    for_counted(take_, r, [&](int) { ++size; });
    got[r].resize(size);
  }
  exchange_answers(ranks, answers, got);
  std::vector<std::size_t> next(count, 0);
  sides_.part.clear();
  for (const int r : owner_of_link) sides_.part.push_back(got[r][next[r]++]);
  sides_.count_of.assign(counted.size(), 1);
  for (std::size_t r = 0; r < count; ++r) for_counted(take_, r, [&](int node) { sides_.count_of[node] = got[r][next[r]++]; });
}

/// The parts at the suspect places of a level, from what all ranks know of them.
template <int D>
void Multigrid<D>::join_with_other_ranks(const Level& level) {
  const auto parts_at = [&](int node) { return static_cast<std::uint8_t>(joined_.count(place_of_all(level, level.coordinate[node]))); };
  if (level.divided) {
    std::vector<std::uint8_t> suspect(level.nodes(), 0);
    for (const int node : level.suspects) suspect[node] = 1;
    join_at_owners(level, suspect);
    for (const int node : level.suspects)
      sides_.count.push_back(level.own(static_cast<std::size_t>(node)) ? parts_at(node) : sides_.count_of[node]);
  } else {
    std::vector<Link> all = sides_.link;
    domain_->ranks().gather_on_all(all);
    joined_.join(all, most_nodes_at_a_place);
    for (const Link& link : sides_.link) sides_.part.push_back(static_cast<std::uint8_t>(joined_.part(link.place, link.thing)));
    for (const int node : level.suspects) sides_.count.push_back(parts_at(node));
  }
}

/// Which rows have columns beyond the stencil is known to their owners, which know all places beside them.
template <int D>
void Multigrid<D>::share_by_split(Level& level) const {
  if (!parted_ || !level.divided) return;
  level.by_split.resize(level.nodes(), 0);
  level.copies.update(level.by_split);
  if (std::none_of(level.by_split.begin(), level.by_split.end(), [](std::uint8_t by) { return by != 0; })) level.by_split.clear();
}

/// Adds to rows of this rank, or of all ranks where the level is not divided, what others have for those with columns beyond the stencil.
template <int D>
void Multigrid<D>::share_entries(Level& level) {
  if (!parted_) return;
  const Ranks& ranks = domain_->ranks();
  auto& entries = far_entries_;
  add_up(entries);
  if (level.divided) {
    std::vector<std::vector<FarEntry>> to(static_cast<std::size_t>(ranks.count())), from;
    for (const FarEntry& entry : entries) to[owner(level, at_place_of_all(level, entry.row / most_nodes_at_a_place))].push_back(entry);
    ranks.deal(to, from, Subject::nodes);
    entries.clear();
    for (const auto& some : from) entries.insert(entries.end(), some.begin(), some.end());
  } else {
    ranks.gather_on_all(entries);
  }
  for (const FarEntry& entry : entries) {
    const int row = node_from_all(level, entry.row), column = node_from_all(level, entry.column);
    add_entry(level, row, step_between<D>(level.coordinate[row], level.coordinate[column], level.size), column, entry.value);
  }
}

/// Gives a divided level its nodes: the places `marked` by any rank, of which this one keeps its own, those it has marked, and those beside
/// its own. Places are those of all ranks.
template <int D>
void Multigrid<D>::share_places(Level& level, const std::vector<Mark>& marked) {
  using Place = std::array<int, D>;
  const Ranks& ranks = domain_->ranks();
  const auto count = static_cast<std::size_t>(ranks.count());
  constexpr int absent = -1, present = 0, suspect = 1, in_question = 2;
  const auto set_box = [&](Place low, Place high) {
    for (int c = 0; c < D; ++c) {
      level.first[c] = level.periodic[c] ? 0 : std::max(0, low[c] - 1) & ~1;
      level.size[c] = level.periodic[c] ? level.whole[c] : std::max(1, std::min(level.whole[c] - 1, high[c] + 1) - level.first[c] + 1);
    }
    level.map.assign(count_places<D>(level.size), absent);
  };
  const auto within = [&](const Place& at) {
    Place own = at;
    for (int c = 0; c < D; ++c) own[c] -= level.first[c];
    return place_at<D>(own, level.size, level.periodic);
  };
  const auto at_place = [&](int place) {
    Place at = coordinate_of<D>(place, level.size);
    for (int c = 0; c < D; ++c) at[c] += level.first[c];
    return at;
  };
  Place low, high;
  low.fill(0), high.fill(0);
  if (!marked.empty()) low = high = marked[0].at;
  const auto widen = [&](const Place& at) {
    for (int c = 0; c < D; ++c) low[c] = std::min(low[c], at[c]), high[c] = std::max(high[c], at[c]);
  };
  for (const Mark& mark : marked) widen(mark.at);
  set_box(low, high);
  const auto put = [&](const Mark& mark) {
    int& here = level.map[within(mark.at)];
    here = std::max(here, mark.suspect ? suspect : present);
  };
  for (const Mark& mark : marked) put(mark);

  // Owners learn of what others have marked.
  std::vector<std::vector<Mark>> wanted(count), asked;
  std::vector<Mark> own;
  for (int place = 0; place < static_cast<int>(level.map.size()); ++place) {
    if (level.map[place] == absent) continue;
    const Place at = at_place(place);
    const int of = owner(level, at);
    (of == ranks.own() ? own : wanted[of]).push_back({at, level.map[place] == suspect});
  }
  ranks.deal(wanted, asked, Subject::nodes);
  for (const auto& places : asked) {
    own.insert(own.end(), places.begin(), places.end());
    if (marked.empty() && own.size() == places.size() && !places.empty()) low = high = places[0].at;
    for (const Mark& mark : places) widen(mark.at);
  }
  set_box(low, high);
  for (const auto& places : wanted)
    for (const Mark& mark : places) put(mark);
  for (const Mark& mark : own) put(mark);

  // Everyone asks the owners for what it has marked, and for what may be beside its own.
  for (const Mark& mark : own)
    for (int s = 0; s < stencil; ++s) {
      Place beside = stencil_offset<D>(s);
      for (int c = 0; c < D; ++c) beside[c] += mark.at[c];
      if (const int place = within(beside); place >= 0 && level.map[place] == absent) level.map[place] = in_question;
    }
  for (auto& places : wanted) places.clear();
  for (int place = 0; place < static_cast<int>(level.map.size()); ++place) {
    if (level.map[place] == absent) continue;
    const Place at = at_place(place);
    const int of = owner(level, at);
    if (of != ranks.own())
      wanted[of].push_back({at, 0});
    else if (level.map[place] == in_question)
      level.map[place] = absent;
  }
  ranks.deal(wanted, asked, Subject::nodes);
  std::vector<std::vector<std::uint8_t>> is_there(count), answers(count);
  for (std::size_t r = 0; r < count; ++r) {
    for (const Mark& mark : asked[r]) {
      const int place = within(mark.at);
      answers[r].push_back(static_cast<std::uint8_t>(place < 0 ? 0 : level.map[place] + 1));
    }
    is_there[r].resize(wanted[r].size());
  }
  exchange_answers(ranks, answers, is_there);
  for (std::size_t r = 0; r < count; ++r)
    for (std::size_t k = 0; k < wanted[r].size(); ++k) level.map[within(wanted[r][k].at)] = is_there[r][k] - 1;

  number_suspect_places(level);
  level.foreign.assign(level.nodes(), 0);
  auto &take = take_, &give = give_;
  take.assign(count, {});
  give.assign(count, {});
  for (std::size_t r = 0; r < count; ++r) {
    for (std::size_t k = 0; k < wanted[r].size(); ++k) {
      if (!is_there[r][k]) continue;
      take[r].push_back(level.map[within(wanted[r][k].at)]);
      level.foreign[take[r].back()] = 1;
    }
    for (std::size_t k = 0; k < asked[r].size(); ++k)
      if (answers[r][k]) give[r].push_back(level.map[within(asked[r][k].at)]);
  }
}

/// number_places() where a place that is marked with more than 0 may have two sides.
template <int D>
void Multigrid<D>::number_suspect_places(Level& level) {
  std::vector<int> places;
  for (int place = 0; place < static_cast<int>(level.map.size()); ++place)
    if (level.map[place] > 0) places.push_back(place);
  number_places(level);
  for (const int place : places) level.suspects.push_back(level.map[place]);
}

/// The places of a level that is not divided, from those that each rank has marked.
template <int D>
void Multigrid<D>::mark_on_all_ranks(Level& level, const std::vector<Mark>& marked) {
  std::vector<std::uint8_t> sides(level.map.size(), 0);
  for (const Mark& mark : marked) {
    std::uint8_t& here = sides[flat_index<D>(mark.at, level.size)];
    here = std::max<std::uint8_t>(here, mark.suspect ? 2 : 1);
  }
  domain_->ranks().most(std::span(sides));
  for (std::size_t place = 0; place < sides.size(); ++place) level.map[place] = sides[place] - 1;
  number_suspect_places(level);
}

#define TERN_INSTANTIATE(D)                                                           \
  template int Multigrid<D>::owner(const Level&, const std::array<int, D>&) const;    \
  template void Multigrid<D>::find_owners(Level&);                                    \
  template void Multigrid<D>::share_places(Level&, const std::vector<Mark>&);         \
  template void Multigrid<D>::mark_on_all_ranks(Level&, const std::vector<Mark>&);    \
  template void Multigrid<D>::ask_which_are_suspect(Level&) const;                    \
  template void Multigrid<D>::finish_copies(Level&);                                  \
  template void Multigrid<D>::tell_ghosts_beside_body(const std::vector<int>&);       \
  template void Multigrid<D>::share_parts_of_cells();                                 \
  template void Multigrid<D>::join_with_other_ranks(const Level&);                    \
  template void Multigrid<D>::share_by_split(Level&) const;                           \
  template void Multigrid<D>::share_entries(Level&);                                  \
  template std::int64_t Multigrid<D>::place_of_all(const Level&, std::array<int, D>); \
  template std::int64_t Multigrid<D>::node_of_all(const Level&, int);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
