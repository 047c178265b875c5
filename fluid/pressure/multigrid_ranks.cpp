// How several ranks divide the grids of the multigrid among them.

#include <algorithm>

#include "fluid/pressure/grid_stencil.hpp"
#include "fluid/pressure/multigrid.hpp"

namespace tern::fluid {

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
  std::vector<std::vector<int>> take(static_cast<std::size_t>(ranks.count())), give(take.size());
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
  level.copies.reset(ranks, Subject::nodes, give, take);
}

/// Gives a divided level its nodes: the places `marked` by any rank, of which this one keeps its own, those it has marked, and those beside
/// its own. Places are those of all ranks.
template <int D>
void Multigrid<D>::share_places(Level& level, const std::vector<std::array<int, D>>& marked) {
  using Place = std::array<int, D>;
  const Ranks& ranks = domain_->ranks();
  const auto count = static_cast<std::size_t>(ranks.count());
  constexpr int absent = -1, present = 0, in_question = 1;
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
  if (!marked.empty()) low = high = marked[0];
  const auto widen = [&](const Place& at) {
    for (int c = 0; c < D; ++c) low[c] = std::min(low[c], at[c]), high[c] = std::max(high[c], at[c]);
  };
  for (const Place& at : marked) widen(at);
  set_box(low, high);
  for (const Place& at : marked) level.map[within(at)] = present;

  // Owners learn of what others have marked.
  std::vector<std::vector<Place>> wanted(count), asked;
  std::vector<Place> own;
  for (int place = 0; place < static_cast<int>(level.map.size()); ++place) {
    if (level.map[place] == absent) continue;
    const Place at = at_place(place);
    const int of = owner(level, at);
    of == ranks.own() ? own.push_back(at) : wanted[of].push_back(at);
  }
  ranks.deal(wanted, asked, Subject::nodes);
  for (const auto& places : asked) {
    own.insert(own.end(), places.begin(), places.end());
    if (marked.empty() && own.size() == places.size() && !places.empty()) low = high = places[0];
    for (const Place& at : places) widen(at);
  }
  set_box(low, high);
  for (const auto& places : wanted)
    for (const Place& at : places) level.map[within(at)] = present;
  for (const Place& at : own) level.map[within(at)] = present;

  // Everyone asks the owners for what it has marked, and for what may be beside its own.
  for (const Place& at : own)
    for (int s = 0; s < stencil; ++s) {
      Place beside = stencil_offset<D>(s);
      for (int c = 0; c < D; ++c) beside[c] += at[c];
      if (const int place = within(beside); place >= 0 && level.map[place] == absent) level.map[place] = in_question;
    }
  for (auto& places : wanted) places.clear();
  for (int place = 0; place < static_cast<int>(level.map.size()); ++place) {
    if (level.map[place] == absent) continue;
    const Place at = at_place(place);
    const int of = owner(level, at);
    if (of != ranks.own())
      wanted[of].push_back(at);
    else if (level.map[place] == in_question)
      level.map[place] = absent;
  }
  ranks.deal(wanted, asked, Subject::nodes);
  std::vector<std::vector<std::uint8_t>> is_there(count), answers(count);
  std::vector<RankMessage> give_answers, take_answers;
  for (std::size_t r = 0; r < count; ++r) {
    const int rank = static_cast<int>(r);
    for (const Place& at : asked[r]) {
      const int place = within(at);
      answers[r].push_back(place >= 0 && level.map[place] == present);
    }
    is_there[r].resize(wanted[r].size());
    if (!answers[r].empty()) give_answers.push_back({rank, answers[r].data(), answers[r].size()});
    if (!is_there[r].empty()) take_answers.push_back({rank, is_there[r].data(), is_there[r].size()});
  }
  ranks.exchange(give_answers, take_answers, Subject::nodes);
  for (std::size_t r = 0; r < count; ++r)
    for (std::size_t k = 0; k < wanted[r].size(); ++k) level.map[within(wanted[r][k])] = is_there[r][k] ? present : absent;

  number_places(level);
  level.foreign.assign(level.nodes(), 0);
  std::vector<std::vector<int>> give(count), take(count);
  for (std::size_t r = 0; r < count; ++r) {
    for (std::size_t k = 0; k < wanted[r].size(); ++k) {
      if (!is_there[r][k]) continue;
      take[r].push_back(level.map[within(wanted[r][k])]);
      level.foreign[take[r].back()] = 1;
    }
    for (std::size_t k = 0; k < asked[r].size(); ++k)
      if (answers[r][k]) give[r].push_back(level.map[within(asked[r][k])]);
  }
  level.copies.reset(ranks, Subject::nodes, give, take);
}

/// The places of a level that is not divided, from those that each rank has marked.
template <int D>
void Multigrid<D>::mark_on_all_ranks(Level& level) const {
  std::vector<std::uint8_t> marked(level.map.size());
  for (std::size_t place = 0; place < marked.size(); ++place) marked[place] = level.map[place] == 0;
  domain_->ranks().most(std::span(marked));
  for (std::size_t place = 0; place < marked.size(); ++place) level.map[place] = marked[place] ? 0 : -1;
}

#define TERN_INSTANTIATE(D)                                                                 \
  template int Multigrid<D>::owner(const Level&, const std::array<int, D>&) const;          \
  template void Multigrid<D>::find_owners(Level&);                                          \
  template void Multigrid<D>::share_places(Level&, const std::vector<std::array<int, D>>&); \
  template void Multigrid<D>::mark_on_all_ranks(Level&) const;
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
