// Acceleration by the pressure gradient, a_i = -G_i / rho. With B_i = sum_F V_j (p_j - p_i) grad w_ij:
//   blended:    G = C_i (B_i + H_i) + 2 theta p^_i sum V grad w,   p^_i = min(max(p_i, 0), 20 dx |C_i (B_i + H_i)|)
//   symmetric:  G = B_i + H_i + T_i C^F_i B_i + 2 p_i sum V grad w                  = sum V_j (p_j + p_i) grad w_ij
// A wall mirrors the pressure: along its normal p_w = p_i + rho (g - a_w) . (r_w - r_i), which gives H_i, along its face
// with the fluid's own gradient, which C_i finds (blended form) or T_i completes (symmetric form). The symmetric form conserves momentum
// pair by pair and is used at the free surface and at the structure; the blended form is exact for linear fields and used
// inside.

#include "fluid/pressure/pressure_gradient.hpp"

#include <algorithm>

#include "base/parallel.hpp"

namespace tern::fluid {
namespace {

/// The regularising part takes no more pressure than this many layers of the local gradient make up. It answers to the
/// level of the pressure, not to its differences, so in deep water, on disordered particles, it would outweigh the projection.
constexpr double most_layers = 20;

}  // namespace

template <int D>
void apply_pressure_gradient(const Reference<D>& reference, double duration, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                             const Corrections<D>& correction, const State<D>& state, const std::vector<Motion<D>>& motion,
                             const std::vector<int>* only, std::vector<Vector<D>>& velocity) {
  const Constants<D>& constants = reference.constants;
  const bool at_structure = only != nullptr;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(at_structure ? only->size() : state.size());
  const double theta = constants.numerics.blend_theta, scale = -duration / constants.density;
  const double* pressure = state.pressure.data();
  reference.period.specialise([&](auto periodic) {
    const PackedPeriod<decltype(periodic)::value, D> period(reference.period);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
    for (std::ptrdiff_t m = 0; m < n; ++m) {
      const std::ptrdiff_t i = at_structure ? (*only)[m] : m;
      if (!state.particle_class[i].pressure_unknown() || boundary.sees_structure(i) != at_structure) continue;
      const Packed<D> x = motion[i].position;
      const double p = pressure[i];
      Packed<D> even = Packed<D>::Zero(), odd = Packed<D>::Zero();
      for_row_in_turns(neighbours, i, even, odd, [&](Packed<D>& sum, int k) {
        const int j = neighbours.column[k];
        sum += neighbours.weight[k] * (pressure[j] - p) * period.between(x, motion[j].position);
      });
      Vector<D> difference;
      for (int c = 0; c < D; ++c) difference[c] = even[c] + odd[c];
      const Vector<D> kernel_gradient = neighbours.kernel_gradient[i] + boundary.sums.wall_gradient[i] + boundary.sums.unborne_gradient[i];
      if (boundary.sees_face(i)) {
        if (state.particle_class[i].has(ParticleClass::symmetric_gradient))
          difference += boundary.sums.tangential[i] * (correction.fluid[i] * difference);
        difference += boundary.sums.mirrored_hydrostatic[i];
      }
      Vector<D> gradient;
      if (state.particle_class[i].has(ParticleClass::symmetric_gradient)) {
        gradient = difference + 2 * p * kernel_gradient;
      } else {
        gradient = correction.matrix[i] * difference;
        const double regularising = std::min(std::max(p, 0.0), most_layers * constants.spacing * gradient.norm());
        gradient += 2 * theta * regularising * kernel_gradient;
      }
      velocity[i] += scale * gradient;
    }
  });
}

template void apply_pressure_gradient<2>(const Reference<2>&, double, const Neighbours<2>&, const Boundary<2>&, const Corrections<2>&,
                                         const State<2>&, const std::vector<Motion<2>>&, const std::vector<int>*, std::vector<Vector<2>>&);
template void apply_pressure_gradient<3>(const Reference<3>&, double, const Neighbours<3>&, const Boundary<3>&, const Corrections<3>&,
                                         const State<3>&, const std::vector<Motion<3>>&, const std::vector<int>*, std::vector<Vector<3>>&);

}  // namespace tern::fluid
