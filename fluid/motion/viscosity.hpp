#pragma once
// Viscosity of the fluid.

#include <algorithm>

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/reference.hpp"

namespace tern::fluid {

/// y_ik, for a particle at this height above the plane of a patch: at least a sixth of h, which keeps the limit of the step independent of
/// the disorder [m].
template <int D>
double seen_height(const Constants<D>& constants, double height) {
  return std::max(height, constants.kernel.smoothing_length() / 6);
}

/// u* += dt nu lap u^n. `position`: r*; `velocity`: u^n.
template <int D>
void add_viscosity(const Constants<D>& constants, double duration, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                   const std::vector<Vector<D>>& position, const ByAxis<D>& velocity, std::vector<Vector<D>>& predicted_velocity);

}  // namespace tern::fluid
