#include "fluid/boundary/boundary_sums.hpp"

#include <algorithm>

#include <omp.h>

#include "base/parallel.hpp"
#include "fluid/boundary/hidden_sums.hpp"
#include "fluid/boundary/line_of_sight.hpp"

namespace tern::fluid {

namespace {

/// Sums over the patches that a particle sees, or with its share the sums behind the plane wall that is all it sees.
template <int D>
HiddenSums<D> sum_hidden_by_walls(const Constants<D>& constants, const Vector<D>& x, const Faces<D>& faces, std::ptrdiff_t i,
                                  FaceRows& rows) {
  if constexpr (D == 3) {
    if (rows.before_plane(i)) {
      const int k = rows.face[rows.begin[i]];
      const double height = (x - faces.position[k]).dot(faces.normal[k]);
      const HiddenSums<D> behind = sum_behind_plane(constants, height, faces.normal[k]);
      rows.height[i] = (1 - 1e-6) * height;
      rows.weight[rows.begin[i]] = behind.gradient.dot(faces.normal[k]);
      return behind;
    }
    HiddenSums<D> hidden = sum_hidden(constants, x, faces, i, rows);
    if (rows.plane.empty() || rows.plane[i] < 0) return hidden;
    const int k = rows.face[rows.begin[i]];
    const HiddenSums<D> behind = sum_behind_plane(constants, (x - faces.position[k]).dot(faces.normal[k]), faces.normal[k]);
    const double share = rows.plane_share[i];
    hidden.density += share * (behind.density - hidden.density);
    hidden.moment += share * (behind.moment - hidden.moment);
    hidden.across += share * (behind.across - hidden.across);
    return hidden;  // the sums of weights are those of patches to 1e-5
  } else {
    return sum_hidden(constants, x, faces, i, rows);
  }
}

}  // namespace

template <int D>
void set_wall_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                   const Faces<D>& faces, FaceRows& rows, BoundarySums<D>& sums) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(rows.begin.size());
  for (auto* v : {&sums.number_density, &sums.flux}) v->resize(n);
  for (auto* m : {&sums.moment, &sums.tangential}) m->resize(n);
  for (auto* v : {&sums.wall_gradient, &sums.mirrored_hydrostatic, &sums.back_facing_gradient, &sums.unborne_gradient}) v->resize(n);
  parallel_for(n, [&](std::ptrdiff_t i) {
    const HiddenSums<D> hidden = sum_hidden_by_walls(constants, position[i], faces, i, rows);
    sums.number_density[i] = hidden.density;
    sums.moment[i] = hidden.moment;
    sums.tangential[i] = hidden.moment - hidden.across;
    sums.wall_gradient[i] = -hidden.gradient;
    // A wall fixes the pressure gradient along its normal only. Along the face the fluid behind the mirror has the
    // gradient of the fluid before it, whatever that is: none in a free fall along the wall.
    sums.mirrored_hydrostatic[i] = constants.density * (hidden.across * gravity[i] - hidden.accelerated);
    sums.back_facing_gradient[i].setZero();
    sums.unborne_gradient[i].setZero();
    sums.flux[i] = hidden.flux;
  });
}

namespace {

/// What faces put on a particle at x where quantities vary linearly: -2 sum_k A_k w~ n_k (x_k - x)^T.
template <int D>
Matrix<D> linear_moment(const Vector<D>& x, const Faces<D>& faces, const FaceRows& rows, std::ptrdiff_t i) {
  Matrix<D> sum = Matrix<D>::Zero();
  for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry)
    sum -= (2 * rows.weight[entry]) * faces.normal[rows.face[entry]] * (faces.position[rows.face[entry]] - x).transpose();
  return sum;
}

/// Takes the cone behind a back-facing face at d from a particle from what is hidden from it. `wet`: share of the face.
template <int D>
void uncover(const Constants<D>& constants, const Vector<D>& d, const Vector<D>& normal, double area, double wet, double& density,
             Matrix<D>& moment) {
  const double r = d.norm(), angle = wet * subtended_angle<D>(d, Vector<D>(-normal), area);
  density -= angle * constants.faces.hidden_density(r);
  moment -= (angle * constants.faces.hidden_moment(r) / (r * r)) * d * d.transpose();
}

/// Beside a corner: takes the cones behind back-facing faces from what is hidden from particle i at x, and sets what the interface does
/// not bear of its sums.
template <int D>
void close_round_corner(const Constants<D>& constants, const Vector<D>& x, const Vector<D>& gravity, const Faces<D>& faces,
                        const FaceRows& rows, std::ptrdiff_t i, const std::vector<int>& back_facing, HiddenSums<D>& hidden,
                        std::vector<BackFacing>& kept, BoundarySums<D>& sums) {
  Matrix<D> unborne = Matrix<D>::Zero();
  for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
    const int k = rows.face[entry];
    const double left = 1 - sums.borne_share[k];
    unborne -= (2 * left * rows.weight[entry]) * faces.normal[k] * (faces.position[k] - x).transpose();
    sums.unborne_gradient[i] -= left * rows.weight[entry] * faces.normal[k];
  }
  for (int k : back_facing) {
    const Vector<D> d = faces.position[k] - x;
    uncover<D>(constants, d, faces.normal[k], faces.area[k], rows.wet[k], hidden.density, hidden.moment);
    const double whole = faces.area[k] * constants.faces.surface_weight(d.norm()), weight = rows.wet[k] * whole;
    unborne += 2 * sums.borne_share[k] * weight * faces.normal[k] * d.transpose();
    kept.push_back({static_cast<int>(i), k, whole});
    sums.back_facing_gradient[i] -= weight * faces.normal[k];
    sums.unborne_gradient[i] -= (1 - sums.borne_share[k]) * weight * faces.normal[k];
  }
  sums.mirrored_hydrostatic[i] += constants.density * (unborne * gravity);
}

}  // namespace

/// Whether x is inside the wall rather than past a corner of it: the nearest patch is turned away, and x is right behind it.
template <int D>
bool is_inside(const Vector<D>& x, const Faces<D>& walls, const int* seen, int count, const std::vector<int>& back_facing) {
  const auto distance2 = [&](int k) { return (walls.position[k] - x).squaredNorm(); };
  double nearest2 = 1e300;
  int nearest = -1;
  for (int k : back_facing)
    if (const double here = distance2(k); here < nearest2) nearest = k, nearest2 = here;
  if (nearest < 0 || std::any_of(seen, seen + count, [&](int k) { return distance2(k) < nearest2; })) return false;
  const double depth = (walls.position[nearest] - x).dot(walls.normal[nearest]);
  return nearest2 - depth * depth < patch_reach2<D>(walls.area[nearest]);
}

template <int D>
void close_round_wall_corners(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                              const Faces<D>& walls, const FaceFinder<D>& finder, const FaceRows& rows, const Faces<D>& structure,
                              const FaceRows& structure_rows, BoundarySums<D>& sums) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(rows.begin.size());
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  const std::vector<std::uint8_t> none_covered;
  sums.corner_scratch.resize(std::max<std::size_t>(threads, sums.corner_scratch.size()));
  const bool moving = !walls.normal_acceleration.empty();
  if (moving) sums.back_facing_acceleration.assign(n, 0);
#pragma omp parallel num_threads(threads)
  {
    CornerView<D> corners(walls, finder, none_covered, constants.faces, sums.corner_scratch[omp_get_thread_num()]);
#pragma omp for schedule(static)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      if (rows.count[i] == 0 || rows.before_plane(i)) continue;
      const Vector<D>& x = position[i];
      const int* const seen = rows.face.data() + rows.begin[i];
      corners.look(x, seen, rows.count[i]);
      if (is_inside(x, walls, seen, rows.count[i], corners.back_facing())) continue;
      bool any = false;
      for (int k : corners.back_facing()) {
        if (rows.wet[k] == 0 || any_separates(structure, structure_rows, i, x, walls.position[k])) continue;
        any = true;
        const Vector<D> d = walls.position[k] - x;
        uncover<D>(constants, d, walls.normal[k], walls.area[k], rows.wet[k], sums.number_density[i], sums.moment[i]);
        const double weight = rows.wet[k] * walls.area[k] * constants.faces.surface_weight(d.norm());
        sums.back_facing_gradient[i] -= weight * walls.normal[k];
        sums.unborne_gradient[i] -= weight * walls.normal[k];
        if (moving) sums.back_facing_acceleration[i] += weight * walls.normal_acceleration[k];
      }
      if (!any) continue;
      // There is no one normal across which the fluid is mirrored: of each face what it puts on the particle where quantities vary linearly
      // along its normal.
      Matrix<D> across = Matrix<D>::Zero();
      Vector<D> accelerated = Vector<D>::Zero();
      for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
        const int k = rows.face[entry];
        const Vector<D>& normal = walls.normal[k];
        const double twice = -2 * rows.weight[entry] * (walls.position[k] - x).dot(normal);
        across += twice * normal * normal.transpose();
        accelerated += (twice * walls.acceleration_of(k)) * normal;
      }
      sums.tangential[i] = sums.moment[i] - across;
      sums.mirrored_hydrostatic[i] = constants.density * (across * gravity[i] - accelerated);
    }
  }
}

template <int D>
void add_surface_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                      const Faces<D>& faces, const FaceFinder<D>& finder, const std::vector<std::uint8_t>& covered, FaceRows& rows,
                      BoundarySums<D>& sums) {
  for (auto& of_thread : sums.back_facing) of_thread.clear();
  sums.surface_gradient.clear();
  if (rows.face.empty()) return;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(rows.begin.size()), count = static_cast<std::ptrdiff_t>(faces.size());
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  sums.borne_share.assign(count, 1);
  // Shares are asked for of the faces that a particle sees, and of others within its support.
  sums.cell_sees.assign(finder.cells(), 0);
  for (std::ptrdiff_t i = 0; i < n; ++i)
    if (rows.count[i] > 0) sums.cell_sees[finder.cell(position[i])] = 1;
  sums.corner_scratch.resize(std::max<std::size_t>(threads, sums.corner_scratch.size()));
  sums.linear_moment.resize(n);
  sums.surface_gradient.assign(n, Vector<D>::Zero());
  sums.back_facing.resize(threads);
#pragma omp parallel num_threads(threads)
  {
    CornerView<D> corners(faces, finder, covered, constants.faces, sums.corner_scratch[omp_get_thread_num()]);
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < count; ++k)
      if (finder.any_marked_around(faces.position[k], sums.cell_sees)) sums.borne_share[k] = corners.borne_share(static_cast<int>(k));
#pragma omp for schedule(static)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      if (rows.count[i] == 0) continue;
      HiddenSums<D> hidden = sum_hidden(constants, position[i], faces, i, rows);
      const int* const seen = rows.face.data() + rows.begin[i];
      corners.look(position[i], seen, rows.count[i]);
      if (!corners.back_facing().empty() || std::any_of(seen, seen + rows.count[i], [&](int k) { return sums.borne_share[k] != 1; }))
        close_round_corner<D>(constants, position[i], gravity[i], faces, rows, i, corners.back_facing(), hidden,
                              sums.back_facing[omp_get_thread_num()], sums);
      sums.number_density[i] += hidden.density;
      sums.moment[i] += hidden.moment;
      const Matrix<D> linear = linear_moment(position[i], faces, rows, i);
      if (!corners.back_facing().empty()) hidden.across = linear;  // there is no one normal across which the fluid is mirrored
      sums.tangential[i] += hidden.moment - hidden.across;
      sums.linear_moment[i] = linear - hidden.across;
      sums.surface_gradient[i] = -hidden.gradient;
      sums.flux[i] += hidden.flux;
    }
  }
}

#define TERN_INSTANTIATE(D)                                                                                                             \
  template void set_wall_sums<D>(const Constants<D>&, const std::vector<Vector<D>>&, const std::vector<Vector<D>>&, const Faces<D>&,    \
                                 FaceRows&, BoundarySums<D>&);                                                                          \
  template void close_round_wall_corners<D>(const Constants<D>&, const std::vector<Vector<D>>&, const std::vector<Vector<D>>&,          \
                                            const Faces<D>&, const FaceFinder<D>&, const FaceRows&, const Faces<D>&, const FaceRows&,   \
                                            BoundarySums<D>&);                                                                          \
  template void add_surface_sums<D>(const Constants<D>&, const std::vector<Vector<D>>&, const std::vector<Vector<D>>&, const Faces<D>&, \
                                    const FaceFinder<D>&, const std::vector<std::uint8_t>&, FaceRows&, BoundarySums<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
