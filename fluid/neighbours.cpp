#include "fluid/neighbours.hpp"

#include <bit>
#include <limits>

#include <omp.h>

#include "base/parallel.hpp"
#include "sph/near_points.hpp"

namespace tern::fluid {
namespace {

/// Entries a row may have at most per unit of expected neighbours; denser clumps make the arrays grow.
constexpr int initial_row_length(int dimension) { return dimension == 2 ? 34 : 130; }

constexpr int row_unit = 4;  ///< rows are filled up to a whole number of it with the particle itself at weight 0

/// Entries a row of n neighbours takes.
constexpr int filled_up(int n) { return (n + row_unit - 1) & -row_unit; }

/// A number that single precision can hold, nearest to `value` but for ties. In a loop over numbers in double precision a conversion there
/// and back would halve how many are computed at a time.
inline double rounded_to_single(double value) {
  constexpr int dropped = std::numeric_limits<double>::digits - std::numeric_limits<float>::digits;
  constexpr std::uint64_t unit = std::uint64_t{1} << dropped;
  return std::bit_cast<double>((std::bit_cast<std::uint64_t>(value) + unit / 2) & -unit);
}

/// Sums row i over its neighbours at `offset`, by axis, and writes the weights; to the end of what fills up the row. Those stand in the
/// first axis of `offset` then.
template <int D>
void sum_row(const Constants<D>& constants, std::array<std::vector<double>, D>& offset, int i, Neighbours<D>& result) {
  const int n = filled_up(result.count[i]);
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
  for (int k = 0; k < n; ++k) weight[k] = static_cast<float>(offset[0][k]);
}

/// Makes a row of the first n entries from begin[i] on: fills it up, finds the vectors from i to the nearest images of its
/// neighbours (those of what fills up the row lie outside the support), and sums.
template <bool periodic, int D>
void fill_and_sum_row(const Constants<D>& constants, const Period<D>& period, const std::vector<Vector<D>>& position, int i, int n,
                      std::array<std::vector<double>, D>& offset, Neighbours<D>& result) {
  int* column = result.column.data() + result.begin[i];
  const int filled = filled_up(n);
  for (int k = n; k < filled; ++k) column[k] = i;
  result.count[i] = n;
  const Vector<D> x = position[i];
  std::array<double*, D> values;
  for (int c = 0; c < D; ++c) {
    if (offset[c].size() < static_cast<std::size_t>(filled)) offset[c].resize(2 * filled);
    values[c] = offset[c].data();
  }
  for (int k = 0; k < n; ++k) {
    const Vector<D> other = position[column[k]];
    for (int c = 0; c < D; ++c) values[c][k] = period.template between<periodic>(x[c], other[c], c);
  }
  for (int c = 0; c < D; ++c)
    for (int k = n; k < filled; ++k) values[c][k] = 2 * constants.kernel.support();
  sum_row<D>(constants, offset, i, result);
}

}  // namespace

template <int D>
void find_neighbours(const Constants<D>& constants, const Period<D>& period, const CellOrder<D>& cells,
                     const std::vector<Vector<D>>& position, Neighbours<D>& result) {
  const CellGrid<D>& grid = cells.grid;
  const int n = static_cast<int>(cells.contents.order.size()), all = static_cast<int>(position.size());
  const int* const start = cells.contents.start.data();
  const int* const ghost_start = all > n ? cells.ghosts.start.data() : nullptr;
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  for (auto* v : {&result.begin, &result.count}) v->resize(n);
  result.beside_body.clear();
  result.number_density.resize(n);
  result.moment.resize(n);
  result.kernel_gradient.resize(n);
  result.concentration_gradient.resize(n);
  result.row_offset.resize(threads);

  // Single precision, one array per axis, from the corner of the box of all particles: the candidates of a row of cells are contiguous, so
  // their distances are computed many at a time.
  std::array<std::vector<float>, D>& coordinate = result.coordinate;
  for (auto& values : coordinate) values.resize(all + near_lanes);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (int i = 0; i < all; ++i)
    for (int c = 0; c < D; ++c) coordinate[c][i] = static_cast<float>(position[i][c] - cells.corner[c]);
  double extent = cells.extent;
  for (int c = 0; c < D; ++c) extent = std::max(extent, period.length(c));
  const float limit2 = near_limit2<D>(constants.kernel.support(), extent);

  Vector<D> low = Vector<D>::Constant(1e300), high = -low;
  if (period.any())
    for (const auto& x : position) low = low.cwiseMin(x), high = high.cwiseMax(x);

  // Each thread owns one contiguous range of particles and one contiguous part of the arrays.
  const std::size_t rows = static_cast<std::size_t>(n) / threads + 1;
  std::size_t row_length = std::max<std::size_t>(initial_row_length(D), result.column.size() / (rows * threads));
  for (bool fits = false; !fits; row_length += row_length / 2) {
    fits = true;
    const std::size_t part = rows * row_length;
    if (result.column.size() < part * threads) {
      result.column.resize(part * threads);
      result.weight.resize(part * threads);
    }
#pragma omp parallel num_threads(threads) reduction(&& : fits)
    {
      const int thread = omp_get_thread_num();
      const int own_begin = static_cast<int>(static_cast<long>(n) * thread / threads);
      const int own_end = static_cast<int>(static_cast<long>(n) * (thread + 1) / threads);
      std::size_t next = part * thread;
      auto& offset = result.row_offset[thread];
      for (int i = own_begin; i < own_end && fits; ++i) {
        result.begin[i] = static_cast<int>(next);
        int* column = result.column.data() + next;
        int found = 0;
        std::array<float, D> x;
        for (int c = 0; c < D; ++c) x[c] = coordinate[c][i];
        const auto search = [&](const Vector<D>& shift) {
          std::array<float, D> shift_single;
          for (int c = 0; c < D; ++c) shift_single[c] = static_cast<float>(shift[c]);
          grid.for_rows_around(position[i] + shift, [&](int first_cell, int last_cell) {
            const auto look_through = [&](int first, int last) {
              fits = fits && next + found + (last - first) + near_lanes <= part * (thread + 1);
              if (fits) found = keep_near<D>(coordinate, first, last, i, x, shift_single, limit2, found, column);
            };
            look_through(start[first_cell], start[last_cell + 1]);
            if (ghost_start != nullptr) look_through(n + ghost_start[first_cell], n + ghost_start[last_cell + 1]);
          });
        };
        search(Vector<D>::Zero());
        if (period.any()) for_images<D>(period, position[i], low, high, constants.kernel.support(), search);
        if (!fits) break;
        period.specialise(
            [&](auto periodic) { fill_and_sum_row<decltype(periodic)::value, D>(constants, period, position, i, found, offset, result); });
        next += filled_up(found);
      }
    }
  }
}

template <int D>
void complete_row(const Constants<D>& constants, const Period<D>& period, const std::vector<Vector<D>>& position, int i, int n,
                  std::array<std::vector<double>, D>& offset, Neighbours<D>& result) {
  period.specialise(
      [&](auto periodic) { fill_and_sum_row<decltype(periodic)::value, D>(constants, period, position, i, n, offset, result); });
}

#define TERN_INSTANTIATE(D)                                                                                                   \
  template void find_neighbours<D>(const Constants<D>&, const Period<D>&, const CellOrder<D>&, const std::vector<Vector<D>>&, \
                                   Neighbours<D>&);                                                                           \
  template void complete_row<D>(const Constants<D>&, const Period<D>&, const std::vector<Vector<D>>&, int, int,               \
                                std::array<std::vector<double>, D>&, Neighbours<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
