#pragma once
// Velocity-divergence-error-mitigating (VEM) pressure at the interface (seed paper eq. 7):
//   p_i = -rho_i C h |u|max div_i(u),    F_ij = p_j + p_i  where p_i >= 0,  p_j - p_i  elsewhere
// As printed, the two sides of a pair choose their F by different signs, and their forces do not cancel. The forms that
// conserve momentum give both sides one F, with the pressure of the fluid particle mirrored on the surface.

#include <algorithm>
#include <cmath>

#include "coupler/setup.hpp"
#include "scene/case_file.hpp"

namespace tern::coupler {

template <int D>
struct Workspace;
struct Evaluations;

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

/// Adds the forces of this pressure to load and condition of the window, and what they dissipate to its audit. Does nothing where the case
/// leaves it out. Throws BadInput when the fluid has sent no divergence.
template <int D>
void add_velocity_divergence_mitigation(const Setup<D>& setup, Workspace<D>& window, Evaluations& evaluations);

}  // namespace tern::coupler
