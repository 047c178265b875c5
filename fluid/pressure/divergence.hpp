#pragma once
// Divergence of the velocity.

#include "fluid/boundary/boundary.hpp"
#include "fluid/motion/motion.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// div u of every particle [1/s]. Packs position and velocity into `motion`.
template <int D>
void compute_divergence(const Period<D>& space, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                        const Corrections<D>& correction, const std::vector<ParticleClass>& particle_class,
                        const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& velocity, std::vector<Motion<D>>& motion,
                        std::vector<double>& divergence);

}  // namespace tern::fluid
