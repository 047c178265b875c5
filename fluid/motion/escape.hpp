#pragma once
// Particles that end a step where they may not be.

#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"
#include "ranks/ranks.hpp"
#include "sph/faces.hpp"

namespace tern::fluid {

/// Particles that have gone through a face they saw, on the way from the middle of a window to its end. `faces`: as at the middle.
template <int D>
std::size_t count_leaks(double spacing, double duration, const Faces<D>& faces, const FaceRows& rows, const std::vector<Vector<D>>& middle,
                        const std::vector<Vector<D>>& end);

/// Removes the particles outside the domain. Throws NumericalFailure when none is left.
template <int D>
void remove_escaped(const Reference<D>& reference, State<D>& state);

/// Throws EndOfModel where nothing is left. `particles`: of all ranks.
void check_that_some_are_left(const Window& window, std::size_t particles);

}  // namespace tern::fluid
