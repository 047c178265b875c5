#pragma once
// The gauges that the fluid evaluates.

#include "fluid/fluid.hpp"
#include "scene/gauges.hpp"

namespace tern::fluid {

/// Values of the fluid's gauges in the present state, in the order of their columns.
template <int D>
GaugeValues gauge_values(const Fluid<D>& fluid, const Case& scene);

}  // namespace tern::fluid
