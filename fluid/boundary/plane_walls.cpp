#include "fluid/boundary/plane_walls.hpp"

#include <algorithm>
#include <cmath>

#include "fluid/boundary/boundary.hpp"
#include "fluid/boundary/line_of_sight.hpp"

namespace tern::fluid {
namespace {

constexpr double blended = 0.5;   ///< spacings over which the share of a plane goes from 1 to 0
constexpr int dry_patches = 4;    ///< over as many as well
constexpr int whole_patch = 256;  ///< unit of dry patches in whole numbers, whose sums do not depend on their order
/// Of a difference of such sums, of up to 2^31, between corners of the grid: what lies elsewhere must not decide what a particle sees.
constexpr double rounding = 1e-5;

/// A place among the walls: the plane wall that is all there is within the support, with the share that it has, or whether there is
/// nothing at all, or planes alone.
struct View {
  int plane = -1;
  double share = 0;
  bool empty = true, planes_alone = true;
};

struct Box {
  Vector<3> low = Vector<3>::Constant(1e300), high = Vector<3>::Constant(-1e300);

  double distance(const Vector<3>& x) const { return (low - x).cwiseMax(x - high).cwiseMax(0).norm(); }
};

Box box_around(const std::vector<Vector<3>>& places) {
  Box box;
  for (const Vector<3>& x : places) box.low = box.low.cwiseMin(x), box.high = box.high.cwiseMax(x);
  return box;
}

View look(const Walls<3>& walls, const Box& structure, double support, double blend, const Vector<3>& x) {
  View view;
  double slack = structure.distance(x) - support;
  view.planes_alone = slack > 2 * blend;  // what a body leaves of a patch lies elsewhere
  for (int p = 0; p < static_cast<int>(walls.planes().size()); ++p) {
    const PlaneWall& plane = walls.planes()[p];
    const double height = plane.height(x);
    if (height <= 0 || height >= support + blend) continue;
    double outside2 = 0, inside = 1e300;
    for (int c = 0; c < 2; ++c) {
      const double from_low = x[plane.along[c]] - plane.low[c], from_high = plane.high[c] - x[plane.along[c]];
      inside = std::min({inside, from_low, from_high});
      outside2 += std::pow(std::max({0.0, -from_low, -from_high}), 2);
    }
    const double beyond = std::sqrt(height * height + outside2) - support;
    if (beyond >= blend) continue;
    if (height < support && view.plane < 0 && inside > 0) {
      view.plane = p;
      slack = std::min(slack, inside - std::sqrt(support * support - height * height));
    } else {
      slack = std::min(slack, beyond);
    }
    view.empty = view.empty && beyond >= 0;
  }
  for (int w : walls.not_plane()) {
    const Wall<3>& wall = walls.all()[w];
    const double beyond = std::abs(signed_distance<3>(wall.scene.shape, wall.reference(x))) - support;
    slack = std::min(slack, beyond);
    view.empty = view.empty && beyond >= 0;
    view.planes_alone = view.planes_alone && beyond >= 0;
  }
  view.share = std::clamp(slack / blend, 0.0, 1.0);
  if (view.share == 0) view.plane = -1;
  return view;
}

/// The patches of a plane wall that particles in this box fill, or count as dry.
GridPart part_near(const PlaneWall& plane, double support, const Bounds<3>& particles) {
  GridPart part;
  if (particles.empty() || plane.height(plane.side > 0 ? particles.min : particles.max) >= 1.01 * support) return part;
  for (int c = 0; c < 2; ++c) {
    // Half a patch and the one in which that ends.
    const double from = (particles.min[plane.along[c]] - support - plane.low[c]) / plane.step[c] - 1.5;
    const double to = (particles.max[plane.along[c]] + support - plane.low[c]) / plane.step[c] + 1.5;
    const double first = plane.held.from[c], last = plane.held.to[c];
    part.from[c] = static_cast<int>(std::clamp(std::floor(from), first, last));
    part.to[c] = static_cast<int>(std::clamp(std::ceil(to), first, last));
  }
  return part;
}

void list_patches(const PlaneWall& plane, double support, const Vector<3>& x, std::vector<int>& seen) {
  plane.for_rows_around(x, support, [&](int k, int n, double, double) {
    for (int m = 0; m < n; ++m) seen.push_back(k + m);
  });
}

}  // namespace

template <int D>
void see_walls(double spacing, std::span<const Vector<D>> position, Boundary<D>& boundary) {
  const Faces<D>& faces = boundary.seen_walls();
  FaceRows& rows = boundary.wall_rows;
  if constexpr (D == 3) {
    if (!boundary.walls.planes().empty()) {
      const double support = boundary.wall_finder.support();
      const Box structure = box_around(boundary.surface.position);
      rows.plane.resize(position.size());
      rows.plane_share.resize(position.size());
      list_seen(static_cast<int>(position.size()), rows, [&](int i, std::vector<int>& seen) {
        const Vector<3>& x = position[i];
        const View view = look(boundary.walls, structure, support, blended * spacing, x);
        rows.plane[i] = static_cast<std::int16_t>(view.plane);
        rows.plane_share[i] = view.share;
        if (view.empty) return;
        if (view.plane < 0 && view.planes_alone) {  // the same patches, without a search
          for (const PlaneWall& plane : boundary.walls.planes())
            if (const double height = plane.height(x); height > 0 && height < support) list_patches(plane, support, x, seen);
        } else if (view.plane < 0)
          boundary.wall_finder.see(faces, x, seen);
        else if (view.share < 1)
          list_patches(boundary.walls.planes()[view.plane], support, x, seen);
        else
          seen.push_back(boundary.walls.planes()[view.plane].at_foot(x));
      });
      return;
    }
  }
  see_faces<D>(position, faces, boundary.wall_finder, rows);
}

template <int D>
void see_two_sided_walls(double spacing, std::span<const Vector<D>> position, std::size_t first, const Boundary<D>& boundary,
                         FaceRows& rows) {
  const Faces<D>& faces = boundary.seen_walls();
  const auto see = [&](std::size_t i, std::vector<int>& seen) { boundary.wall_finder.see(faces, position[i], seen); };
  if constexpr (D == 3) {
    if (!boundary.walls.planes().empty()) {
      const double support = boundary.wall_finder.support();
      const Box structure = box_around(boundary.surface.position);
      append_seen(position.size(), first, rows, [&](std::size_t i, std::vector<int>& seen) {
        const View view = look(boundary.walls, structure, support, blended * spacing, position[i]);
        if (!view.empty && view.plane < 0 && !view.planes_alone) see(i, seen);  // a plane is the inside of a container, of one side
      });
      return;
    }
  }
  append_seen(position.size(), first, rows, see);
}

template <int D>
void leave_dry_planes(const std::vector<Vector<D>>& position, Boundary<D>& boundary) {
  FaceRows& rows = boundary.wall_rows;
  if constexpr (D == 3) {
    if (rows.plane.empty()) return;
    const double support = boundary.wall_finder.support();
    const auto& planes = boundary.walls.planes();
    // dry[corner (a, b) of the grid]: of the patches before column a and row b.
    std::vector<int>& dry = boundary.dry_patches;
    std::size_t corners = 0;
    const auto width_of = [](const PlaneWall& plane) { return plane.held.to[0] - plane.held.from[0] + 1; };
    const auto corners_of = [&](const PlaneWall& plane) {
      return static_cast<std::size_t>(width_of(plane)) * (plane.held.to[1] - plane.held.from[1] + 1);
    };
    for (const PlaneWall& plane : planes) corners += corners_of(plane);
    dry.resize(corners);
    std::vector<std::size_t>& first_corner = boundary.first_corner;
    first_corner.clear();
    corners = 0;
    const Bounds<3> particles =
        boundary.walls.whole() ? Bounds<3>::everywhere() : Bounds<3>::around(std::span(position).first(rows.plane.size()));
    for (std::size_t p = 0; p < planes.size(); ++p) {
      const PlaneWall& plane = planes[p];
      const auto [from, to] = part_near(plane, support, particles);
      first_corner.push_back(corners);
      corners += corners_of(plane);
      if (from[0] >= to[0] || from[1] >= to[1]) continue;
      const int width = width_of(plane), columns = to[0] - from[0];
      const auto row_at = [&](int b) {  // its corner (from[0], b)
        return dry.data() + first_corner.back() + static_cast<std::ptrdiff_t>(b - plane.held.from[1]) * width +
               (from[0] - plane.held.from[0]);
      };
      std::fill(row_at(from[1]), row_at(from[1]) + columns + 1, 0);
      for (int b = from[1] + 1; b <= to[1]; ++b) {
        const double* const wet = rows.wet.data() + plane.patch(from[0], b - 1);
        int* const at = row_at(b);
        int of_row = 0;
        at[0] = 0;
        for (int a = 1; a <= columns; ++a) {
          of_row += static_cast<int>(whole_patch * (1 - wet[a - 1]));
          at[a] = at[a - width] + of_row;
        }
      }
    }
    // Of the patches before these places, counted in patches, with parts of patches.
    const auto dry_before = [&](int p, double row, double column) {
      const GridPart& held = planes[p].held;
      const int width = width_of(planes[p]);
      const int b = std::min(static_cast<int>(row), held.to[1] - 1), a = std::min(static_cast<int>(column), held.to[0] - 1);
      const int* const at = dry.data() + first_corner[p] + static_cast<std::ptrdiff_t>(b - held.from[1]) * width + (a - held.from[0]);
      const double below = at[0] + (column - a) * (at[1] - at[0]), above = at[width] + (column - a) * (at[width + 1] - at[width]);
      return below + (row - b) * (above - below);
    };
    const auto dry_around = [&](int p, const Vector<3>& x) {
      const PlaneWall& plane = planes[p];
      const double height = plane.height(x), reach = std::sqrt(std::max(0.0, support * support - height * height));
      double from[2], to[2];
      for (int c = 0; c < 2; ++c) {
        const double middle = (x[plane.along[c]] - plane.low[c]) / plane.step[c], half = reach / plane.step[c] + 0.5;
        from[c] = std::clamp(middle - half, 0.0, static_cast<double>(plane.count[c]));
        to[c] = std::clamp(middle + half, 0.0, static_cast<double>(plane.count[c]));
      }
      return (dry_before(p, to[1], to[0]) - dry_before(p, from[1], to[0])) -
             (dry_before(p, to[1], from[0]) - dry_before(p, from[1], from[0]));
    };
    for (std::size_t i = 0; i < rows.plane.size(); ++i) {
      if (rows.plane[i] < 0) continue;
      const bool listed = !rows.before_plane(static_cast<std::ptrdiff_t>(i));
      if (const double dry_here = dry_around(rows.plane[i], position[i]); dry_here > rounding)
        rows.plane_share[i] *= std::clamp(1 - dry_here / (whole_patch * dry_patches), 0.0, 1.0);
      if (rows.plane_share[i] < 1 && !listed) {
        rows.begin[i] = static_cast<int>(rows.face.size());
        list_patches(planes[rows.plane[i]], support, position[i], rows.face);
        rows.count[i] = static_cast<int>(rows.face.size()) - rows.begin[i];
      }
      // Just within reach of the plane there may be no patch to share with, nor anything of the plane to be shared.
      if (rows.plane_share[i] == 0 || rows.count[i] == 0) rows.plane[i] = -1;
    }
    rows.weight.resize(rows.face.size());
  }
}

#define TERN_INSTANTIATE(D)                                                                                             \
  template void see_walls<D>(double, std::span<const Vector<D>>, Boundary<D>&);                                         \
  template void see_two_sided_walls<D>(double, std::span<const Vector<D>>, std::size_t, const Boundary<D>&, FaceRows&); \
  template void leave_dry_planes<D>(const std::vector<Vector<D>>&, Boundary<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
