#pragma once
// Acceleration by the gradient of the pressure.

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// Whether the symmetric gradient of a particle knows the level of the pressure. In enclosed fluid it does not: there the level works on
/// the faces alone (enclosed_regions.hpp). Elsewhere beside the structure it has differences alone too, but for particles at and next to a
/// free surface, where the level is what the pressure is above that of the air.
template <int D>
bool feels_level(const Constants<D>& constants, ParticleClass own, bool at_structure) {
  if (own.has(ParticleClass::enclosed)) return false;
  return !at_structure || !own.inside() || constants.numerics.gradient == GradientForm::sum;
}

/// u -= dt/rho G for the pressure of the state: of the particles `only`, which see the structure, or, with nullptr, of all
/// that do not. The part that keeps the particles in order is added to `order`: the velocity itself, a vector of its own, or, with
/// nullptr, none.
template <int D>
void apply_pressure_gradient(const Reference<D>& reference, double duration, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                             const Corrections<D>& correction, const State<D>& state, const std::vector<int>* only,
                             std::vector<Vector<D>>& velocity, std::vector<Vector<D>>* order);

}  // namespace tern::fluid
