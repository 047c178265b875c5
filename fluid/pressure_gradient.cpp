// Acceleration by the pressure gradient, a_i = -G_i / rho. With B_i = sum_F V_j (p_j - p_i) grad w_ij:
//   sum form:   G = B_i + 2 p_i sum V grad w + (hydrostatic part of the walls)      = sum V_j (p_j + p_i) grad w_ij
//   blended:    G = C_i (B_i + hydrostatic part) + 2 theta max(p_i, 0) sum V grad w
// A wall mirrors the pressure, p_w = p_i + rho (g - a_w) . (r_w - r_i). The sum form conserves momentum pair by pair and is
// used at the free surface and at the structure; the blended form is exact for linear fields and used inside.

#include "fluid/fluid.hpp"
#include "particles/parallel.hpp"

namespace tern::fluid {

template <int D>
void Fluid<D>::apply_pressure_gradient() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  const double theta = constants_.numerics.blend_theta, scale = -duration_s_ / constants_.density;
  const Vector<D>* position = predicted_position_.data();
  const double* pressure = state_.pressure.data();
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (!active_[i]) continue;
    const Vector<D> x = position[i];
    const double p = pressure[i];
    Vector<D> difference = boundary_.wall_hydrostatic[i];
    const int last = neighbours_.begin[i] + neighbours_.count[i];
    for (int k = neighbours_.begin[i]; k < last; ++k) {
      const int j = neighbours_.column[k];
      const double weighted = neighbours_.weight[k] * (pressure[j] - p);
      for (int c = 0; c < D; ++c) difference[c] += weighted * (position[j][c] - x[c]);
    }
    const Vector<D> kernel_gradient = neighbours_.kernel_gradient[i] + boundary_.wall_gradient[i];
    const Vector<D> gradient = sum_form_[i]
                                   ? Vector<D>(difference + 2 * p * kernel_gradient)
                                   : Vector<D>(correction_[i] * difference + 2 * theta * std::max(p, 0.0) * kernel_gradient);
    predicted_velocity_[i] += scale * gradient;
  }
}

template void Fluid<2>::apply_pressure_gradient();
template void Fluid<3>::apply_pressure_gradient();

}  // namespace tern::fluid
