#pragma once
// Viscosity of the fluid.

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/reference.hpp"

namespace tern::fluid {

/// u* += dt nu lap u^n. `position`: r*; `velocity`: u^n.
template <int D>
void add_viscosity(const Constants<D>& constants, double duration, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                   const std::vector<Vector<D>>& position, const ByAxis<D>& velocity, std::vector<Vector<D>>& predicted_velocity);

}  // namespace tern::fluid
