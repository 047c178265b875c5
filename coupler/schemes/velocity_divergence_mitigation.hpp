#pragma once
// Velocity-divergence-error-mitigating (VEM) pressure at the interface (seed paper eq. 7):
//   p_i = -rho_i C h |u|max div_i(u),    F_ij = p_j + p_i  where p_i >= 0,  p_j - p_i  elsewhere
// As printed, the two sides of a pair choose their F by different signs, and their forces do not cancel. The forms that
// conserve momentum give both sides one F, with the pressure of the fluid particle mirrored on the surface.

#include <algorithm>
#include <vector>

#include "coupler/schemes/interface_pairs.hpp"
#include "scene/case_file.hpp"

namespace tern::coupler {

/// F/2 on either side of a pair; the vectors b_ik of interface_pairs.hpp carry the 2 [Pa].
struct MitigationPressure {
  double on_fluid, on_structure;
};

/// From the pressures p_i of both sides [Pa]; `structure` is used by the seed form only.
inline MitigationPressure mitigation_pressure(VemForm form, double fluid, double structure) {
  switch (form) {
    case VemForm::seed: return {0.5 * (structure + std::abs(fluid)), 0.5 * (fluid + std::abs(structure))};
    case VemForm::sum: return {fluid, fluid};
    default: return {std::max(fluid, 0.0), std::max(fluid, 0.0)};
  }
}

/// Velocity divergence at the surface points, sum V_i (u_i - u_k) . grad w_ki over the fluid they see [1/s]. The section
/// behind a point moves with it and adds nothing.
template <int D>
std::vector<double> divergence_at_surface(const Kernel<D>& kernel, std::span<const InterfacePair<D>> pairs, const Surface<D>& surface,
                                          const InterfaceParticles<D>& band) {
  std::vector<double> divergence(surface.position.size(), 0);
  for (const auto& pair : pairs) {
    const Vector<D>& d = pair.offset;
    divergence[pair.point] +=
        band.volume[pair.particle] * kernel.gradient_weight(d.norm()) * d.dot(band.velocity[pair.particle] - surface.velocity[pair.point]);
  }
  return divergence;
}

}  // namespace tern::coupler
