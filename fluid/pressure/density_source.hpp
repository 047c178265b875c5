#pragma once
// Part of the source of the pressure equation that restores the density.

#include <cmath>

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/reference.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// 1/tau: in tau a particle passes 0.15 spacings of one that is farther off by some spacings, in a flow of this velocity gradient, or falls
/// by 0.005 spacings.
struct PassingRate {
  double by_gravity;  ///< [1/s]
  double by_flow;     ///< over the size of the velocity gradient [-]

  template <int D>
  PassingRate(const Reference<D>& reference, double spacings)
      : by_gravity(10 * std::sqrt(reference.gravity_size / reference.constants.spacing)), by_flow(spacings / 0.15) {}
};

/// s_i of every particle, with the velocity gradients of `packed` [1/s]. `duration`: of the window [s].
template <int D>
void compute_density_source(const Reference<D>& reference, double duration, const PackedVelocities<D>& packed,
                            const Neighbours<D>& neighbours, const Boundary<D>& boundary, const Corrections<D>& correction,
                            const std::vector<ParticleClass>& particle_class, std::vector<double>& source);

}  // namespace tern::fluid
