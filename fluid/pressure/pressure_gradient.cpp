// Acceleration by the pressure gradient, a_i = -G_i / rho. With B_i = sum_F V_j (p_j - p_i) grad w_ij:
//   blended:    G = C_i (B_i + H_i) + 2 theta p^_i sum V grad w,   p^_i = min(max(p_i, 0), 20 dx |C_i (B_i + H_i)|)
//   sum form:   G = B_i + H_i + T_i C^F_i B_i + 2 p_i sum V grad w                  = sum V_j (p_j + p_i) grad w_ij
// A wall mirrors the pressure: along its normal p_w = p_i + rho (g - a_w) . (r_w - r_i), which gives H_i, along its face
// with the fluid's own gradient, which C_i finds (blended form) or T_i completes (sum form). The sum form conserves momentum
// pair by pair and is used at the free surface and at the structure; the blended form is exact for linear fields and used
// inside.

#include "base/parallel.hpp"
#include "fluid/fluid.hpp"

namespace tern::fluid {
namespace {

/// The regularising part takes no more pressure than this many layers of the local gradient make up. It answers to the
/// level of the pressure, not to its differences, so in deep water, on disordered particles, it would outweigh the projection.
constexpr double most_layers = 20;

}  // namespace

template <int D>
void Fluid<D>::apply_pressure_gradient(Where where) {
  const bool at_structure = where == Where::at_structure;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(at_structure ? band_.size() : state_.size());
  const double theta = constants_.numerics.blend_theta, scale = -duration_s_ / constants_.density;
  const double* pressure = state_.pressure.data();
  period_.specialise([&](auto periodic) {
    const PackedPeriod<decltype(periodic)::value, D> period(period_);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
    for (std::ptrdiff_t m = 0; m < n; ++m) {
      const std::ptrdiff_t i = at_structure ? band_[m] : m;
      if (!active_[i] || (surface_rows_.count[i] > 0) != at_structure) continue;
      const Packed<D> x = motion_[i].position;  // as the divergence left them
      const double p = pressure[i];
      Packed<D> even = Packed<D>::Zero(), odd = Packed<D>::Zero();
      for_row_in_turns(neighbours_, i, even, odd, [&](Packed<D>& sum, int k) {
        const int j = neighbours_.column[k];
        sum += neighbours_.weight[k] * (pressure[j] - p) * period.between(x, motion_[j].position);
      });
      Vector<D> difference;
      for (int c = 0; c < D; ++c) difference[c] = even[c] + odd[c];
      const Vector<D> kernel_gradient = neighbours_.kernel_gradient[i] + boundary_.wall_gradient[i] + boundary_.unborne_gradient[i];
      if (wall_rows_.count[i] > 0 || surface_rows_.count[i] > 0) {
        if (sum_form_[i]) difference += boundary_.tangential[i] * (fluid_correction_[i] * difference);
        difference += boundary_.mirrored_hydrostatic[i];
      }
      Vector<D> gradient;
      if (sum_form_[i]) {
        gradient = difference + 2 * p * kernel_gradient;
      } else {
        gradient = correction_[i] * difference;
        const double regularising = std::min(std::max(p, 0.0), most_layers * constants_.spacing * gradient.norm());
        gradient += 2 * theta * regularising * kernel_gradient;
      }
      predicted_velocity_[i] += scale * gradient;
    }
  });
}

template void Fluid<2>::apply_pressure_gradient(Where);
template void Fluid<3>::apply_pressure_gradient(Where);

}  // namespace tern::fluid
