#pragma once
// Damping of velocity noise on the scale of the particles.

#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/reference.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// Takes a share of the noise in the packed velocities out of `velocity`: chi dt/tau, at most 1/2, in the mean of the two particles of a
/// pair. `duration`: of the window [s].
template <int D>
void damp_velocity_noise(const Reference<D>& reference, double duration, const Neighbours<D>& neighbours,
                         const std::vector<ParticleClass>& particle_class, const PackedVelocities<D>& packed,
                         std::vector<Vector<D>>& velocity);

}  // namespace tern::fluid
