#pragma once
// The state at t = 0.

#include "fluid/state.hpp"
#include "scene/case_file.hpp"

namespace tern::fluid {

/// Fills the fluid bodies with particles. Throws BadInput when none results.
template <int D>
State<D> initial_state(const Case& scene);

}  // namespace tern::fluid
