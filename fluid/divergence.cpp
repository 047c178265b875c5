// Velocity divergence in difference form:
//   div_i = sum_F V_j grad w_ij . (u_j - u_i)  -  2 sum_k A_k w~_ik n_k . (u_k - u_i)
// The factor 2 is the mirror velocity 2 u_k - u_i of the hidden side; without it half the flux through a wall is lost.

#include "fluid/fluid.hpp"
#include "particles/parallel.hpp"

namespace tern::fluid {
namespace {

template <int D>
double through_faces(const Faces<D>& faces, const FaceRows& rows, std::ptrdiff_t i, const Vector<D>& u) {
  double sum = 0;
  for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
    const int k = rows.face[entry];
    sum -= 2 * rows.weight[entry] * faces.normal[k].dot(faces.velocity[k] - u);
  }
  return sum;
}

}  // namespace

template <int D>
void Fluid<D>::compute_divergence() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  divergence_.resize(n);
  const int* column = neighbours_.column.data();
  const double* weight = neighbours_.weight.data();
  const Vector<D>* position = predicted_position_.data();
  const Vector<D>* velocity = predicted_velocity_.data();
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const Vector<D> x = position[i], u = velocity[i];
    double sum = 0;
    const int last = neighbours_.begin[i] + neighbours_.count[i];
    for (int k = neighbours_.begin[i]; k < last; ++k) {
      const int j = column[k];
      double product = 0;
      for (int c = 0; c < D; ++c) product += (position[j][c] - x[c]) * (velocity[j][c] - u[c]);
      sum += weight[k] * product;
    }
    if (wall_rows_.count[i] > 0) sum += through_faces<D>(walls_.faces(), wall_rows_, i, u);
    if (surface_rows_.count[i] > 0) sum += through_faces<D>(surface_, surface_rows_, i, u);
    divergence_[i] = sum;
  }
}

template void Fluid<2>::compute_divergence();
template void Fluid<3>::compute_divergence();

}  // namespace tern::fluid
