#pragma once
// Coupling iterations: how the load of the next one is made, and when the last answer is accepted.

#include "coupler/state.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

/// Forgets the iterations of the window before; their changes stay. `window.answer` is known.
template <int D>
void begin_iterations(const Setup<D>& setup, Workspace<D>& window, State<D>& state);

/// Takes note of what the fluid has answered the assumed load with; true when no further iteration is wanted.
template <int D>
bool note_iteration(State<D>& state, const Workspace<D>& window);

/// The load to assume next, by quasi-Newton steps from what the fluid has answered in this window and those before, put into the window.
template <int D>
void assume_next_load(State<D>& state, Workspace<D>& window);

}  // namespace tern::coupler
