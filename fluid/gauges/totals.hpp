#pragma once
// Single figures of the whole fluid.

#include <optional>

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"
#include "proto/interface.hpp"
#include "ranks/ranks.hpp"

namespace tern::fluid {

/// To an observer who moves so [m/s].
template <class V>
double largest_speed(const std::vector<V>& velocity, const V& observer = V::Zero());

// `mass`: of a particle [kg/m^(3-D)].

/// [J/m^(3-D)]
template <int D>
double kinetic_energy(double mass, const State<D>& state);

template <int D>
Vector<D> momentum(double mass, const State<D>& state);

/// About the origin; 2D: only the last entry is not 0 [kg m^2/s /m^(3-D)].
template <int D>
Vector<3> angular_momentum(double mass, const State<D>& state);

/// What the number densities say of the volume of the fluid.
struct VolumeDrift {
  double inside = 0;  ///< (current volume)/(initial) - 1, from the mean particle number density of the particles inside
  double share = 0;   ///< of all particles that these are

  /// The same of all the fluid, as far as it is known: of films and spray it is not.
  double known() const { return share * inside; }
};

/// Numbers of particles inside and of all, and the sum of the particle number densities of those inside over that of the lattice.
struct Filling {
  double density = 0, inside = 0, all = 0;

  VolumeDrift volume_drift() const { return inside > 0 ? VolumeDrift{inside / density - 1, inside / all} : VolumeDrift{}; }
};

template <int D>
Filling filling(const Constants<D>& constants, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                const Corrections<D>& correction, const State<D>& state);

template <int D>
std::size_t spray_particles(const State<D>& state);

/// All of them.
template <int D>
struct Totals {
  double kinetic = 0, potential = 0;
  Vector<D> momentum = Vector<D>::Zero();
  Vector<3> angular_momentum = Vector<3>::Zero();
  double largest_speed = 0, largest_in_frame = 0;
  Filling filling;
  std::optional<FluidExtent<D>> extent;
  std::size_t particles = 0, spray_particles = 0, removed = 0, leaked = 0;
  Evaluations evaluations;
  std::size_t ghosts = 0;          ///< domain.hpp
  Traffic traffic;                 ///< in the windows so far of this process
  std::size_t most_particles = 0;  ///< of a rank
};

/// Of all ranks, from those of each.
template <int D>
Totals<D> add_up(const Ranks& ranks, const Totals<D>& own);

}  // namespace tern::fluid
