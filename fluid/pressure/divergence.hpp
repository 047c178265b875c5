#pragma once
// Divergence of the velocity.

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// div u of the particles `only`, or with nullptr of every one [1/s]. `packed`: the velocity by axis.
template <int D>
void compute_divergence(const Period<D>& space, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                        const Corrections<D>& correction, const std::vector<ParticleClass>& particle_class,
                        const std::vector<Vector<D>>& velocity, const std::vector<int>* only, ByAxis<D>& packed,
                        std::vector<double>& divergence);

}  // namespace tern::fluid
