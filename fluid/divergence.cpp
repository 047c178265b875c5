// Velocity divergence, with S_i = sum_F V_j (u_j - u_i) grad w_ij^T (difference form, zero for constants):
//   inside:            div_i = tr(S_i C_i)                                exact for linear fields
//   in the sum form:   div_i = tr S_i                                     the adjoint of that form of the pressure gradient
//   at faces also:     - 2 sum_k A_k w~_ik n_k . (u_k - u_i)  +  tr(T_i S_i C^F_i)
// The factor 2 is the mirror velocity 2 u_k - u_i of the hidden side; without it half the flux through a wall is lost. Along
// a face the velocity behind it varies as that before it: without T, the part of the moments along hidden faces, fluid that
// stretches along a wall and thins towards it would seem to be compressed, by a quarter of the rate at which it stretches.

#include "fluid/fluid.hpp"
#include "fluid/velocity_gradient.hpp"
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

/// tr(A B)
template <int D>
double trace_of_product(const Matrix<D>& a, const Matrix<D>& b) {
  return a.cwiseProduct(b.transpose()).sum();
}

}  // namespace

template <int D>
void Fluid<D>::compute_divergence() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  divergence_.resize(n);
  pack<D>(predicted_position_, predicted_velocity_, motion_);
  period_.specialise([&](auto periodic) {
    const PackedPeriod<decltype(periodic)::value, D> period(period_);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      const Matrix<D> sum = velocity_gradient_sum(neighbours_, period, motion_, i);
      const bool at_wall = wall_rows_.count[i] > 0, at_structure = surface_rows_.count[i] > 0;
      if (!at_wall && !at_structure) {
        divergence_[i] = sum_form_[i] ? sum.trace() : trace_of_product<D>(sum, fluid_correction_[i]);
        continue;
      }
      double divergence = sum.trace() + trace_of_product<D>(boundary_.tangential[i], sum * fluid_correction_[i]);
      if (at_wall) divergence += through_faces<D>(walls_.faces(), wall_rows_, i, predicted_velocity_[i]);
      if (at_structure) divergence += through_faces<D>(surface_, surface_rows_, i, predicted_velocity_[i]);
      divergence_[i] = divergence;
    }
  });
}

template void Fluid<2>::compute_divergence();
template void Fluid<3>::compute_divergence();

}  // namespace tern::fluid
