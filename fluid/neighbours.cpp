#include "fluid/neighbours.hpp"

#include <array>
#include <numeric>

#include <omp.h>

#include "particles/parallel.hpp"

namespace tern::fluid {
namespace {

/// Entries a row may have at most per unit of expected neighbours; denser clumps make the arrays grow.
constexpr int initial_row_length(int dimension) { return dimension == 2 ? 34 : 130; }

/// One row while it is built: r_j - r_i of the candidates of a row of cells, and of the neighbours kept so far.
template <int D>
struct RowScratch {
  std::vector<double> distance2;
  std::array<std::vector<double>, D> candidate, offset;

  void reserve(std::size_t n) {
    if (distance2.size() >= n) return;
    distance2.resize(2 * n);
    for (auto& axis : candidate) axis.resize(2 * n);
    for (auto& axis : offset) axis.resize(2 * n);
  }
};

/// Appends to row i, which holds `found` neighbours so far, those of the particles first .. first + candidates - 1 that are
/// nearer than the support; returns the new number. Distances many at a time, then a selection without branches.
template <int D>
int keep_near(const std::array<std::vector<double>, D>& coordinate, int first, int candidates, int i, double support2,
              int found, int* __restrict column, RowScratch<D>& scratch) {
  double* __restrict distance2 = scratch.distance2.data();
  double *__restrict dx = scratch.candidate[0].data(), *__restrict dy = scratch.candidate[1].data();
  double *__restrict keep_x = scratch.offset[0].data(), *__restrict keep_y = scratch.offset[1].data();
  [[maybe_unused]] double *__restrict dz = scratch.candidate[D - 1].data(), *__restrict keep_z = scratch.offset[D - 1].data();
  const double *x = coordinate[0].data() + first, *y = coordinate[1].data() + first, *z = coordinate[D - 1].data() + first;
  const double xi = coordinate[0][i], yi = coordinate[1][i], zi = coordinate[D - 1][i];
#pragma omp simd
  for (int k = 0; k < candidates; ++k) {
    dx[k] = x[k] - xi;
    dy[k] = y[k] - yi;
    distance2[k] = dx[k] * dx[k] + dy[k] * dy[k];
  }
  if constexpr (D == 3) {
#pragma omp simd
    for (int k = 0; k < candidates; ++k) {
      dz[k] = z[k] - zi;
      distance2[k] += dz[k] * dz[k];
    }
  }
  const int own = i - first;
  for (int k = 0; k < candidates; ++k) {
    column[found] = first + k;
    keep_x[found] = dx[k];
    keep_y[found] = dy[k];
    if constexpr (D == 3) keep_z[found] = dz[k];
    found += (distance2[k] < support2) & (k != own);
  }
  return found;
}

/// Sums row i over its neighbours at `offset` and writes the weights.
template <int D>
void sum_row(const Constants<D>& constants, const std::array<std::vector<double>, D>& offset, int i, Neighbours<D>& result) {
  const int n = result.count[i];
  double* weight = result.weight.data() + result.begin[i];
  const double inverse_h = 1 / constants.kernel.smoothing_length();
  const double value_scale = constants.kernel.value(0) * constants.volume;
  const double gradient_scale = constants.kernel.gradient_weight(0) * constants.volume / constants.lattice.gradient_moment;
  const double lattice_value = 1 / (constants.kernel.value(constants.spacing) * constants.volume);

  double density = value_scale;
  if constexpr (D == 2) {
    const double *x = offset[0].data(), *y = offset[1].data();
    double mxx = 0, mxy = 0, myy = 0, gx = 0, gy = 0, cx = 0, cy = 0;
#pragma omp simd reduction(+ : density, mxx, mxy, myy, gx, gy, cx, cy)
    for (int k = 0; k < n; ++k) {
      const double dx = x[k], dy = y[k];
      const double q = std::sqrt(dx * dx + dy * dy) * inverse_h;
      const double s = 1 - 0.5 * q, s3 = s * s * s;
      const double w = value_scale * s3 * s * (2 * q + 1), a = gradient_scale * s3;
      weight[k] = a;
      const double ratio = w * lattice_value, ratio2 = ratio * ratio, extra = 1 + 0.2 * ratio2 * ratio2;
      density += w;
      mxx += a * dx * dx, mxy += a * dx * dy, myy += a * dy * dy;
      gx += a * dx, gy += a * dy;
      cx += a * extra * dx, cy += a * extra * dy;
    }
    result.moment[i] << mxx, mxy, mxy, myy;
    result.kernel_gradient[i] << gx, gy;
    result.concentration_gradient[i] << cx, cy;
  } else {
    const double *x = offset[0].data(), *y = offset[1].data(), *z = offset[2].data();
    double mxx = 0, mxy = 0, mxz = 0, myy = 0, myz = 0, mzz = 0, gx = 0, gy = 0, gz = 0, cx = 0, cy = 0, cz = 0;
#pragma omp simd reduction(+ : density, mxx, mxy, mxz, myy, myz, mzz, gx, gy, gz, cx, cy, cz)
    for (int k = 0; k < n; ++k) {
      const double dx = x[k], dy = y[k], dz = z[k];
      const double q = std::sqrt(dx * dx + dy * dy + dz * dz) * inverse_h;
      const double s = 1 - 0.5 * q, s3 = s * s * s;
      const double w = value_scale * s3 * s * (2 * q + 1), a = gradient_scale * s3;
      weight[k] = a;
      const double ratio = w * lattice_value, ratio2 = ratio * ratio, extra = 1 + 0.2 * ratio2 * ratio2;
      density += w;
      mxx += a * dx * dx, mxy += a * dx * dy, mxz += a * dx * dz;
      myy += a * dy * dy, myz += a * dy * dz, mzz += a * dz * dz;
      gx += a * dx, gy += a * dy, gz += a * dz;
      cx += a * extra * dx, cy += a * extra * dy, cz += a * extra * dz;
    }
    result.moment[i] << mxx, mxy, mxz, mxy, myy, myz, mxz, myz, mzz;
    result.kernel_gradient[i] << gx, gy, gz;
    result.concentration_gradient[i] << cx, cy, cz;
  }
  result.number_density[i] = density;
}

}  // namespace

template <int D>
std::size_t Neighbours<D>::pairs() const {
  return std::accumulate(count.begin(), count.end(), std::size_t{0});
}

template <int D>
void find_neighbours(const Constants<D>& constants, const CellGrid<D>& grid, const CellContents& contents,
                     const std::vector<Vector<D>>& position, Neighbours<D>& result) {
  const int n = static_cast<int>(position.size());
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  for (auto* v : {&result.begin, &result.count}) v->resize(n);
  result.number_density.resize(n);
  result.moment.resize(n);
  result.kernel_gradient.resize(n);
  result.concentration_gradient.resize(n);

  const double support2 = constants.kernel.support() * constants.kernel.support();
  // One array per axis: the candidates of a row of cells are contiguous, so their distances are computed many at a time.
  std::array<std::vector<double>, D>& coordinate = result.coordinate;
  for (int c = 0; c < D; ++c) {
    coordinate[c].resize(n);
    for (int i = 0; i < n; ++i) coordinate[c][i] = position[i][c];
  }

  // Each thread owns one contiguous range of particles and one contiguous part of the arrays.
  std::size_t row_length = std::max<std::size_t>(initial_row_length(D), n ? result.column.size() / n : 0);
  for (bool fits = false; !fits; row_length += row_length / 2) {
    fits = true;
    const std::size_t part = (static_cast<std::size_t>(n) / threads + 1) * row_length;
    if (result.column.size() < part * threads) {
      result.column.resize(part * threads);
      result.weight.resize(part * threads);
    }
#pragma omp parallel num_threads(threads) reduction(&& : fits)
    {
      const int thread = omp_get_thread_num();
      const int low = static_cast<int>(static_cast<long>(n) * thread / threads);
      const int high = static_cast<int>(static_cast<long>(n) * (thread + 1) / threads);
      std::size_t next = part * thread;
      RowScratch<D> scratch;
      for (int i = low; i < high && fits; ++i) {
        result.begin[i] = static_cast<int>(next);
        int found = 0;
        grid.for_rows_around(position[i], [&](int first_cell, int last_cell) {
          const int first = contents.start[first_cell], candidates = contents.start[last_cell + 1] - first;
          if (!fits || next + found + candidates > part * (thread + 1)) {
            fits = false;
            return;
          }
          scratch.reserve(found + candidates);
          found = keep_near<D>(coordinate, first, candidates, i, support2, found, result.column.data() + next, scratch);
        });
        if (!fits) break;
        result.count[i] = found;
        next += found;
        sum_row<D>(constants, scratch.offset, i, result);
      }
    }
  }
}

template <int D>
void cut_pairs_through_faces(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& faces,
                             const FaceRows& rows, Neighbours<D>& neighbours) {
  const auto blocked_by = [&](int viewer, int i, int j) {
    for (int entry = rows.begin[viewer]; entry < rows.begin[viewer] + rows.count[viewer]; ++entry) {
      const int k = rows.face[entry];
      if (!faces.two_sided[k]) continue;
      const Vector<D>& a = position[viewer];
      const Vector<D>& b = position[viewer == i ? j : i];
      if (patch_separates(faces, k, a, b)) return true;
    }
    return false;
  };
  // The test is the same from both ends, so both rows lose the pair. A particle that sees no face itself loses pairs only to
  // neighbours that do; those are collected on the way.
  std::vector<int> affected;
  std::vector<char> listed(position.size(), 0);
  const auto list = [&](int i) {
    if (!listed[i]) affected.push_back(i), listed[i] = 1;
  };
  for (int i = 0; i < static_cast<int>(position.size()); ++i)
    if (rows.count[i] > 0) list(i);
  RowScratch<D> scratch;
  for (std::size_t a = 0; a < affected.size(); ++a) {
    const int i = affected[a], first = neighbours.begin[i];
    int kept = 0;
    for (int k = 0; k < neighbours.count[i]; ++k) {
      const int j = neighbours.column[first + k];
      if (blocked_by(i, i, j) || blocked_by(j, i, j)) {
        list(j);
        continue;
      }
      neighbours.column[first + kept++] = j;
    }
    if (kept == neighbours.count[i]) continue;
    neighbours.count[i] = kept;
    scratch.reserve(kept);
    for (int k = 0; k < kept; ++k)
      for (int c = 0; c < D; ++c) scratch.offset[c][k] = position[neighbours.column[first + k]][c] - position[i][c];
    sum_row<D>(constants, scratch.offset, i, neighbours);
  }
}

#define TERN_INSTANTIATE(D)                                                                                            \
  template struct Neighbours<D>;                                                                                       \
  template void find_neighbours<D>(const Constants<D>&, const CellGrid<D>&, const CellContents&,                       \
                                   const std::vector<Vector<D>>&, Neighbours<D>&);                                     \
  template void cut_pairs_through_faces<D>(const Constants<D>&, const std::vector<Vector<D>>&, const Faces<D>&,        \
                                           const FaceRows&, Neighbours<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
