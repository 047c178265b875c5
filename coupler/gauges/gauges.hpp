#pragma once
// The gauges that the coupler evaluates.

#include "coupler/window.hpp"
#include "scene/gauges.hpp"

namespace tern::coupler {

/// Values of the coupler's gauges after a window, in the order of their columns.
template <int D>
GaugeValues gauge_values(const Coupler<D>& coupler, const Case& scene);

}  // namespace tern::coupler
