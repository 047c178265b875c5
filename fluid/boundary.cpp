#include "fluid/boundary.hpp"

#include <algorithm>

#include "particles/parallel.hpp"

namespace tern::fluid {
namespace {

/// Wet share of a face as a function of the filled share of the space in front of it: half wet where that is half filled,
/// as at the edge of a flat surface, dry below a quarter and wet above three quarters.
double wet_share(double filled) { return std::clamp(2 * filled - 0.5, 0.0, 1.0); }

/// A point just in front of a face, so that the face's own half space counts as hidden.
template <int D>
Vector<D> just_before(const Constants<D>& constants, const Faces<D>& faces, std::size_t k) {
  return faces.position[k] + 1e-3 * constants.spacing * faces.normal[k];
}

/// Part of sum V w at x that lies behind the faces seen from there.
template <int D>
double hidden_density(const Constants<D>& constants, const Faces<D>& faces, const FaceFinder<D>& finder, const Vector<D>& x) {
  std::vector<int> seen;
  finder.see(faces, x, seen);
  double sum = 0;
  for (int k : seen) {
    const Vector<D> d = faces.position[k] - x;
    sum += subtended_angle<D>(d, faces.normal[k], faces.area[k]) * constants.faces.hidden_density(d.norm());
  }
  return sum;
}

/// Calls term(i, k, e, density, moment, weight) for every face k that particle i sees: unit vector e from i to k, the hidden
/// parts of sum V w and tr M in the cone behind k, and the weight of its normal in sum grad w.
template <int D, class Term>
void for_hidden(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& faces,
                const FaceRows& rows, Term&& term) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(position.size());
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i)
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
      const int k = rows.face[entry];
      const Vector<D> d = faces.position[k] - position[i];
      const double r = d.norm();
      const double wet = rows.wet.empty() ? 1 : rows.wet[k];
      if (wet == 0) continue;
      const double angle = wet * subtended_angle<D>(d, faces.normal[k], faces.area[k]);
      term(i, k, Vector<D>(d / r), angle * constants.faces.hidden_density(r), angle * constants.faces.hidden_moment(r),
           rows.weight[entry]);
    }
}

}  // namespace

template <int D>
void BoundarySums<D>::reset(std::size_t n) {
  number_density.assign(n, 0);
  for (auto* m : {&moment, &tangential}) m->assign(n, Matrix<D>::Zero());
  for (auto* v : {&wall_gradient, &wall_hydrostatic, &surface_gradient}) v->assign(n, Vector<D>::Zero());
}

template <int D>
void see_faces(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& faces,
               const FaceFinder<D>& finder, FaceRows& rows) {
  rows.begin.resize(position.size());
  rows.count.resize(position.size());
  rows.face.clear();
  for (std::size_t i = 0; i < position.size(); ++i) {
    rows.begin[i] = static_cast<int>(rows.face.size());
    finder.see(faces, position[i], rows.face);
    rows.count[i] = static_cast<int>(rows.face.size()) - rows.begin[i];
  }
  rows.weight.resize(rows.face.size());
  for (std::size_t i = 0; i < position.size(); ++i)
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
      const int k = rows.face[entry];
      rows.weight[entry] = faces.area[k] * constants.faces.surface_weight((faces.position[k] - position[i]).norm());
    }
}

template <int D>
void space_before_walls(const Constants<D>& constants, const Faces<D>& walls, const FaceFinder<D>& finder, std::vector<double>& space) {
  const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(walls.size());
  space.resize(walls.size());
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t k = 0; k < count; ++k)
    space[k] = constants.lattice.density - hidden_density(constants, walls, finder, just_before(constants, walls, k));
}

template <int D>
void leave_out_dry_walls(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& walls,
                         const std::vector<double>& space, const Faces<D>& structure, const FaceFinder<D>& structure_finder,
                         FaceRows& wall_rows) {
  wall_rows.wet.assign(walls.size(), 0);
  for (std::size_t i = 0; i < position.size(); ++i)
    for (int entry = wall_rows.begin[i]; entry < wall_rows.begin[i] + wall_rows.count[i]; ++entry) {
      const int k = wall_rows.face[entry];
      wall_rows.wet[walls.original[k]] += constants.volume * constants.kernel.value((walls.position[k] - position[i]).norm());
    }
  for (std::size_t k = 0; k < walls.size(); ++k) {
    const auto original = static_cast<std::size_t>(walls.original[k]);
    if (original != k) {
      wall_rows.wet[k] = wall_rows.wet[original];  // an image comes after its original
    } else if (wall_rows.wet[k] > 0) {
      const double hidden = hidden_density(constants, structure, structure_finder, just_before(constants, walls, k));
      wall_rows.wet[k] = wet_share(wall_rows.wet[k] / std::max(space[k] - hidden, 0.02));
    }
  }
  for (std::size_t entry = 0; entry < wall_rows.face.size(); ++entry) wall_rows.weight[entry] *= wall_rows.wet[wall_rows.face[entry]];
}

template <int D>
void add_wall_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                   const Faces<D>& faces, const FaceRows& rows, BoundarySums<D>& sums) {
  for_hidden(constants, position, faces, rows,
             [&](std::ptrdiff_t i, int k, const Vector<D>& e, double density, double moment, double weight) {
               const Vector<D>& normal = faces.normal[k];
               const double along_normal = e.dot(normal);
               sums.number_density[i] += density;
               sums.moment[i] += moment * e * e.transpose();
               sums.tangential[i] += moment * e * (e - along_normal * normal).transpose();
               sums.wall_gradient[i] -= weight * normal;
               // A wall fixes the pressure gradient along its normal only. Along the face the fluid behind the mirror has the
               // gradient of the fluid before it, whatever that is: none in a free fall along the wall.
               sums.wall_hydrostatic[i] +=
                   constants.density * moment * along_normal * (gravity[i].dot(normal) - faces.normal_acceleration[k]) * e;
             });
}

template <int D>
void add_surface_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& faces,
                      const FaceRows& rows, BoundarySums<D>& sums) {
  for_hidden(constants, position, faces, rows,
             [&](std::ptrdiff_t i, int k, const Vector<D>& e, double density, double moment, double weight) {
               sums.number_density[i] += density;
               sums.moment[i] += moment * e * e.transpose();
               sums.tangential[i] += moment * e * (e - e.dot(faces.normal[k]) * faces.normal[k]).transpose();
               sums.surface_gradient[i] -= weight * faces.normal[k];
             });
}

#define TERN_INSTANTIATE(D)                                                                                             \
  template struct BoundarySums<D>;                                                                                      \
  template void see_faces<D>(const Constants<D>&, const std::vector<Vector<D>>&, const Faces<D>&, const FaceFinder<D>&, \
                             FaceRows&);                                                                                \
  template void space_before_walls<D>(const Constants<D>&, const Faces<D>&, const FaceFinder<D>&, std::vector<double>&); \
  template void leave_out_dry_walls<D>(const Constants<D>&, const std::vector<Vector<D>>&, const Faces<D>&,              \
                                       const std::vector<double>&, const Faces<D>&, const FaceFinder<D>&, FaceRows&);   \
  template void add_wall_sums<D>(const Constants<D>&, const std::vector<Vector<D>>&, const std::vector<Vector<D>>&,     \
                                 const Faces<D>&, const FaceRows&, BoundarySums<D>&);                                   \
  template void add_surface_sums<D>(const Constants<D>&, const std::vector<Vector<D>>&, const Faces<D>&,                \
                                    const FaceRows&, BoundarySums<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
