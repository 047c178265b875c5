#pragma once
// Single figures of the whole fluid.

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// [m/s]
template <class V>
double largest_speed(const std::vector<V>& velocity);

/// Spray left out [m/s].
template <int D>
double largest_bulk_speed(const State<D>& state);

// `mass`: of a particle [kg/m^(3-D)].

/// [J/m^(3-D)]
template <int D>
double kinetic_energy(double mass, const State<D>& state);

template <int D>
Vector<D> momentum(double mass, const State<D>& state);

/// About the origin; 2D: only the last entry is not 0 [kg m^2/s /m^(3-D)].
template <int D>
Vector<3> angular_momentum(double mass, const State<D>& state);

/// (current volume of the fluid)/(initial) - 1, from the mean particle number density of interior particles.
template <int D>
double volume_drift(const Constants<D>& constants, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                    const Corrections<D>& correction, const State<D>& state);

template <int D>
std::size_t spray_particles(const State<D>& state);

}  // namespace tern::fluid
