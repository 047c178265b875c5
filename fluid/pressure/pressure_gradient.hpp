#pragma once
// Acceleration by the gradient of the pressure.

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// u -= dt/rho G for the pressure of the state: of the particles `only`, which see the structure, or, with nullptr, of all
/// that do not; with or without the part that keeps the particles in order.
template <int D>
void apply_pressure_gradient(const Reference<D>& reference, double duration, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                             const Corrections<D>& correction, const State<D>& state, const std::vector<int>* only, bool with_order,
                             std::vector<Vector<D>>& velocity);

}  // namespace tern::fluid
