#include "fluid/neighbours.hpp"

#include <numeric>
#include <omp.h>

#include "particles/parallel.hpp"

namespace tern::fluid {
namespace {

/// Entries a row may have at most per unit of expected neighbours; denser clumps make the arrays grow.
constexpr int initial_row_length(int dimension) { return dimension == 2 ? 34 : 130; }

/// Sums row i over the neighbours in column[first .. first + n - 1] and writes the weights.
template <int D>
void sum_row(const Constants<D>& constants, const std::vector<Vector<D>>& position, int i, Neighbours<D>& result) {
  const int first = result.begin[i], n = result.count[i];
  const int* column = result.column.data() + first;
  double* weight = result.weight.data() + first;
  const double h = constants.kernel.smoothing_length(), inverse_h = 1 / h;
  const double value_scale = constants.kernel.value(0) * constants.volume;
  const double gradient_scale = constants.kernel.gradient_weight(0) * constants.volume / constants.lattice.gradient_moment;
  const double lattice_value = 1 / (constants.kernel.value(constants.spacing) * constants.volume);
  const Vector<D> xi = position[i];

  double density = value_scale;
  double m[D][D] = {}, g[D] = {}, c[D] = {};
  if constexpr (D == 2) {
    double mxx = 0, mxy = 0, myy = 0, gx = 0, gy = 0, cx = 0, cy = 0;
#pragma omp simd reduction(+ : density, mxx, mxy, myy, gx, gy, cx, cy)
    for (int k = 0; k < n; ++k) {
      const double* xj = position[column[k]].data();
      const double dx = xj[0] - xi[0], dy = xj[1] - xi[1];
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
    m[0][0] = mxx, m[0][1] = m[1][0] = mxy, m[1][1] = myy;
    g[0] = gx, g[1] = gy, c[0] = cx, c[1] = cy;
  } else {
    double mxx = 0, mxy = 0, mxz = 0, myy = 0, myz = 0, mzz = 0, gx = 0, gy = 0, gz = 0, cx = 0, cy = 0, cz = 0;
#pragma omp simd reduction(+ : density, mxx, mxy, mxz, myy, myz, mzz, gx, gy, gz, cx, cy, cz)
    for (int k = 0; k < n; ++k) {
      const double* xj = position[column[k]].data();
      const double dx = xj[0] - xi[0], dy = xj[1] - xi[1], dz = xj[2] - xi[2];
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
    m[0][0] = mxx, m[0][1] = m[1][0] = mxy, m[0][2] = m[2][0] = mxz;
    m[1][1] = myy, m[1][2] = m[2][1] = myz, m[2][2] = mzz;
    g[0] = gx, g[1] = gy, g[2] = gz, c[0] = cx, c[1] = cy, c[2] = cz;
  }
  result.number_density[i] = density;
  for (int a = 0; a < D; ++a) {
    result.kernel_gradient[i][a] = g[a];
    result.concentration_gradient[i][a] = c[a];
    for (int b = 0; b < D; ++b) result.moment[i](a, b) = m[a][b];
  }
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

  const float support2 = static_cast<float>(constants.kernel.support() * constants.kernel.support());
  // Positions relative to a corner in single precision: enough to tell neighbours but for a rim of 1e-6, whose weight
  // (1 - q/2)^3 vanishes there anyway; sum_row clips nothing because the exact test follows.
  std::vector<float> coordinate[D];
  Vector<D> corner = n ? position[0] : Vector<D>::Zero();
  for (const auto& x : position) corner = corner.cwiseMin(x);
  for (int c = 0; c < D; ++c) {
    coordinate[c].resize(n);
    for (int i = 0; i < n; ++i) coordinate[c][i] = static_cast<float>(position[i][c] - corner[c]);
  }
  const double exact_support2 = constants.kernel.support() * constants.kernel.support();

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
      std::vector<float> distance2;
      for (int i = low; i < high && fits; ++i) {
        result.begin[i] = static_cast<int>(next);
        int found = 0;
        grid.for_rows_around(position[i], [&](int first_cell, int last_cell) {
          const int first = contents.start[first_cell], last = contents.start[last_cell + 1];
          const int candidates = last - first;
          if (!fits || next + found + candidates > part * (thread + 1)) {
            fits = false;
            return;
          }
          if (static_cast<int>(distance2.size()) < candidates) distance2.resize(candidates);
          float xi[D];
          const float* x[D];
          for (int c = 0; c < D; ++c) xi[c] = coordinate[c][i], x[c] = coordinate[c].data() + first;
          for (int k = 0; k < candidates; ++k) {
            float sum = 0;
            for (int c = 0; c < D; ++c) {
              const float d = x[c][k] - xi[c];
              sum += d * d;
            }
            distance2[k] = sum;
          }
          int* out = result.column.data() + next;
          for (int k = 0; k < candidates; ++k) {
            out[found] = first + k;
            found += distance2[k] < support2 && first + k != i;
          }
        });
        if (!fits) break;
        int kept = 0;
        int* out = result.column.data() + next;
        for (int k = 0; k < found; ++k) {
          out[kept] = out[k];
          kept += (position[out[k]] - position[i]).squaredNorm() < exact_support2;
        }
        result.count[i] = kept;
        next += kept;
        sum_row(constants, position, i, result);
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
    sum_row(constants, position, i, neighbours);
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
