#pragma once
// The end of a step.

#include "fluid/state.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// Work of gravity over the window [J/m^(3-D)]. `mass`: of a particle.
template <int D>
double work_of_gravity(double mass, double duration, const State<D>& state, const Prediction<D>& prediction);

/// r^{n+1} = r* + dt/2 u^{n+1}.
template <int D>
void advance(double duration, const Prediction<D>& prediction, State<D>& state);

}  // namespace tern::fluid
