#pragma once
// How the surface answers a pressure, as the pressure equation is told (Robin condition; docs/THEORY.md, section 3).

#include <vector>

#include "coupler/setup.hpp"
#include "coupler/state.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

/// window.responding_mass and answer: the guess, learnt where one pass may be enough, and at least some layers of fluid where it is not
/// and windows are repeated. Takes note of the surface if it is the first of the run.
template <int D>
void find_answer(const Setup<D>& setup, const Surface<D>& surface, State<D>& state, Workspace<D>& window);

/// Reference pressure and response of the window's condition, from the assumed load and what is known of the answer to it.
template <int D>
void set_robin_condition(const Setup<D>& setup, Workspace<D>& window);

}  // namespace tern::coupler
