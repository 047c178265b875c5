#pragma once
// Part of the source of the pressure equation that restores the density.

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/reference.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// tau: the time in which a particle passes a part of its spacing, by the flow or by gravity [s]. `bulk_speed`: largest [m/s].
template <int D>
double density_time_scale(const Reference<D>& reference, double bulk_speed);

/// s_i of every particle [1/s].
template <int D>
void compute_density_source(const Reference<D>& reference, double bulk_speed, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                            const Corrections<D>& correction, const std::vector<ParticleClass>& particle_class,
                            std::vector<double>& source);

}  // namespace tern::fluid
