#pragma once
// Which particles are inside the fluid, at its free surface, or spray.

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// state.particle_class of every particle and of its neighbours, from the moments and from the mark of the step before.
template <int D>
void classify_particles(const Constants<D>& constants, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                        const Corrections<D>& correction, State<D>& state);

}  // namespace tern::fluid
