#pragma once
// What the state says of the next window.

#include <optional>

#include "base/step_proposal.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "proto/interface.hpp"

namespace tern::fluid {

/// Length wanted: by the fastest particle, wall or wet body, by gravity, by the acceleration of walls as by gravity, by viscosity.
/// `fastest`: particle [m/s]; `fastest_in_frame`: to the observer who goes along, if there is one, for whom windows may be longer.
template <int D>
StepProposal propose_step(const Reference<D>& reference, double fastest, const std::optional<double>& fastest_in_frame,
                          const State<D>& state);

/// Which surface can be left out of the next window; nothing where the fluid is periodic and has no end.
template <int D>
std::optional<FluidExtent<D>> fluid_extent(const Reference<D>& reference, const State<D>& state);

}  // namespace tern::fluid
