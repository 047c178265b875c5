#pragma once
// What particles see: faces that no other hides, and each other where no body stands between them.

#include <algorithm>
#include <span>
#include <vector>

#include <omp.h>

#include "base/parallel.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/period.hpp"
#include "fluid/reference.hpp"
#include "sph/faces.hpp"

namespace tern::fluid {

/// Fills `rows` with the faces that each of n particles sees, in the order of the particles, without the weights. see(i, seen) appends
/// those of particle i.
template <class See>
void list_seen(int n, FaceRows& rows, See&& see) {
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  rows.begin.resize(n);
  rows.count.resize(n);
  rows.height.resize(n);
  rows.face.clear();
  rows.seen.resize(threads);
#pragma omp parallel num_threads(threads)
  {
    // Each thread finds the faces of one contiguous range of particles; put one after the other they are in order.
    const int thread = omp_get_thread_num();
    const int own_begin = static_cast<int>(static_cast<long>(n) * thread / threads);
    const int own_end = static_cast<int>(static_cast<long>(n) * (thread + 1) / threads);
    std::vector<int>& seen = thread == 0 ? rows.face : rows.seen[thread];
    seen.clear();
    for (int i = own_begin; i < own_end; ++i) {
      rows.begin[i] = static_cast<int>(seen.size());
      see(i, seen);
      rows.count[i] = static_cast<int>(seen.size()) - rows.begin[i];
    }
#pragma omp barrier
    std::size_t before = rows.face.size(), total = before;
    for (int other = 1; other < threads; ++other) {
      if (other < thread) before += rows.seen[other].size();
      total += rows.seen[other].size();
    }
#pragma omp barrier
#pragma omp single
    {
      rows.face.resize(total);
      rows.weight.resize(total);
    }
    if (thread > 0) {
      std::copy(seen.begin(), seen.end(), rows.face.begin() + static_cast<std::ptrdiff_t>(before));
      for (int i = own_begin; i < own_end; ++i) rows.begin[i] += static_cast<int>(before);
    }
  }
}

/// Appends the rows of particles first .. n - 1 to those of the ones before.
template <class See>
void append_seen(std::size_t n, std::size_t first, FaceRows& rows, See&& see) {
  rows.begin.resize(n);
  rows.count.resize(n);
  for (std::size_t i = first; i < n; ++i) {
    rows.begin[i] = static_cast<int>(rows.face.size());
    see(i, rows.face);
    rows.count[i] = static_cast<int>(rows.face.size()) - rows.begin[i];
  }
}

/// Fills `rows` with the faces that particles at these positions see, in their order, without the weights.
template <int D>
void see_faces(std::span<const Vector<D>> position, const Faces<D>& faces, const FaceFinder<D>& finder, FaceRows& rows);

/// Whether a face that particle i sees, at x, parts it from this place.
template <int D>
bool any_separates(const Faces<D>& faces, const FaceRows& rows, std::ptrdiff_t i, const Vector<D>& x, const Vector<D>& place) {
  const auto first = rows.face.begin() + rows.begin[i];
  return std::any_of(first, first + rows.count[i], [&](int k) { return patch_separates(faces, k, x, place); });
}

/// Sets `seen` to what particles see of two-sided faces, of which `rows` lists those that each sees.
template <int D>
void list_sights(const std::vector<Vector<D>>& position, const Faces<D>& faces, const FaceRows& rows,
                 typename Neighbours<D>::Cutting& seen);

/// Takes out of `wall_rows` the patches of walls that the structure hides from a particle. After list_sights() of the structure.
template <int D>
void hide_walls_behind_structure(const std::vector<Vector<D>>& position, const Faces<D>& walls, const Faces<D>& surface,
                                 const FaceRows& surface_rows, const typename Neighbours<D>::Cutting& seen, FaceRows& wall_rows);

/// Takes out pairs whose connecting line passes through a two-sided face that either particle sees, and sums those rows anew. `rows` lists
/// the faces seen by each particle, and neighbours.cutting what list_sights() makes of them. The fluid on one side of a plate does not see
/// the fluid on the other, but fluid past a convex corner is seen (convex_corner.hpp).
template <int D>
void cut_pairs_through_faces(const Constants<D>& constants, const Period<D>& period, const std::vector<Vector<D>>& position,
                             const Faces<D>& faces, const FaceRows& rows, Neighbours<D>& neighbours);

}  // namespace tern::fluid
