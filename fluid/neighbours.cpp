#include "fluid/neighbours.hpp"

#include <bit>
#include <cmath>
#include <limits>

#include <omp.h>

#include "base/parallel.hpp"
#include "sph/near_points.hpp"

namespace tern::fluid {
namespace {

/// Entries of a row on average, for which there is room at first; denser clumps make the arrays grow.
constexpr int initial_row_length(int dimension) { return dimension == 2 ? 60 : 240; }

/// A number that single precision can hold, nearest to `value` but for ties. In a loop over numbers in double precision a conversion there
/// and back would halve how many are computed at a time.
inline double rounded_to_single(double value) {
  constexpr int dropped = std::numeric_limits<double>::digits - std::numeric_limits<float>::digits;
  constexpr std::uint64_t unit = std::uint64_t{1} << dropped;
  return std::bit_cast<double>((std::bit_cast<std::uint64_t>(value) + unit / 2) & -unit);
}

/// Sums row i over its entries at `offset`, by axis, and writes the weights, which stand in the first axis of `offset` then.
template <int D>
void sum_row(const Constants<D>& constants, ByAxis<D>& offset, int i, Neighbours<D>& result) {
  const int n = result.length[i];
  const double inverse_h = 1 / constants.kernel.smoothing_length();
  const double value_scale = constants.kernel.value(0) * constants.volume;
  const double gradient_scale = constants.kernel.gradient_weight(0) * constants.volume / constants.lattice.gradient_moment;
  const double lattice_value = 1 / (constants.kernel.value(constants.spacing) * constants.volume);

  double density = value_scale;
  if constexpr (D == 2) {
    double* const x = offset[0].data();
    const double* const y = offset[1].data();
    double mxx = 0, mxy = 0, myy = 0, gx = 0, gy = 0, cx = 0, cy = 0;
#pragma omp simd reduction(+ : density, mxx, mxy, myy, gx, gy, cx, cy)
    for (int k = 0; k < n; ++k) {
      const double dx = x[k], dy = y[k];
      const double q = std::sqrt(dx * dx + dy * dy) * inverse_h;
      const double s = std::max(0.0, 1 - 0.5 * q), s3 = s * s * s;
      const double w = value_scale * s3 * s * (2 * q + 1);
      const double exact = gradient_scale * s3, a = rounded_to_single(exact);
      x[k] = a;
      const double ratio = w * lattice_value, ratio2 = ratio * ratio, extra = exact * (1 + 0.2 * ratio2 * ratio2);
      density += w;
      mxx += a * dx * dx, mxy += a * dx * dy, myy += a * dy * dy;
      gx += a * dx, gy += a * dy;
      cx += extra * dx, cy += extra * dy;
    }
    result.moment[i] << mxx, mxy, mxy, myy;
    result.kernel_gradient[i] << gx, gy;
    result.concentration_gradient[i] << cx, cy;
  } else {
    double* const x = offset[0].data();
    const double *const y = offset[1].data(), *const z = offset[2].data();
    double mxx = 0, mxy = 0, mxz = 0, myy = 0, myz = 0, mzz = 0, gx = 0, gy = 0, gz = 0, cx = 0, cy = 0, cz = 0;
#pragma omp simd reduction(+ : density, mxx, mxy, mxz, myy, myz, mzz, gx, gy, gz, cx, cy, cz)
    for (int k = 0; k < n; ++k) {
      const double dx = x[k], dy = y[k], dz = z[k];
      const double q = std::sqrt(dx * dx + dy * dy + dz * dz) * inverse_h;
      const double s = std::max(0.0, 1 - 0.5 * q), s3 = s * s * s;
      const double w = value_scale * s3 * s * (2 * q + 1);
      const double exact = gradient_scale * s3, a = rounded_to_single(exact);
      x[k] = a;
      const double ratio = w * lattice_value, ratio2 = ratio * ratio, extra = exact * (1 + 0.2 * ratio2 * ratio2);
      density += w;
      mxx += a * dx * dx, mxy += a * dx * dy, mxz += a * dx * dz;
      myy += a * dy * dy, myz += a * dy * dz, mzz += a * dz * dz;
      gx += a * dx, gy += a * dy, gz += a * dz;
      cx += extra * dx, cy += extra * dy, cz += extra * dz;
    }
    result.moment[i] << mxx, mxy, mxz, mxy, myy, myz, mxz, myz, mzz;
    result.kernel_gradient[i] << gx, gy, gz;
    result.concentration_gradient[i] << cx, cy, cz;
  }
  result.number_density[i] = density;
  float* const weight = result.weight.data() + result.begin[i];
  int count = 0;
  for (int k = 0; k < n; ++k) {
    weight[k] = static_cast<float>(offset[0][k]);
    count += weight[k] != 0;
  }
  result.count[i] = count;
}

/// The groups of a row while it is found: what lies in them, and the vectors there. What is no neighbour is put `far` away.
template <int D>
struct RowBuilder {
  const Period<D>& period;
  const ByAxis<D>& position;
  double far;
  int particles;
  ByAxis<D>& offset;
  int i = 0;
  std::array<double, D> x{};
  int* group = nullptr;
  int length = 0;  ///< entries so far

  void begin_row(int particle, int* groups) {
    i = particle;
    group = groups;
    length = 0;
    for (int c = 0; c < D; ++c) x[c] = position[c][i];
  }

  /// Makes the group of particles begin .. end - 1, four at most, that one of those to come. `shift`: in whole periods, to the place where
  /// they were found.
  template <bool periodic>
  [[gnu::always_inline]] void put(int to_come, int begin, int end, const std::array<double, D>& shift) {
    const int first = std::min(begin, particles - lanes), at = length + to_come * lanes;
    group[at / lanes] = first;
    const LanePeriod<periodic, D> lane_period(period);
    const Four along_x = lane_period.between(x[0], position[0].data() + first, 0);
    for (int c = 1; c < D; ++c) store(lane_period.between(x[c], position[c].data() + first, c), offset[c].data() + at);
    typedef std::int64_t Places __attribute__((vector_size(lanes * sizeof(std::int64_t))));
    const Places j = std::int64_t{first} + Places{0, 1, 2, 3};
    Places belongs = (j >= std::int64_t{begin}) & (j < std::int64_t{end}) & (j != std::int64_t{i});
    if constexpr (periodic)  // of the images of j only the nearest
      for (int c = 0; c < D; ++c)
        for (int lane = 0; lane < lanes; ++lane)
          if (std::nearbyint((position[c][first + lane] - x[c]) * inverse_length(c)) != shift[c]) belongs[lane] = 0;
    store(belongs ? along_x : Four{} + far, offset[0].data() + at);
  }

 private:
  double inverse_length(int c) const { return period.repeats(c) ? 1 / period.length(c) : 0; }
};

/// Adds the groups that hold all points first .. last - 1 nearer to x + shift than the square root of limit2. May write one group more.
template <bool periodic, int D>
[[gnu::always_inline]] inline void add_groups(const std::array<std::vector<float>, D>& coordinate, int first, int last,
                                              const std::array<float, D>& x, const std::array<float, D>& shift, float limit2,
                                              const std::array<double, D>& periods, RowBuilder<D>& row) {
  const auto near_from = [&](int k) {
    const unsigned near = periodic ? near_bits<D>(coordinate, k, x, shift, limit2) : near_bits<D>(coordinate, k, x, {}, limit2);
    return last - k < near_lanes ? near & ((1u << std::max(last - k, 0)) - 1) : near;
  };
  constexpr int most = 32;  // tested at a time: the bits of a number
  int free = first;         // the first point that no group holds
  for (int block = first; block < last; block += most) {
    unsigned near = near_from(block) | near_from(block + near_lanes) << near_lanes;
    if (last - block > 2 * near_lanes)
      near |= near_from(block + 2 * near_lanes) << (2 * near_lanes) | near_from(block + 3 * near_lanes) << (3 * near_lanes);
    if (free > block) near &= ~0u << (free - block);
    if (near == 0) continue;
    int begin = block + std::countr_zero(near);
    const int end = block + most - std::countl_zero(near), groups = (end - begin + lanes - 1) / lanes;
    if (groups <= 2) {
      // Both are made and kept as needed: a wrong guess of the processor would cost more than a group.
      row.template put<periodic>(0, begin, last, periods);
      row.template put<periodic>(1, begin + lanes, last, periods);
      row.length += groups * lanes;
      free = begin + groups * lanes;
      continue;
    }
    for (; near != 0; near = free - block < most ? near & (~0u << (free - block)) : 0) {
      begin = block + std::countr_zero(near);
      row.template put<periodic>(0, begin, last, periods);
      row.length += lanes;
      free = begin + lanes;
    }
  }
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
  result.row_offset.resize(threads);
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
      RowBuilder<D> row{period, result.position, 2 * support, all, result.row_offset[thread]};
      for (auto& values : row.offset) values.resize(longest);
      period.specialise([&](auto periodic) {
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
                fits = fits && row.length + (last - first) <= room;
                if (fits && first < last)
                  add_groups<decltype(periodic)::value, D>(coordinate, first, last, x, shift_single, limit2, periods, row);
              };
              grid.for_rows_around(position[i] + shift, reach, in_row);
            };
            look_through(order.grid, order.contents.start, 0);
            if (all > n) look_through(order.ghost_grid, order.ghosts.start, n);
          };
          if (all >= lanes) search(Vector<D>::Zero());
          if (periodic && all >= lanes) for_images<D>(period, position[i], low, high, support, search);
          if (!fits) break;
          result.length[i] = row.length;
          sum_row<D>(constants, row.offset, i, result);
          next += row.length;
        }
      });
    }
  }
}

template <int D>
void complete_row(const Constants<D>& constants, const Period<D>& period, int i, ByAxis<D>& offset, Neighbours<D>& result) {
  const int length = result.length[i];
  for (int c = 0; c < D; ++c) {
    if (offset[c].size() < static_cast<std::size_t>(length)) offset[c].resize(2 * length);
    for (int k = 0; k < length; ++k) {
      const double from = result.position[c][i], to = result.position[c][result.column(result.begin[i] + k)];
      offset[c][k] = period.any() ? period.template between<true>(from, to, c) : period.template between<false>(from, to, c);
    }
  }
  for (int k = 0; k < length; ++k)
    if (result.weight[result.begin[i] + k] == 0) offset[0][k] = 2 * constants.kernel.support();
  sum_row<D>(constants, offset, i, result);
}

#define TERN_INSTANTIATE(D)                                                                                                  \
  template void find_neighbours<D>(const Constants<D>&, const Period<D>&, const RowOrder<D>&, const std::vector<Vector<D>>&, \
                                   Neighbours<D>&);                                                                          \
  template void complete_row<D>(const Constants<D>&, const Period<D>&, int, ByAxis<D>&, Neighbours<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
