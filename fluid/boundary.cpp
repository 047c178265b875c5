#include "fluid/boundary.hpp"

#include "particles/parallel.hpp"

namespace tern::fluid {
namespace {

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
      const double angle = subtended_angle<D>(d, faces.normal[k], faces.area[k]);
      term(i, k, Vector<D>(d / r), angle * constants.faces.hidden_density(r), angle * constants.faces.hidden_moment(r),
           rows.weight[entry]);
    }
}

}  // namespace

template <int D>
void BoundarySums<D>::reset(std::size_t n) {
  number_density.assign(n, 0);
  moment.assign(n, Matrix<D>::Zero());
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
void add_wall_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                   const Faces<D>& faces, const FaceRows& rows, BoundarySums<D>& sums) {
  for_hidden(constants, position, faces, rows,
             [&](std::ptrdiff_t i, int k, const Vector<D>& e, double density, double moment, double weight) {
               sums.number_density[i] += density;
               sums.moment[i] += moment * e * e.transpose();
               sums.wall_gradient[i] -= weight * faces.normal[k];
               // A slip wall can hold a pressure gradient only along its normal: its tangential acceleration is not felt.
               const Vector<D> acceleration = gravity[i] - faces.normal_acceleration[k] * faces.normal[k];
               sums.wall_hydrostatic[i] += constants.density * moment * e.dot(acceleration) * e;
             });
}

template <int D>
void add_surface_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& faces,
                      const FaceRows& rows, BoundarySums<D>& sums) {
  for_hidden(constants, position, faces, rows,
             [&](std::ptrdiff_t i, int k, const Vector<D>& e, double density, double moment, double weight) {
               sums.number_density[i] += density;
               sums.moment[i] += moment * e * e.transpose();
               sums.surface_gradient[i] -= weight * faces.normal[k];
             });
}

#define TERN_INSTANTIATE(D)                                                                                             \
  template struct BoundarySums<D>;                                                                                      \
  template void see_faces<D>(const Constants<D>&, const std::vector<Vector<D>>&, const Faces<D>&, const FaceFinder<D>&, \
                             FaceRows&);                                                                                \
  template void add_wall_sums<D>(const Constants<D>&, const std::vector<Vector<D>>&, const std::vector<Vector<D>>&,     \
                                 const Faces<D>&, const FaceRows&, BoundarySums<D>&);                                   \
  template void add_surface_sums<D>(const Constants<D>&, const std::vector<Vector<D>>&, const Faces<D>&,                \
                                    const FaceRows&, BoundarySums<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
