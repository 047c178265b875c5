// What a rank looks at of walls. A particle sees patches within the support, and counts dry ones up to half a patch beyond. How far a patch
// is wet depends on what patches within the support of it leave open; so does what faces of the structure see. Whether a face of the
// structure stands at a wall is told by the patches in the cells around a place half a spacing before it, up to two supports away.

#include "fluid/boundary/held_walls.hpp"

#include "fluid/boundary/boundary.hpp"

namespace tern::fluid {
namespace {

constexpr double margin = 4;  ///< spacings by which more is held than is needed: some ten windows of the fastest particle

double reach(double support, double spacing) { return 2 * support + spacing; }

/// Around these places as they were at t = 0, when the wall that moves was where the case has it; null: of walls at rest.
template <int D>
Bounds<D> around(std::span<const Vector<D>> places, const Wall<D>* moving, double by) {
  if (moving == nullptr) return Bounds<D>::around(places).grown(by);
  Bounds<D> box = Bounds<D>::nowhere();
  for (const Vector<D>& x : places) {
    const Vector<D> reference = moving->reference(x);
    box.min = box.min.cwiseMin(reference), box.max = box.max.cwiseMax(reference);
  }
  return box.grown(by);
}

template <int D>
std::vector<Bounds<D>> with_images(std::vector<Bounds<D>> boxes, const Period<D>& period, const Wall<D>* moving) {
  for (int c = 0; c < D; ++c) {
    if (!period.repeats(c)) continue;
    Vector<D> way = period.length(c) * Vector<D>::Unit(c);
    if (moving != nullptr) way = moving->now.place.turn.transpose() * way;
    for (std::size_t k = 0, count = boxes.size(); k < count; ++k)
      for (const double sign : {-1.0, 1.0})
        boxes.push_back(boxes[k].empty() ? boxes[k] : Bounds<D>{boxes[k].min + sign * way, boxes[k].max + sign * way});
  }
  return boxes;
}

/// Calls visit(frame, wall that moves) for the walls at rest, which have none, and for each that moves.
template <int D, class Visit>
void for_each_frame(const Walls<D>& walls, Visit&& visit) {
  visit(std::size_t{0}, static_cast<const Wall<D>*>(nullptr));
  for (const Wall<D>& wall : walls.all())
    if (wall.frame > 0) visit(static_cast<std::size_t>(wall.frame), &wall);
}

template <int D>
void find_anew(const Constants<D>& constants, Boundary<D>& boundary) {
  const WallBoxes<D>& own = boundary.held.own;
  WallBoxes<D> of_walls;
  for (const Wall<D>& wall : boundary.walls.all()) of_walls.push_back(own[static_cast<std::size_t>(wall.frame)]);
  boundary.walls.hold(of_walls, own[0][0]);
  boundary.wall_finder.fill(boundary.walls.faces(), constants.faces.support(), &boundary.walls.lowest());
  boundary.space_before_walls.assign(boundary.walls.faces().size(), -1);  // at the edge of what was held it was not all that there is
  boundary.clipped_walls.reset();
}

/// The boxes of all ranks, on all of them.
template <int D>
void tell_boxes(const Ranks& ranks, HeldWalls<D>& held) {
  std::vector<Bounds<D>> all;
  for (const auto& boxes : held.own) all.insert(all.end(), boxes.begin(), boxes.end());
  ranks.gather_on_all(all);
  held.of_ranks.clear();
  for (auto next = all.begin(); next != all.end();) {
    WallBoxes<D> of_rank;
    for (const auto& boxes : held.own) {
      const auto end = next + static_cast<std::ptrdiff_t>(boxes.size());
      of_rank.emplace_back(next, end);
      next = end;
    }
    held.of_ranks.push_back(std::move(of_rank));
  }
}

}  // namespace

template <int D>
void hold_walls(const Domain<D>& domain, const Constants<D>& constants, const Period<D>& period, std::span<const Vector<D>> position,
                std::span<const Vector<D>> surface, Boundary<D>& boundary) {
  if (boundary.walls.whole()) return;
  HeldWalls<D>& held = boundary.held;
  const double needed = reach(constants.faces.support(), constants.spacing), more = needed + margin * constants.spacing;
  bool outgrown = held.own.empty() || held.cuts != domain.cuts();
  for_each_frame<D>(boundary.walls, [&](std::size_t frame, const Wall<D>* moving) {
    outgrown =
        outgrown || !held.own[frame][0].has(around(position, moving, needed)) || !held.own[frame][1].has(around(surface, moving, needed));
  });
  if (!domain.ranks().any(outgrown)) return;
  held.cuts = domain.cuts();
  ++held.changes;
  if (outgrown) {
    held.own.clear();
    for_each_frame<D>(boundary.walls, [&](std::size_t, const Wall<D>* moving) {
      held.own.push_back(with_images<D>({around(position, moving, more), around(surface, moving, more)}, period, moving));
    });
    find_anew(constants, boundary);
  }
  tell_boxes(domain.ranks(), held);
}

#define TERN_INSTANTIATE(D)                                                                                        \
  template void hold_walls<D>(const Domain<D>&, const Constants<D>&, const Period<D>&, std::span<const Vector<D>>, \
                              std::span<const Vector<D>>, Boundary<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
