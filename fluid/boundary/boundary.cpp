#include "fluid/boundary/boundary.hpp"

#include "base/parallel.hpp"
#include "fluid/boundary/line_of_sight.hpp"
#include "fluid/boundary/plane_walls.hpp"
#include "fluid/boundary/wetness.hpp"
#include "sph/convex_corner.hpp"

namespace tern::fluid {

template <int D>
Boundary<D>::Boundary(const Case& scene, const Constants<D>& constants, bool whole, PatchShare share)
    : walls(scene, constants.spacing, constants.faces.support(), whole, share), space_before_walls(walls.faces().size(), -1) {
  wall_finder.fill(walls.faces(), constants.faces.support());
}

namespace {

/// Forgets what is known of the space before patches that move, or beside which another one may be that does.
template <int D>
void forget_space_beside_moving(const Constants<D>& constants, Boundary<D>& boundary) {
  std::vector<double>& space = boundary.space_before_walls;
  const double reach = constants.faces.support() + 0.01 * constants.spacing;  // it is looked at a hair before a patch
  parallel_for(static_cast<std::ptrdiff_t>(space.size()), [&](std::ptrdiff_t k) {
    if (space[k] >= 0 && boundary.walls.is_beside_moving(static_cast<std::size_t>(k), reach)) space[k] = -1;
  });
}

}  // namespace

template <int D>
void move_walls(const Constants<D>& constants, const Ranks& ranks, const Window& window, Boundary<D>& boundary, State<D>& state) {
  forget_space_beside_moving(constants, boundary);
  const WallRates rates = boundary.walls.move_over(window.begin, window.duration, state.last_duration, state.walls);
  double largest[] = {rates.speed, rates.acceleration, rates.speed_in_frame};
  if (!boundary.walls.whole()) ranks.most(std::span<double>(largest));
  state.wall_speed = largest[0];
  state.wall_acceleration = largest[1];
  state.wall_speed_in_frame = largest[2];
  boundary.wall_finder.fill(boundary.walls.faces(), constants.faces.support(), &boundary.walls.lowest());
  forget_space_beside_moving(constants, boundary);
  boundary.clipped_walls.reset();
}

template <int D>
void set_surface(const Constants<D>& constants, const Surface<D>& surface, Boundary<D>& boundary) {
  Faces<D>& faces = boundary.surface;
  faces.position = surface.position;
  faces.velocity = surface.velocity;
  faces.normal = surface.normal;
  faces.area = surface.area;
  faces.two_sided.assign(surface.position.size(), 1);
  boundary.surface_finder.fill(faces, constants.faces.support());
  boundary.clipped_walls.clip(boundary.walls.faces(), boundary.wall_finder, faces);
}

template <int D>
void see_boundary(const Constants<D>& constants, const Period<D>& period, const std::vector<Vector<D>>& position, Boundary<D>& boundary,
                  Neighbours<D>& neighbours) {
  const std::span<const Vector<D>> viewers = std::span(position).first(neighbours.rows());
  see_walls<D>(constants.spacing, viewers, boundary);
  see_faces<D>(viewers, boundary.surface, boundary.surface_finder, boundary.surface_rows);
  // What parts two particles is seen by one of them, which may be of another rank. What the own ones see is known.
  thread_local FaceRows seen_by_all;
  const auto rows_of_all = [&](const FaceRows& own, auto&& append_others) -> const FaceRows& {
    if (position.size() == viewers.size()) return own;
    seen_by_all.begin = own.begin;
    seen_by_all.count = own.count;
    seen_by_all.face = own.face;
    append_others();
    return seen_by_all;
  };
  const auto append_surface = [&] {
    append_seen(position.size(), viewers.size(), seen_by_all,
                [&](std::size_t i, std::vector<int>& seen) { boundary.surface_finder.see(boundary.surface, position[i], seen); });
  };
  if (const FaceRows& seen = rows_of_all(boundary.surface_rows, append_surface); !seen.face.empty()) {
    list_sights<D>(position, boundary.surface, seen, neighbours.cutting);
    hide_walls_behind_structure<D>(position, boundary.seen_walls(), boundary.surface, boundary.surface_rows, neighbours.cutting,
                                   boundary.wall_rows);
    cut_pairs_through_faces<D>(constants, period, position, boundary.surface, seen, neighbours);
    find_covered_faces<D>(boundary.surface, boundary.walls.faces(), boundary.wall_finder, 0.5 * constants.spacing, boundary.covered_faces);
  }
  if (!boundary.walls.any_two_sided()) return;
  const auto append_walls = [&] { see_two_sided_walls<D>(constants.spacing, position, viewers.size(), boundary, seen_by_all); };
  const FaceRows& walls_seen = rows_of_all(boundary.wall_rows, append_walls);
  list_sights<D>(position, boundary.seen_walls(), walls_seen, neighbours.cutting);
  cut_pairs_through_faces<D>(constants, period, position, boundary.seen_walls(), walls_seen, neighbours);
}

template <int D>
void sum_over_hidden_side(const Constants<D>& constants, const Ranks& ranks, const std::vector<Vector<D>>& position,
                          const std::vector<Vector<D>>& gravity, Boundary<D>& boundary) {
  leave_out_dry_walls<D>(constants, boundary.patches, position, boundary.seen_walls(), boundary.walls.faces(), boundary.wall_finder,
                         boundary.space_before_walls, boundary.surface, boundary.surface_finder, boundary.walls.planes(),
                         boundary.wall_rows);
  leave_dry_planes<D>(position, boundary);
  set_wall_sums<D>(constants, position, gravity, boundary.seen_walls(), boundary.wall_rows, boundary.sums);
  if (boundary.walls.may_have_corners())
    close_round_wall_corners<D>(constants, position, gravity, boundary.seen_walls(), boundary.wall_finder, boundary.wall_rows,
                                boundary.surface, boundary.surface_rows, boundary.sums);
  leave_out_dry_bodies<D>(constants, ranks, position, boundary.surface, boundary.surface_finder, boundary.seen_walls(),
                          boundary.wall_finder, boundary.surface_rows);
  add_surface_sums<D>(constants, position, gravity, boundary.surface, boundary.surface_finder, boundary.covered_faces,
                      boundary.surface_rows, boundary.sums);
}

template <int D>
void set_surface_velocity(const std::vector<Vector<D>>& velocity, const std::vector<int>& at_structure, Boundary<D>& boundary) {
  const FaceRows& rows = boundary.surface_rows;
  for (int i : at_structure)
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
      const int k = rows.face[entry];
      boundary.sums.flux[i] += rows.weight[entry] * boundary.surface.normal[k].dot(velocity[k] - boundary.surface.velocity[k]);
    }
  boundary.surface.velocity = velocity;
}

#define TERN_INSTANTIATE(D)                                                                                                              \
  template struct Boundary<D>;                                                                                                           \
  template void move_walls<D>(const Constants<D>&, const Ranks&, const Window&, Boundary<D>&, State<D>&);                                \
  template void set_surface<D>(const Constants<D>&, const Surface<D>&, Boundary<D>&);                                                    \
  template void see_boundary<D>(const Constants<D>&, const Period<D>&, const std::vector<Vector<D>>&, Boundary<D>&, Neighbours<D>&);     \
  template void sum_over_hidden_side<D>(const Constants<D>&, const Ranks&, const std::vector<Vector<D>>&, const std::vector<Vector<D>>&, \
                                        Boundary<D>&);                                                                                   \
  template void set_surface_velocity<D>(const std::vector<Vector<D>>&, const std::vector<int>&, Boundary<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
