#include "fluid/boundary/line_of_sight.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "sph/convex_corner.hpp"

namespace tern::fluid {

template <int D>
void see_faces(std::span<const Vector<D>> position, const Faces<D>& faces, const FaceFinder<D>& finder, FaceRows& rows) {
  list_seen(static_cast<int>(position.size()), rows, [&](int i, std::vector<int>& seen) { finder.see(faces, position[i], seen); });
}

namespace {

constexpr double same_direction = 0.95;     ///< cosine of normals that are looked at together
constexpr double beside_corner = 16;        ///< of the square of what a patch reaches: a corner that a line passes outside the body
constexpr std::size_t most_directions = 8;  ///< of a particle; what comes after is added to the nearest

/// Adds face k to what is seen from x: the sights from `first` on.
template <int D>
void add_sight(const Faces<D>& faces, int k, const Vector<D>& x, std::size_t first, std::vector<typename Neighbours<D>::Sight>& sight) {
  const Vector<D>& n = faces.normal[k];
  std::size_t nearest = first;
  double cosine = -1;
  for (std::size_t s = first; s < sight.size(); ++s)
    if (const double here = sight[s].normal.dot(n); here > cosine) nearest = s, cosine = here;
  if (sight.size() == first || (cosine < same_direction && sight.size() < first + most_directions)) {
    nearest = sight.size();
    sight.push_back({n, 1e300, 0, faces.position[k], faces.position[k]});
  }
  auto& own = sight[nearest];
  own.height = std::min(own.height, (x - faces.position[k]).dot(n));
  own.spread = std::max(own.spread, (n - own.normal).norm());
  const Vector<D> reach = Vector<D>::Constant(std::sqrt(patch_reach2<D>(faces.area[k])));
  own.low = own.low.cwiseMin(faces.position[k] - reach);
  own.high = own.high.cwiseMax(faces.position[k] + reach);
}

/// Whether a line from a along d may cross one of these faces towards its back: not where its end is in front of all of them, nor where it
/// passes by the box around them.
template <int D>
bool may_cross(const typename Neighbours<D>::Sight& faces, const Vector<D>& a, const Vector<D>& d, double length2) {
  const double height = d.dot(faces.normal) + faces.height, spread = faces.spread + 1e-9;  // rounding
  if (height > 0 && height * height > spread * spread * length2) return false;
  double enters = 0, leaves = 1;
  for (int axis = 0; axis < D; ++axis) {
    if (d[axis] == 0) {
      if (a[axis] < faces.low[axis] || a[axis] > faces.high[axis]) return false;
      continue;
    }
    const double first = (faces.low[axis] - a[axis]) / d[axis], second = (faces.high[axis] - a[axis]) / d[axis];
    enters = std::max(enters, std::min(first, second));
    leaves = std::min(leaves, std::max(first, second));
  }
  return enters <= leaves + 1e-9;  // rounding
}

/// Whether a line from particle i at a along d may pass through one of the two-sided faces that it sees. Most need no closer look.
template <int D>
bool may_part(const typename Neighbours<D>::Cutting& seen, std::ptrdiff_t i, const Vector<D>& a, const Vector<D>& d) {
  const double length2 = d.squaredNorm();
  const auto first = seen.sight.begin() + seen.sight_begin[seen.listed[i] - 1],
             last = seen.sight.begin() + seen.sight_begin[seen.listed[i]];
  return std::any_of(first, last, [&](const auto& sight) { return may_cross<D>(sight, a, d, length2); });
}

}  // namespace

template <int D>
void list_sights(const std::vector<Vector<D>>& position, const Faces<D>& faces, const FaceRows& rows,
                 typename Neighbours<D>::Cutting& seen) {
  auto& [sight, sight_begin, affected, listed] = seen;
  const int all = static_cast<int>(rows.begin.size());
  affected.clear();
  listed.assign(all, 0);
  sight.clear();
  sight_begin.clear();
  // The number of a particle in `sight_begin` is kept in `listed`.
  for (int i = 0; i < all; ++i)
    for (int entry = rows.begin[i], end = entry + rows.count[i]; entry < end; ++entry) {
      const int k = rows.face[entry];
      if (!faces.two_sided[k]) continue;
      if (!listed[i]) {
        sight_begin.push_back(static_cast<int>(sight.size()));
        affected.push_back(i);
        listed[i] = static_cast<int>(sight_begin.size());
      }
      add_sight(faces, k, position[i], static_cast<std::size_t>(sight_begin.back()), sight);
    }
  sight_begin.push_back(static_cast<int>(sight.size()));
}

template <int D>
void hide_walls_behind_structure(const std::vector<Vector<D>>& position, const Faces<D>& walls, const Faces<D>& surface,
                                 const FaceRows& surface_rows, const typename Neighbours<D>::Cutting& seen, FaceRows& wall_rows) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(wall_rows.begin.size());
  parallel_for(n, [&](std::ptrdiff_t i) {
    if (seen.listed[i] == 0 || wall_rows.count[i] == 0) return;
    int kept = 0;
    for (int entry = wall_rows.begin[i]; entry < wall_rows.begin[i] + wall_rows.count[i]; ++entry) {
      const Vector<D>& wall = walls.position[wall_rows.face[entry]];
      if (may_part<D>(seen, i, position[i], wall - position[i]) && any_separates(surface, surface_rows, i, position[i], wall)) continue;
      wall_rows.face[wall_rows.begin[i] + kept++] = wall_rows.face[entry];
    }
    wall_rows.count[i] = kept;
  });
}

template <int D>
void cut_pairs_through_faces(const Constants<D>& constants, const Period<D>& period, const std::vector<Vector<D>>& position,
                             const Faces<D>& faces, const FaceRows& rows, Neighbours<D>& neighbours) {
  auto& [sight, sight_begin, affected, listed] = neighbours.cutting;
  const int n = static_cast<int>(neighbours.rows()), all = static_cast<int>(rows.begin.size());
  const int viewers = static_cast<int>(sight_begin.size()) - 1;
  // Whether the line from a to b, that enters a body through `patch`, leaves it past a corner. Patches reach a little beyond their edges. A
  // line that passes there, outside the body, may pass the faces round the corner at a greater distance than they reach.
  // `d`: from a to b. What b sees stands where b is, which may be a period away.
  const auto leaves_past_corner = [&](int patch, int other, const Vector<D>& d) {
    const Vector<D>& b = position[other];
    const Vector<D> a = b - d;
    bool leaves = false;
    for (int entry = rows.begin[other]; entry < rows.begin[other] + rows.count[other]; ++entry) {
      const int k = rows.face[entry];
      const double reach2 = patch_reach2<D>(faces.area[k]);
      if (!patch_separates(faces, k, b, a, 0, beside_corner * reach2)) continue;
      if (passes_corner<D>(faces.normal[patch], faces.normal[k]))
        leaves = true;
      else if (patch_separates(faces, k, b, a, 0, reach2))
        return false;
    }
    return leaves;
  };
  const auto blocked_by = [&](int viewer, int other) {
    if (listed[viewer] == 0 || listed[viewer] > viewers) return false;
    const Vector<D>& a = position[viewer];
    const Vector<D> d = period.any() ? period.nearest(position[other] - a) : Vector<D>(position[other] - a);
    if (!may_part<D>(neighbours.cutting, viewer, a, d)) return false;
    const Vector<D> b = a + d;
    for (int entry = rows.begin[viewer]; entry < rows.begin[viewer] + rows.count[viewer]; ++entry) {
      const int k = rows.face[entry];
      if (faces.two_sided[k] && patch_separates(faces, k, a, b) && !leaves_past_corner(k, other, d)) return true;
    }
    return false;
  };
  // The test is the same from both ends, so both rows lose the pair. A particle that sees no face itself loses pairs only to
  // neighbours that do; those are collected on the way.
  // Particles of other ranks have no rows to collect them from: their neighbours here are looked for.
  for (int i = 0; i < n && all > n; ++i)
    for (int k = neighbours.begin[i]; k < neighbours.begin[i] + neighbours.length[i] && !listed[i]; ++k) {
      const int j = neighbours.column(k);
      if (j >= n && neighbours.weight[k] != 0 && listed[j]) affected.push_back(i), listed[i] = viewers + 1;
    }
  neighbours.row_scratch.resize(std::max<std::size_t>(1, neighbours.row_scratch.size()));
  for (std::size_t a = 0; a < affected.size(); ++a) {
    const int i = affected[a];
    if (i >= n) continue;
    bool any_cut = false;
    for (int k = neighbours.begin[i]; k < neighbours.begin[i] + neighbours.length[i]; ++k) {
      const int j = neighbours.column(k);
      if (neighbours.weight[k] == 0 || !(blocked_by(i, j) || blocked_by(j, i))) continue;
      if (!listed[j]) affected.push_back(j), listed[j] = viewers + 1;
      neighbours.weight[k] = 0;
      any_cut = true;
    }
    if (any_cut) complete_row<D>(constants, period, i, neighbours.row_scratch[0], neighbours);
  }
  neighbours.beside_body.reserve(n);
  neighbours.beside_body.insert(neighbours.beside_body.end(), affected.begin(), affected.end());
}

#define TERN_INSTANTIATE(D)                                                                                                        \
  template void see_faces<D>(std::span<const Vector<D>>, const Faces<D>&, const FaceFinder<D>&, FaceRows&);                        \
  template void hide_walls_behind_structure<D>(const std::vector<Vector<D>>&, const Faces<D>&, const Faces<D>&, const FaceRows&,   \
                                               const typename Neighbours<D>::Cutting&, FaceRows&);                                 \
  template void list_sights<D>(const std::vector<Vector<D>>&, const Faces<D>&, const FaceRows&, typename Neighbours<D>::Cutting&); \
  template void cut_pairs_through_faces<D>(const Constants<D>&, const Period<D>&, const std::vector<Vector<D>>&, const Faces<D>&,  \
                                           const FaceRows&, Neighbours<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
