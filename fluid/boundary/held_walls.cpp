// What a rank looks at of walls. A particle sees patches within the support, and counts dry ones up to half a patch beyond. How far a patch
// is wet depends on what patches within the support of it leave open; so does what faces of the structure see. Whether a face of the
// structure stands at a wall is told by the patches in the cells around a place half a spacing before it, up to two supports away.

#include "fluid/boundary/held_walls.hpp"

#include "fluid/boundary/boundary.hpp"

namespace tern::fluid {
namespace {

constexpr double margin = 4;  ///< spacings by which more is held than is needed: some ten windows of the fastest particle

double reach(double support, double spacing) { return 2 * support + spacing; }

template <int D>
void find_anew(const Constants<D>& constants, const Period<D>& period, Boundary<D>& boundary) {
  boundary.walls.hold(boundary.held.own.with_images(period), boundary.held.own.particles);
  boundary.wall_finder.fill(boundary.walls.faces(), constants.faces.support(), boundary.walls.lowest());
  boundary.space_before_walls.assign(boundary.walls.faces().size(), -1);  // at the edge of what was held it was not all that there is
  boundary.clipped_walls.reset();
}

/// The boxes of all ranks, on all of them.
template <int D>
void tell_boxes(const Ranks& ranks, const Period<D>& period, HeldWalls<D>& held) {
  std::vector<Vector<D>> corners{held.own.particles.min, held.own.particles.max, held.own.structure.min, held.own.structure.max};
  const std::size_t of_rank = corners.size();
  ranks.gather_on_all(corners);
  held.of_ranks.clear();
  for (std::size_t k = 0; k < corners.size(); k += of_rank)
    held.of_ranks.push_back(WallBoxes<D>{{corners[k], corners[k + 1]}, {corners[k + 2], corners[k + 3]}}.with_images(period));
}

}  // namespace

template <int D>
std::vector<Bounds<D>> WallBoxes<D>::with_images(const Period<D>& period) const {
  std::vector<Bounds<D>> boxes;
  for (const Bounds<D>& box : {particles, structure})
    if (!box.empty()) boxes.push_back(box);
  for (int c = 0; c < D; ++c) {
    if (!period.repeats(c)) continue;
    const Vector<D> way = period.length(c) * Vector<D>::Unit(c);
    for (std::size_t k = 0, count = boxes.size(); k < count; ++k) {
      const Bounds<D> box = boxes[k];
      boxes.push_back({box.min - way, box.max - way});
      boxes.push_back({box.min + way, box.max + way});
    }
  }
  return boxes;
}

template <int D>
void hold_walls(const Domain<D>& domain, const Constants<D>& constants, const Period<D>& period, std::span<const Vector<D>> position,
                std::span<const Vector<D>> surface, Boundary<D>& boundary) {
  if (boundary.walls.whole()) return;
  HeldWalls<D>& held = boundary.held;
  const double around = reach(constants.faces.support(), constants.spacing);
  const WallBoxes<D> needed{Bounds<D>::around(position).grown(around), Bounds<D>::around(surface).grown(around)};
  const bool cut_anew = held.cuts != domain.cuts();
  const bool outgrown = cut_anew || !held.own.particles.has(needed.particles) || !held.own.structure.has(needed.structure);
  if (!domain.ranks().any(outgrown)) return;
  held.cuts = domain.cuts();
  ++held.changes;
  if (outgrown) {
    const double more = margin * constants.spacing;
    held.own = {needed.particles.grown(more), needed.structure.grown(more)};
    find_anew(constants, period, boundary);
  }
  tell_boxes(domain.ranks(), period, held);
}

#define TERN_INSTANTIATE(D)                                                                                        \
  template struct WallBoxes<D>;                                                                                    \
  template void hold_walls<D>(const Domain<D>&, const Constants<D>&, const Period<D>&, std::span<const Vector<D>>, \
                              std::span<const Vector<D>>, Boundary<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
