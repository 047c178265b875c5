#include "fluid/boundary/wetness.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include <omp.h>

#include "base/parallel.hpp"
#include "sph/wet_share.hpp"

namespace tern::fluid {
namespace {

/// Unit of the filled space as a whole number. The sum of whole numbers does not depend on their order, nor on the number of
/// threads that share them. It holds 8000 times the space there is.
constexpr double filled_unit = 0x1p-50;

constexpr int batch = 64;  ///< patches computed at a time, one array per quantity

/// Adds what a particle fills of the space before the n patches of a row, which begins at `offset` and has this step; `rest2`: the square
/// of its distance from the line of the row.
inline void fill_row(const Constants<3>& constants, double scale, double step, double offset, double rest2, int n, std::int64_t* filled) {
  // A number from 0 to 2^51 added to this is rounded to a whole number, whose bits are the last ones of the sum: std::llrint() of many at
  // a time.
  constexpr double whole = 0x1.8p52;
  for (int m = 0; m < n; ++m) {
    const double u = offset + m * step, sum = scale * constants.kernel.value(std::sqrt(rest2 + u * u)) + whole;
    filled[m] += std::bit_cast<std::int64_t>(sum) - std::bit_cast<std::int64_t>(whole);
  }
}

/// Adds what a particle at x fills of the space before the n faces from `face` on.
template <int D>
void fill_faces(const Constants<D>& constants, double scale, const Vector<D>& x, const Faces<D>& faces, const int* face, int n,
                std::int64_t* filled) {
  double part[batch];
  for (int first = 0; first < n; first += batch) {
    const int here = std::min(batch, n - first);
    for (int m = 0; m < here; ++m) part[m] = (faces.position[face[first + m]] - x).squaredNorm();
#pragma omp simd
    for (int m = 0; m < here; ++m) part[m] = scale * constants.kernel.value(std::sqrt(part[m]));
    for (int m = 0; m < here; ++m) filled[faces.original_of(face[first + m])] += std::llrint(part[m]);
  }
}

/// What all threads of all ranks have filled, as the part of the first thread.
void add_up_over_ranks(const Halo& patches, std::vector<std::vector<std::int64_t>>& filled) {
  for (std::size_t thread = 1; thread < filled.size(); ++thread)
    for (std::size_t k = 0; k < filled[0].size(); ++k) filled[0][k] += std::exchange(filled[thread][k], 0);
  patches.collect(filled[0], [](std::int64_t& own, std::int64_t other) { own += other; });
  patches.update(filled[0]);
}

/// A point just in front of a face, so that the face's own half space counts as hidden.
template <int D>
Vector<D> just_before(const Constants<D>& constants, const Faces<D>& faces, std::size_t k) {
  return faces.position[k] + 1e-3 * constants.spacing * faces.normal[k];
}

}  // namespace

template <int D>
double hidden_density(const Constants<D>& constants, const Faces<D>& faces, const FaceFinder<D>& finder, const Vector<D>& x,
                      std::vector<int>& seen) {
  seen.clear();
  finder.see(faces, x, seen);
  double sum = 0, way[D][batch], normal[D][batch], area[batch], angle[batch], distance[batch];
  const int count = static_cast<int>(seen.size());
  for (int first = 0; first < count; first += batch) {
    const int here = std::min(batch, count - first);
    for (int m = 0; m < here; ++m) {
      const int k = seen[first + m];
      const Vector<D> to_face = faces.position[k] - x;
      for (int c = 0; c < D; ++c) way[c][m] = to_face[c], normal[c][m] = faces.normal[k][c];
      distance[m] = to_face.squaredNorm();
      area[m] = faces.area[k];
    }
#pragma omp simd
    for (int m = 0; m < here; ++m) {
      double d[D], n[D];
      for (int c = 0; c < D; ++c) d[c] = way[c][m], n[c] = normal[c][m];
      distance[m] = std::sqrt(distance[m]);
      angle[m] = subtended_angle<D>(d, n, area[m]);
    }
    for (int m = 0; m < here; ++m) sum += angle[m] * constants.faces.hidden_density(distance[m]);
  }
  return sum;
}

template <int D>
double space_before(const Constants<D>& constants, const Faces<D>& walls, const FaceFinder<D>& finder, std::size_t k,
                    std::vector<int>& seen) {
  return std::max(0.0, constants.lattice.density - hidden_density(constants, walls, finder, just_before(constants, walls, k), seen));
}

template <int D>
void leave_out_dry_walls(const Constants<D>& constants, const Halo& patches, const std::vector<Vector<D>>& position, const Faces<D>& walls,
                         const Faces<D>& whole_walls, const FaceFinder<D>& wall_finder, std::vector<double>& space,
                         const Faces<D>& structure, const FaceFinder<D>& structure_finder, const std::vector<PlaneWall>& planes,
                         FaceRows& wall_rows) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(wall_rows.begin.size()), count = static_cast<std::ptrdiff_t>(walls.size());
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  const double scale = constants.volume / filled_unit;
  wall_rows.wet.resize(walls.size());
  wall_rows.filled.resize(threads);
  wall_rows.seen.resize(threads);
#pragma omp parallel num_threads(threads)
  {
    std::vector<std::int64_t>& filled = wall_rows.filled[omp_get_thread_num()];
    filled.resize(walls.size(), 0);
#pragma omp for schedule(static)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      if constexpr (D == 3) {
        if (wall_rows.before_plane(i)) {
          planes[wall_rows.plane[i]].for_rows_around(
              position[i], constants.faces.support(), [&](int k, int count_of_row, double offset, double rest2) {
                fill_row(constants, scale, planes[wall_rows.plane[i]].step[0], offset, rest2, count_of_row, filled.data() + k);
              });
          continue;
        }
      }
      fill_faces(constants, scale, position[i], walls, wall_rows.face.data() + wall_rows.begin[i], wall_rows.count[i], filled.data());
    }
    if (!patches.alone()) {
#pragma omp master
      add_up_over_ranks(patches, wall_rows.filled);
#pragma omp barrier
    }
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < count; ++k) {
      std::int64_t sum = 0;
      for (auto& part : wall_rows.filled) sum += std::exchange(part[k], 0);
      wall_rows.wet[k] = 0;
      if (sum == 0) continue;
      const Vector<D> x = just_before(constants, walls, k);
      std::vector<int>& seen = wall_rows.seen[omp_get_thread_num()];
      if (space[k] < 0) space[k] = space_before(constants, whole_walls, wall_finder, static_cast<std::size_t>(k), seen);
      const double hidden = hidden_density(constants, structure, structure_finder, x, seen);
      wall_rows.wet[k] = wet_share(filled_unit * static_cast<double>(sum) / std::max(space[k] - hidden, 0.02));
    }
  }
  // An image comes after its original.
  for (std::ptrdiff_t k = 0; k < count; ++k) wall_rows.wet[k] = wall_rows.wet[walls.original_of(k)];
}

template <int D>
void leave_out_dry_bodies(const Constants<D>& constants, const Ranks& ranks, const std::vector<Vector<D>>& position, const Faces<D>& bodies,
                          const FaceFinder<D>& body_finder, const Faces<D>& walls, const FaceFinder<D>& wall_finder, FaceRows& rows) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(rows.begin.size()), count = static_cast<std::ptrdiff_t>(bodies.size());
  rows.wet.resize(bodies.size());
  if (count == 0) return;
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  rows.filled.resize(threads);
  rows.seen.resize(threads);
#pragma omp parallel num_threads(threads)
  {
    std::vector<std::int64_t>& filled = rows.filled[omp_get_thread_num()];
    filled.assign(bodies.size(), 0);
#pragma omp for schedule(static)
    for (std::ptrdiff_t i = 0; i < n; ++i)
      fill_faces(constants, constants.volume / filled_unit, position[i], bodies, rows.face.data() + rows.begin[i], rows.count[i],
                 filled.data());
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < count; ++k) {
      std::int64_t sum = 0;
      for (const auto& part : rows.filled) sum += part[k];
      rows.wet[k] = filled_unit * static_cast<double>(sum);
    }
#pragma omp master
    ranks.sum(std::span(rows.wet));
#pragma omp barrier
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < count; ++k) {
      if (rows.wet[k] == 0) continue;
      const Vector<D> x = just_before(constants, bodies, k);
      std::vector<int>& seen = rows.seen[omp_get_thread_num()];
      const double hidden =
          hidden_density(constants, bodies, body_finder, x, seen) + hidden_density(constants, walls, wall_finder, x, seen);
      rows.wet[k] = wet_share(rows.wet[k] / std::max(constants.lattice.density - hidden, 0.02));
    }
  }
}

#define TERN_INSTANTIATE(D)                                                                                                               \
  template double hidden_density<D>(const Constants<D>&, const Faces<D>&, const FaceFinder<D>&, const Vector<D>&, std::vector<int>&);     \
  template double space_before<D>(const Constants<D>&, const Faces<D>&, const FaceFinder<D>&, std::size_t, std::vector<int>&);            \
  template void leave_out_dry_walls<D>(const Constants<D>&, const Halo&, const std::vector<Vector<D>>&, const Faces<D>&, const Faces<D>&, \
                                       const FaceFinder<D>&, std::vector<double>&, const Faces<D>&, const FaceFinder<D>&,                 \
                                       const std::vector<PlaneWall>&, FaceRows&);                                                         \
  template void leave_out_dry_bodies<D>(const Constants<D>&, const Ranks&, const std::vector<Vector<D>>&, const Faces<D>&,                \
                                        const FaceFinder<D>&, const Faces<D>&, const FaceFinder<D>&, FaceRows&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
