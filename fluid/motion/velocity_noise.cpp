// Damping of velocity noise on the scale of the particles. Nothing else in an inviscid projection method takes energy out
// of it: noise fed by irregular particle positions would drive a slow circulation for ever. A pair exchanges momentum
// along its line in proportion to the part of its velocity difference that the linear fields around both do not explain:
//   L_i  = S_i C^F_i,  S_i = sum V_j (u_j - u_i) grad w_ij^T over fluid neighbours
//   du_i = (chi dt / tau) sum_j V_j |w'|/r r_ij [r_ij . (u_j - u_i - (L_i + L_j)/2 r_ij)]
// tau is the time scale of the density source. Affine velocity fields are left as they are, a smooth field of wave number k
// loses of order (chi/tau) (k h)^4 per unit of time. Pairs are antisymmetric and central: both momenta are conserved.
// The reconstruction is that of MUSCL schemes and of the structure's Riemann diffusion.

#include "base/parallel.hpp"
#include "fluid/fluid.hpp"
#include "fluid/motion/velocity_gradient.hpp"

namespace tern::fluid {
namespace {

constexpr double largest_share = 0.5;  ///< per step, for stability

}  // namespace

template <int D>
void Fluid<D>::damp_velocity_noise() {
  const double share = std::min(largest_share, constants_.numerics.noise_damping * duration_s_ / density_time_scale());
  if (share == 0) return;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  evaluations_.noise_damping += n;
  pack<D>(predicted_position_, predicted_velocity_, motion_);
  half_gradient_.resize(n);
  period_.specialise([&](auto periodic) {
    const PackedPeriod<decltype(periodic)::value, D> period(period_);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      half_gradient_[i].fill(Packed<D>::Zero());
      if (!has_gradient_[i]) continue;
      const Matrix<D> gradient = velocity_gradient_sum(neighbours_, period, motion_, i) * fluid_correction_[i];
      for (int b = 0; b < D; ++b)
        for (int a = 0; a < D; ++a) half_gradient_[i][b][a] = 0.5 * gradient(a, b);
    }
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      if (!has_gradient_[i]) continue;
      const Packed<D> x = motion_[i].position, u = motion_[i].velocity;
      const std::array<Packed<D>, D> own = half_gradient_[i];
      Packed<D> even = Packed<D>::Zero(), odd = Packed<D>::Zero();
      for_row_in_turns(neighbours_, i, even, odd, [&](Packed<D>& change, int k) {
        const int j = neighbours_.column[k];
        const Packed<D> r = period.between(x, motion_[j].position);
        Packed<D> jump = motion_[j].velocity - u;
        for (int b = 0; b < D; ++b) jump -= (own[b] + half_gradient_[j][b]) * r[b];
        const double exchange = has_gradient_[j] ? neighbours_.weight[k] * (jump * r).sum() : 0;
        change += exchange * r;
      });
      for (int c = 0; c < D; ++c) predicted_velocity_[i][c] += share * (even[c] + odd[c]);
    }
  });
}

template void Fluid<2>::damp_velocity_noise();
template void Fluid<3>::damp_velocity_noise();

}  // namespace tern::fluid
