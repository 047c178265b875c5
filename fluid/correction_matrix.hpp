#pragma once
// Correction matrices of the gradients.

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// C, C^F and tr M / D of every particle; marks those that have a C^F.
template <int D>
void correct_moments(const Neighbours<D>& neighbours, const Boundary<D>& boundary, std::vector<ParticleClass>& particle_class,
                     Corrections<D>& correction);

}  // namespace tern::fluid
