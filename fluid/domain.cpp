#include "fluid/domain.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace tern::fluid {
namespace {

constexpr double tolerated_imbalance = 1.1;  ///< most over mean
constexpr int least_windows = 20;            ///< between two cuts: a particle passes three spacings at most

/// Appends a value to a record, or takes it from there.
template <class T>
void put(std::vector<std::byte>& record, const T& value) {
  const std::size_t size = record.size();
  record.resize(size + sizeof(T));
  std::memcpy(record.data() + size, &value, sizeof(T));
}
template <class T>
void take(const std::byte*& record, std::vector<T>& values) {
  T value;
  std::memcpy(static_cast<void*>(&value), record, sizeof(T));
  values.push_back(value);
  record += sizeof(T);
}

/// Calls visit(values) for each array with one value per particle between prediction and search.
template <int D, class Visit>
void for_each_moving_field(State<D>& state, Prediction<D>& prediction, Visit&& visit) {
  for_each_particle_field(state, [&](const char*, const char*, auto& values) { visit(values); });
  for (auto* values : {&prediction.position, &prediction.velocity, &prediction.gravity}) visit(*values);
}

}  // namespace

template <int D>
void Partition<D>::cut(const Ranks& ranks, const std::vector<Vector<D>>& position) {
  constexpr int bisections = 50;
  ranks_ = ranks.count();
  cuts_.assign(static_cast<std::size_t>(ranks_), {});
  struct Part {
    int first, last;
  };
  std::vector<Part> parts{{0, ranks_}};
  std::vector<int> part_of(position.size(), 0);
  while (std::any_of(parts.begin(), parts.end(), [](const Part& part) { return part.last - part.first > 1; })) {
    const std::size_t n = parts.size();
    std::vector<double> low(n * D, 1e300), high(n * D, -1e300), count(n, 0);
    for (std::size_t i = 0; i < position.size(); ++i) {
      ++count[part_of[i]];
      for (int c = 0; c < D; ++c) {
        double &least = low[part_of[i] * D + c], &most = high[part_of[i] * D + c];
        least = std::min(least, position[i][c]), most = std::max(most, position[i][c]);
      }
    }
    ranks.least(std::span(low));
    ranks.most(std::span(high));
    ranks.sum(std::span(count));
    std::vector<double> from(n), to(n), wanted(n);
    std::vector<int> axis(n, 0);
    for (std::size_t k = 0; k < n; ++k) {
      for (int c = 1; c < D; ++c)
        if (high[k * D + c] - low[k * D + c] > high[k * D + axis[k]] - low[k * D + axis[k]]) axis[k] = c;
      from[k] = low[k * D + axis[k]], to[k] = high[k * D + axis[k]];
      if (from[k] > to[k]) from[k] = to[k] = 0;  // nothing there
      const auto [first, last] = parts[k];
      wanted[k] = count[k] * ((first + last) / 2 - first) / (last - first);
    }
    std::vector<double> counted(n);
    for (int step = 0; step < bisections; ++step) {
      std::fill(counted.begin(), counted.end(), 0.0);
      for (std::size_t i = 0; i < position.size(); ++i) {
        const int k = part_of[i];
        counted[k] += position[i][axis[k]] < 0.5 * (from[k] + to[k]);
      }
      ranks.sum(std::span(counted));
      for (std::size_t k = 0; k < n; ++k) (counted[k] < wanted[k] ? from : to)[k] = 0.5 * (from[k] + to[k]);
    }
    std::vector<Part> halves;
    std::vector<int> lower(n);
    for (std::size_t k = 0; k < n; ++k) {
      lower[k] = static_cast<int>(halves.size());
      const auto [first, last] = parts[k];
      const int middle = (first + last) / 2;
      if (last - first == 1) {
        halves.push_back({first, last});
        continue;
      }
      cuts_[middle] = {axis[k], to[k]};
      halves.push_back({first, middle});
      halves.push_back({middle, last});
    }
    for (std::size_t i = 0; i < position.size(); ++i) {
      const int k = part_of[i];
      const auto [first, last] = parts[k];
      part_of[i] = lower[k] + (last - first > 1 && !below((first + last) / 2, position[i]) ? 1 : 0);
    }
    parts.swap(halves);
  }
}

template <int D>
void Partition<D>::write_cuts(Shares& shares) const {
  for (const Cut& cut : cuts_) {
    shares.cut_axis.push_back(cut.axis);
    shares.cut_place.push_back(cut.place);
  }
}

template <int D>
void Partition<D>::read_cuts(const Shares& shares) {
  ranks_ = static_cast<int>(shares.cut_axis.size());
  cuts_.clear();
  for (std::size_t m = 0; m < shares.cut_axis.size(); ++m) cuts_.push_back({static_cast<int>(shares.cut_axis[m]), shares.cut_place[m]});
}

// The row of a node of the grid of the multigrid, two spacings wide, holds what lies within its width.
template <int D>
Domain<D>::Domain(const Ranks& ranks, const Reference<D>& reference)
    : ranks_(ranks),
      period_(reference.period),
      spacing_(reference.constants.spacing),
      support_(reference.constants.kernel.support()),
      reach_(std::max(support_, 2.2 * spacing_)) {}

template <int D>
std::pair<std::size_t, std::size_t> Domain<D>::equal_share(std::size_t n) const {
  const std::size_t ranks = static_cast<std::size_t>(ranks_.count()), own = static_cast<std::size_t>(ranks_.own());
  return {n * own / ranks, n * (own + 1) / ranks};
}

template <int D>
void Domain<D>::cut_anew(State<D>& state) {
  if (alone()) return;
  windows_since_cut_ = 0;
  partition_.cut(ranks_, state.position);
  ++cuts_;
  Prediction<D> none;
  for (auto* values : {&none.position, &none.velocity, &none.gravity}) values->resize(state.size());
  move(state, none, state.position);
}

template <int D>
void Domain<D>::share_out(State<D>& state, const Shares& shares) {
  if (alone()) return;
  const std::size_t own = static_cast<std::size_t>(ranks_.own());
  const bool known = shares.particles.size() == static_cast<std::size_t>(ranks_.count());
  auto [first, last] = equal_share(state.size());
  if (known) {
    first = static_cast<std::size_t>(std::accumulate(shares.particles.begin(), shares.particles.begin() + ranks_.own(), std::int64_t{0}));
    last = first + static_cast<std::size_t>(shares.particles[own]);
  }
  for_each_particle_field(state, [&](const char*, const char*, auto& values) {
    values = std::remove_reference_t<decltype(values)>(values.begin() + static_cast<std::ptrdiff_t>(first),
                                                       values.begin() + static_cast<std::ptrdiff_t>(last));
  });
  if (!ranks_.first()) {
    state.potential = 0;
    state.removed = state.leaked = 0;
    state.evaluations = {};
  }
  if (!known) return cut_anew(state);
  windows_since_cut_ = static_cast<int>(shares.windows_since_cut);
  state.potential = shares.potential[own];
  partition_.read_cuts(shares);
  ++cuts_;
}

template <int D>
Shares Domain<D>::shares(const State<D>& own) const {
  Shares shares;
  shares.particles = ranks_.gather(std::vector<std::int64_t>{static_cast<std::int64_t>(own.size())});
  shares.potential = ranks_.gather(std::vector<double>{own.potential});
  partition_.write_cuts(shares);
  shares.windows_since_cut = windows_since_cut_;
  return shares;
}

template <int D>
void Domain<D>::migrate(State<D>& state, Prediction<D>& prediction) {
  if (alone()) return;
  if (++windows_since_cut_ >= least_windows && imbalance_ > tolerated_imbalance) {
    partition_.cut(ranks_, prediction.position);
    ++cuts_;
    windows_since_cut_ = 0;
  }
  move(state, prediction, prediction.position);
}

template <int D>
void Domain<D>::move(State<D>& state, Prediction<D>& prediction, const std::vector<Vector<D>>& position) {
  const std::size_t n = state.size();
  std::vector<std::vector<std::byte>> to(static_cast<std::size_t>(ranks_.count())), from;
  std::vector<std::uint8_t> leaves(n);
  for (std::size_t i = 0; i < n; ++i) {
    const int owner = partition_.owner(position[i]);
    leaves[i] = owner != ranks_.own();
    if (leaves[i]) for_each_moving_field(state, prediction, [&](auto& values) { put(to[owner], values[i]); });
  }
  for_each_moving_field(state, prediction, [&](auto& values) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n; ++i)
      if (!leaves[i]) values[kept++] = values[i];
    values.resize(kept);
  });
  ranks_.deal(to, from, Subject::particles);
  for (const auto& records : from)
    for (const std::byte *record = records.data(), *end = record + records.size(); record < end;)
      for_each_moving_field(state, prediction, [&](auto& values) { take(record, values); });
}

template <int D>
void Domain<D>::find_ghosts(State<D>& state, Prediction<D>& prediction, RowOrder<D>& rows) {
  if (alone()) return;
  const std::size_t n = state.size();
  std::vector<std::vector<int>> give(static_cast<std::size_t>(ranks_.count())), take_places(give.size());
  struct Copy {
    Vector<D> position, velocity;
    double pressure;
  };
  std::vector<std::vector<Copy>> copies(give.size()), others;
  const auto offer = [&](std::size_t i, const Vector<D>& image) {
    partition_.for_owners_around(image, reach_, [&](int rank) {
      // Ranks see the images of what they have by themselves.
      if (rank == ranks_.own() || (!give[rank].empty() && give[rank].back() == static_cast<int>(i))) return;
      give[rank].push_back(static_cast<int>(i));
      copies[rank].push_back({prediction.position[i], state.velocity[i], state.pressure[i]});
    });
  };
  Vector<D> low, high;
  for (int c = 0; c < D; ++c) low[c] = period_.begin(c), high[c] = period_.begin(c) + period_.length(c);
  for (std::size_t i = 0; i < n; ++i) {
    const Vector<D>& x = prediction.position[i];
    offer(i, x);
    if (period_.any()) for_images(period_, x, low, high, reach_, [&](const Vector<D>& shift) { offer(i, x + shift); });
  }
  ranks_.deal(copies, others, Subject::particles);
  std::vector<Vector<D>> unsorted;
  for (const auto& some : others)
    for (const Copy& copy : some) unsorted.push_back(copy.position);
  ghosts_ = unsorted.size();
  Vector<D> lowest = Vector<D>::Constant(1e300), highest = -lowest;
  for (const auto& x : unsorted) lowest = lowest.cwiseMin(x), highest = highest.cwiseMax(x);
  if (unsorted.empty()) lowest = highest = Vector<D>::Zero();
  rows.ghost_grid.reset(lowest, highest, support_, row_width(D) * spacing_);
  fill_rows(
      rows.ghost_grid, unsorted, [](int a, int b) { return a < b; }, rows.ghosts);
  prediction.position.resize(n + ghosts_);
  std::vector<int> slot(ghosts_);
  for (std::size_t k = 0; k < ghosts_; ++k) {
    slot[rows.ghosts.order[k]] = static_cast<int>(n + k);
    prediction.position[n + k] = unsorted[rows.ghosts.order[k]];
  }
  prediction.velocity.resize(n + ghosts_);
  state.velocity.resize(n + ghosts_);
  state.pressure.resize(n + ghosts_);
  state.particle_class.resize(n + ghosts_);
  std::size_t next = 0;
  for (std::size_t r = 0; r < others.size(); ++r)
    for (const Copy& copy : others[r]) {
      const int place = slot[next++];
      take_places[r].push_back(place);
      state.velocity[place] = copy.velocity;
      state.pressure[place] = copy.pressure;
    }
  particles_.reset(ranks_, Subject::particles, give, take_places);
}

template <int D>
void Domain<D>::forget_ghosts(State<D>& state) {
  if (alone()) return;
  for_each_particle_field(state, [n = state.size()](const char*, const char*, auto& values) { values.resize(n); });
}

template <int D>
void Domain<D>::exchange_marks(std::vector<ParticleClass>& particle_class) const {
  if (alone()) return;
  particles_.collect(particle_class, [](ParticleClass& own, ParticleClass other) { own.marks() |= other.marks(); });
  particles_.update(particle_class);
}

template <int D>
State<D> Domain<D>::gather(const State<D>& own) const {
  State<D> all = own;
  if (alone()) return all;
  for_each_particle_field(all, [&](const char*, const char*, auto& values) { values = ranks_.gather(values); });
  return all;
}

template class Partition<2>;
template class Partition<3>;
template class Domain<2>;
template class Domain<3>;

}  // namespace tern::fluid
