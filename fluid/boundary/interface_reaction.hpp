#pragma once
// What the interface gives back to particles under a uniform pressure, and what is missing of the weight of the fluid beside it.

#include "fluid/boundary/boundary.hpp"
#include "fluid/correction_matrix.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "proto/interface.hpp"
#include "ranks/ranks.hpp"

namespace tern::fluid {

/// Of the half space before a face: less of it fills nothing. At the end of the kernel w~ has both signs.
inline constexpr double least_seen = 1e-3;

/// Sets swept_share of the faces, reaction and carried_weight of the particles `at_structure`, and brings the made-up loads into
/// linear_moment. `particles`: these, with their images. `position` [m] and `gravity` [m/s^2]: of all.
template <int D>
void find_interface_reaction(const Constants<D>& constants, const Ranks& ranks, const InterfaceParticles<D>& particles,
                             const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                             const std::vector<int>& at_structure, Boundary<D>& boundary);

/// u += dt times the acceleration that the interface gives back to the particles `at_structure` for the pressure of the state: the
/// coupler's answer with riemann and pi, before contacts. find_interface_reaction() comes first.
template <int D>
void add_interface_reaction(const Constants<D>& constants, double duration, const Boundary<D>& boundary, const State<D>& state,
                            const std::vector<int>& at_structure, std::vector<Vector<D>>& velocity);

/// Adds to what walls mirror for particles `at_structure` inside the fluid what the sums of fluid and faces lack of its weight: water at
/// rest is at rest, whatever the particles' places. `gravity`: at each particle [m/s^2]. find_interface_reaction() comes first.
template <int D>
void balance_weight(const Constants<D>& constants, const Neighbours<D>& neighbours, const Corrections<D>& correction,
                    const std::vector<ParticleClass>& particle_class, const std::vector<Vector<D>>& gravity,
                    const std::vector<int>& at_structure, Boundary<D>& boundary);

}  // namespace tern::fluid
