#pragma once
// Coupling iterations: how the load of the next one is made, and when the last answer is accepted.

#include "coupler/state.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

/// Forgets the iterations of the window before; their changes stay. `window.answer` is known.
template <int D>
void begin_iterations(const Setup<D>& setup, Workspace<D>& window, State<D>& state);

/// From `answer` and `contact`, what the fluid answers the assumed load with, and the contacts in it: the load to assume next, put into
/// the window, and true; false when fluid and structure agree. Throws NumericalFailure when the answer is not finite or they cannot
/// be brought to agree.
template <int D>
bool assume_next_load(const SurfaceLoad<D>& answer, const SurfaceLoad<D>& contact, State<D>& state, Workspace<D>& window);

}  // namespace tern::coupler
