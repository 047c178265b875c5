// Velocity divergence, with S_i = sum_F V_j (u_j - u_i) grad w_ij^T (difference form, zero for constants):
//   inside:            div_i = tr(S_i C_i)                                exact for linear fields
//   in the sum form:   div_i = tr S_i                                     the adjoint of that form of the pressure gradient
//   at faces also:     - 2 sum_k A_k w~_ik n_k . (u_k - u_i)  +  T_i : S_i C^F_i
// The factor 2 is the mirror velocity 2 u_k - u_i of the hidden side; without it half the flux through a wall is lost. Along
// a face the velocity behind it varies as that before it: without T, the part of the moments along hidden faces, fluid that
// stretches along a wall and thins towards it would seem to be compressed, by a quarter of the rate at which it stretches.

#include "base/parallel.hpp"
#include "fluid/fluid.hpp"
#include "fluid/motion/velocity_gradient.hpp"

namespace tern::fluid {
namespace {

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
      if (wall_rows_.count[i] == 0 && surface_rows_.count[i] == 0) {
        divergence_[i] = sum_form_[i] ? sum.trace() : trace_of_product<D>(sum, fluid_correction_[i]);
        continue;
      }
      const double through_faces =
          boundary_.flux[i] + predicted_velocity_[i].dot(boundary_.wall_gradient[i] + boundary_.surface_gradient[i]);
      divergence_[i] = sum.trace() + boundary_.tangential[i].cwiseProduct(sum * fluid_correction_[i]).sum() - 2 * through_faces;
    }
  });
}

template void Fluid<2>::compute_divergence();
template void Fluid<3>::compute_divergence();

}  // namespace tern::fluid
