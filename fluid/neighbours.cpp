#include "fluid/neighbours.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <omp.h>

#include "base/parallel.hpp"
#include "sph/near_points.hpp"

namespace tern::fluid {
namespace {

/// Entries of a row on average, for which there is room at first; denser clumps make the arrays grow.
constexpr int initial_row_length(int dimension) { return dimension == 2 ? 60 : 240; }

/// What the sums over a row need of the kernel, with q = r/h, s = (1 - q/2)_+: w = w(0) s^4 (2 q + 1), |w'|/r is in proportion to s^3.
template <int D>
struct RowKernel {
  explicit RowKernel(const Constants<D>& constants)
      : inverse_h2(1 / (constants.kernel.smoothing_length() * constants.kernel.smoothing_length())),
        value(constants.kernel.value(0) * constants.volume),
        gradient(static_cast<float>(constants.kernel.gradient_weight(0) * constants.volume / constants.lattice.gradient_moment)),
        over_lattice(static_cast<float>(constants.kernel.value(0) / constants.kernel.value(constants.spacing))) {}

  double inverse_h2, value;
  float gradient, over_lattice;
};

/// Sums row i over its groups and writes its weights. Bit m of scratch.lanes_of[g]: entry m of group g belongs to the row.
/// Distances are in double precision. What the kernel makes of them is in single, eight at a time, for it becomes weights in single. The
/// sums follow in a loop of their own: what waits for a root would hold them up.
template <bool periodic, int D>
void sum_row(const RowKernel<D>& kernel, const LanePeriod<periodic, D>& period, int i, RowScratch& scratch, Neighbours<D>& result) {
  const int groups = result.length[i] / lanes;
  const int* const first = result.first.data() + result.begin[i] / lanes;
  const int* const lanes_of = scratch.lanes_of.data();
  float *const weight = result.weight.data() + result.begin[i], *const ordering = scratch.ordering.data();
  std::array<const double*, D> position;
  std::array<double, D> x;
  for (int c = 0; c < D; ++c) position[c] = result.position[c].data(), x[c] = position[c][i];
  const auto to_group = [&](int g, std::array<Four, D>& r) __attribute__((always_inline)) {
    for (int c = 0; c < D; ++c) r[c] = period.between(x[c], position[c] + first[g], c);
  };
  const auto squared = [&](int g) __attribute__((always_inline)) {
    std::array<Four, D> r;
    to_group(g, r);
    Four r2 = r[0] * r[0];
    for (int c = 1; c < D; ++c) r2 += r[c] * r[c];
    return kernel.inverse_h2 * r2;
  };

  // Of neighbours at the end of the kernel, where those of a lattice are, the fourth power would be too small for a normal number of single
  // precision. A processor takes a hundred times as long for what is not normal.
  constexpr float least_ratio = 1e-8f;
  Four density{};
  int count = 0;
  for (int g = 0; g < groups; g += 2) {
    const bool pair = g + 1 < groups;
    const Eight q = square_root(to_single(squared(g), squared(pair ? g + 1 : g))), inside = 1 - 0.5f * q;
    const Eight s = inside > 0 ? inside : Eight{};
    const Eight s3 = keep_lanes(s * s * s, lanes_of[g], pair ? lanes_of[g + 1] : 0);
    const Eight w = s3 * s * (2 * q + 1), a = kernel.gradient * s3;
    const Eight over = kernel.over_lattice * w, ratio = over > least_ratio ? over : Eight{} + least_ratio, ratio2 = ratio * ratio;
    const Eight with_order = a + 0.2f * a * (ratio2 * ratio2);
    if (pair)
      std::memcpy(weight + g * lanes, &a, sizeof a);
    else
      std::memcpy(weight + g * lanes, &a, sizeof a / 2);
    std::memcpy(ordering + g * lanes, &with_order, sizeof with_order);
    count += positive(a);
    density += low_half(w) + high_half(w);
  }
  result.number_density[i] = kernel.value * (1 + sum(density));
  result.count[i] = count;

  std::array<Four, D> gradient{}, concentration{}, moment{};
  std::array<Four, D*(D - 1) / 2> mixed_moment{};
  for (int g = 0; g < groups; ++g) {
    std::array<Four, D> r, part;
    to_group(g, r);
    const Four a = load(weight + g * lanes), with_order = load(ordering + g * lanes);
    for (int b = 0; b < D; ++b) {
      part[b] = a * r[b];
      gradient[b] += part[b];
      concentration[b] += with_order * r[b];
      moment[b] += part[b] * r[b];
    }
    for_axis_pairs<D>([&](int b, int c, int place) __attribute__((always_inline)) { mixed_moment[place] += part[b] * r[c]; });
  }
  for (int b = 0; b < D; ++b) {
    result.kernel_gradient[i][b] = sum(gradient[b]);
    result.concentration_gradient[i][b] = sum(concentration[b]);
    result.moment[i](b, b) = sum(moment[b]);
  }
  for_axis_pairs<D>([&](int b, int c, int place) { result.moment[i](b, c) = result.moment[i](c, b) = sum(mixed_moment[place]); });
}

/// The groups of a row while it is found, and which of their lanes belong to it.
template <int D>
struct RowBuilder {
  const Period<D>& period;
  const ByAxis<D>& position;
  int particles;
  int* lanes_of;
  int i = 0;
  int* group = nullptr;
  int groups = 0;

  void begin_row(int particle, int* first_group) {
    i = particle;
    group = first_group;
    groups = 0;
  }

  /// Says which lanes of the groups from number `from` on belong to the row, of particles before `end` that were found side by side.
  /// `shift`: in whole periods, to the place where they were found.
  template <bool periodic>
  [[gnu::always_inline]] void close(int from, int end, const std::array<double, D>& shift) {
    for (int g = from; g < groups; ++g) lanes_of[g] = 0xf;
    if (groups > from) {  // the last one may reach beyond the end, of these and of all
      const int begin = group[groups - 1], first = std::min(begin, particles - lanes);
      group[groups - 1] = first;
      lanes_of[groups - 1] = (0xf << (begin - first)) & ((1 << std::min(end - first, lanes)) - 1);
    }
    if constexpr (periodic)  // of the images of j only the nearest
      for (int g = from; g < groups; ++g)
        for (int lane = 0; lane < lanes; ++lane) {
          const int j = group[g] + lane;
          bool here = j != i;
          for (int c = 0; c < D; ++c) here = here && std::nearbyint((position[c][j] - position[c][i]) * inverse_length(c)) == shift[c];
          if (!here) lanes_of[g] &= ~(1 << lane);
        }
  }

  /// Takes the particle itself out of its groups from number `from` on.
  void leave_out_itself(int from) {
    for (int g = from; g < groups; ++g)
      if (const int lane = i - group[g]; lane >= 0 && lane < lanes) lanes_of[g] &= ~(1 << lane);
  }

 private:
  double inverse_length(int c) const { return period.repeats(c) ? 1 / period.length(c) : 0; }
};

/// Adds the groups that hold all points first .. last - 1 nearer to x + shift than the square root of limit2. May write one group more.
template <bool periodic, int D>
[[gnu::always_inline]] inline void add_groups(const std::array<std::vector<float>, D>& coordinate, int first, int last,
                                              const std::array<float, D>& x, const std::array<float, D>& shift, float limit2,
                                              const std::array<double, D>& periods, RowBuilder<D>& row) {
  constexpr int most = 64;  // tested at a time: the bits of a number
  const auto near_from = [&](int k) __attribute__((always_inline))->std::uint64_t {
    return periodic ? near_bits<D>(coordinate, k, x, shift, limit2) : near_bits<D>(coordinate, k, x, {}, limit2);
  };
  const int before = row.groups;
  int free = first;  // the first point that no group holds
  for (int block = first; block < last; block += most) {
    const int count = std::min(last - block, most);
    std::uint64_t near = 0;
    for (int k = 0; k < count; k += 2 * near_lanes)
      near |= near_from(block + k) << k | near_from(block + k + near_lanes) << (k + near_lanes);
    near &= ~std::uint64_t{0} >> (most - count) & ~std::uint64_t{0} << (free - block);
    // Rounds of two groups, each kept as needed: a wrong guess of the processor would cost more than a group.
    while (near != 0)
      for (int round = 0; round < 2; ++round) {
        const int begin = std::countr_zero(near);
        row.group[row.groups] = block + begin;
        row.groups += near != 0;
        near &= ~(std::uint64_t{0xf} << begin % most);
      }
    free = std::max(block + most, row.groups > before ? row.group[row.groups - 1] + lanes : 0);
  }
  row.template close<periodic>(before, last, periods);
}

}  // namespace

template <int D>
void find_neighbours(const Constants<D>& constants, const Period<D>& period, const RowOrder<D>& order,
                     const std::vector<Vector<D>>& position, Neighbours<D>& result) {
  const int n = static_cast<int>(order.contents.order.size()), all = static_cast<int>(position.size());
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  for (auto* v : {&result.begin, &result.length, &result.count}) v->resize(n);
  result.beside_body.clear();
  result.number_density.resize(n);
  result.moment.resize(n);
  result.kernel_gradient.resize(n);
  result.concentration_gradient.resize(n);
  result.row_scratch.resize(threads);
  by_axis<D>(position, result.position);

  // Single precision, one array per axis, from the corner of the box of all particles: the candidates of a row are contiguous, so their
  // distances are computed many at a time.
  std::array<std::vector<float>, D>& coordinate = result.coordinate;
  for (auto& values : coordinate) values.resize(all + 4 * near_lanes);
  parallel_for(all, [&](int i) {
    for (int c = 0; c < D; ++c) coordinate[c][i] = static_cast<float>(position[i][c] - order.corner[c]);
  });
  double extent = order.extent;
  for (int c = 0; c < D; ++c) extent = std::max(extent, period.length(c));
  const double support = constants.kernel.support();
  const float limit2 = near_limit2<D>(support, extent);
  const double reach = (1 + 1e-6) * support;  // for points that rounding has put into the next row

  Vector<D> low = Vector<D>::Constant(1e300), high = -low;
  if (period.any())
    for (const auto& x : position) low = low.cwiseMin(x), high = high.cwiseMax(x);

  const RowKernel<D> kernel(constants);
  // Each thread owns one contiguous range of particles and one contiguous part of the arrays.
  const std::size_t rows = static_cast<std::size_t>(n) / threads + 1;
  std::size_t row_length = std::max<std::size_t>(initial_row_length(D), result.weight.size() / (rows * threads));
  for (bool fits = false; !fits; row_length += row_length / 2) {
    fits = true;
    const std::size_t part = (rows * row_length + lanes - 1) / lanes * lanes;
    if (result.weight.size() < part * threads) {
      result.first.resize(part * threads / lanes);
      result.weight.resize(part * threads);
    }
    const std::size_t longest = 16 * row_length;
#pragma omp parallel num_threads(threads) reduction(&& : fits)
    {
      const int thread = omp_get_thread_num();
      const int own_begin = static_cast<int>(static_cast<long>(n) * thread / threads);
      const int own_end = static_cast<int>(static_cast<long>(n) * (thread + 1) / threads);
      std::size_t next = part * thread;
      RowScratch& scratch = result.row_scratch[thread];
      scratch.reserve(longest);
      RowBuilder<D> row{period, result.position, all, scratch.lanes_of.data()};
      period.specialise([&](auto periodic) {
        const LanePeriod<decltype(periodic)::value, D> lane_period(period);
        for (int i = own_begin; i < own_end && fits; ++i) {
          result.begin[i] = static_cast<int>(next);
          row.begin_row(i, result.first.data() + next / lanes);
          const int room = static_cast<int>(std::min(longest, part * (thread + 1) - next)) - 2 * lanes;
          std::array<float, D> x;
          for (int c = 0; c < D; ++c) x[c] = coordinate[c][i];
          const auto search = [&](const Vector<D>& shift) __attribute__((always_inline)) {
            std::array<float, D> shift_single;
            std::array<double, D> periods{};
            for (int c = 0; c < D; ++c) {
              shift_single[c] = static_cast<float>(shift[c]);
              if (periodic && period.repeats(c)) periods[c] = std::nearbyint(shift[c] / period.length(c));
            }
            const auto look_through = [&](const RowGrid<D>& grid, const std::vector<int>& start, int before)
                __attribute__((always_inline)) {
              const auto in_row = [&](int first_cell, int last_cell) __attribute__((always_inline)) {
                const int first = before + start[first_cell], last = before + start[last_cell + 1];
                fits = fits && row.groups * lanes + (last - first) <= room;
                if (!fits || first >= last) return;
                const int before_this = row.groups;
                add_groups<decltype(periodic)::value, D>(coordinate, first, last, x, shift_single, limit2, periods, row);
                if (first <= i && i < last) row.leave_out_itself(before_this);
              };
              grid.for_rows_around(position[i] + shift, reach, in_row);
            };
            look_through(order.grid, order.contents.start, 0);
            if (all > n) look_through(order.ghost_grid, order.ghosts.start, n);
          };
          if (all >= lanes) search(Vector<D>::Zero());
          if (periodic && all >= lanes) for_images<D>(period, position[i], low, high, support, search);
          if (!fits) break;
          result.length[i] = row.groups * lanes;
          sum_row<decltype(periodic)::value, D>(kernel, lane_period, i, scratch, result);
          next += result.length[i];
        }
      });
    }
  }
}

template <int D>
void complete_row(const Constants<D>& constants, const Period<D>& period, int i, RowScratch& scratch, Neighbours<D>& result) {
  const int length = result.length[i];
  const float* const weight = result.weight.data() + result.begin[i];
  scratch.reserve(length);
  std::fill(scratch.lanes_of.begin(), scratch.lanes_of.begin() + length / lanes, 0);
  for (int k = 0; k < length; ++k) scratch.lanes_of[k / lanes] |= (weight[k] != 0) << k % lanes;
  period.specialise(
      [&](auto periodic) { sum_row(RowKernel<D>(constants), LanePeriod<decltype(periodic)::value, D>(period), i, scratch, result); });
}

#define TERN_INSTANTIATE(D)                                                                                                  \
  template void find_neighbours<D>(const Constants<D>&, const Period<D>&, const RowOrder<D>&, const std::vector<Vector<D>>&, \
                                   Neighbours<D>&);                                                                          \
  template void complete_row<D>(const Constants<D>&, const Period<D>&, int, RowScratch&, Neighbours<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
