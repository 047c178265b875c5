#pragma once
// What the projection leaves of the divergence it was to drive out, and the correction of the pressure for it.

#include <vector>

#include "fluid/neighbours.hpp"
#include "fluid/pressure/divergence_target.hpp"
#include "fluid/pressure/pressure_system.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"

namespace tern::fluid {

/// The source for what the pressure leaves behind of div u* - q; 0 beside the structure. `divergence`: div of u* - dt/rho grad p [1/s].
template <int D>
void assemble_left_behind(const Constants<D>& constants, double duration, const Neighbours<D>& neighbours, const BesideStructure& beside,
                          const std::vector<ParticleClass>& particle_class, const std::vector<double>& divergence,
                          const std::vector<double>& target, std::vector<double>& left);

/// Adds system.correction to state.pressure.
template <int D>
void add_correction(const PressureSystem<D>& system, State<D>& state);

/// Takes back what is too much of a correction that has been added: of each part of the fluid the share s in [0, 1] stays with which
/// left_behind + s (still_left - left_behind) has the least sum of squares. system.left_behind is what was answered: s of it.
template <int D>
void keep_best_share(const Ranks& ranks, PressureSystem<D>& system, State<D>& state);

/// The share of particle i, once keep_best_share() has found it.
template <int D>
double share_taken(const PressureSystem<D>& system, std::ptrdiff_t i) {
  return system.share.empty() ? 0 : system.share[system.multigrid.part_of_particle()[i]];
}

}  // namespace tern::fluid
