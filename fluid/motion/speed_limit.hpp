#pragma once
// What ends a run that has gone wrong.

#include "fluid/state.hpp"
#include "fluid/workspace.hpp"
#include "ranks/ranks.hpp"

namespace tern::fluid {

/// Throws NumericalFailure when a predicted velocity is beyond what the scene can have. The fastest wall, and the structure at the first
/// window, raise the reference speed of the state.
template <int D>
void check_speed(const Ranks& ranks, const Window& window, const Prediction<D>& prediction, const std::vector<Vector<D>>& surface_velocity,
                 State<D>& state);

/// Throws NumericalFailure when the fluid beside a body has lost or gained more than 5 % of its volume for ten windows. `drift`: of the
/// volume of all the fluid, as far as it is known, relative; 0 without a body.
template <int D>
void check_volume(const Window& window, double drift, State<D>& state);

}  // namespace tern::fluid
