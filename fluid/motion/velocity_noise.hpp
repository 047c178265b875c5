#pragma once
// Damping of velocity noise on the scale of the particles.

#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/reference.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// chi dt / tau: share of the noise that one step takes [0, 1/2]. `bulk_speed`: largest [m/s].
template <int D>
double damped_share(const Reference<D>& reference, double duration, double bulk_speed);

/// Takes this share of the noise in the packed velocities out of `velocity`.
template <int D>
void damp_velocity_noise(double share, const Period<D>& space, const Neighbours<D>& neighbours,
                         const std::vector<ParticleClass>& particle_class, const PackedVelocities<D>& packed,
                         std::vector<Vector<D>>& velocity);

}  // namespace tern::fluid
