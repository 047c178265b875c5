#pragma once
// What the projection leaves of the divergence it was to drive out, and the correction of the pressure for it.

#include <vector>

#include "fluid/pressure/pressure_system.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"

namespace tern::fluid {

/// The source for what the pressure leaves behind of div u* - q, but for what the structure yields. `divergence`: div of u* - dt/rho grad p
/// beside the surface as it is predicted [1/s].
template <int D>
void assemble_left_behind(const Constants<D>& constants, double duration, const std::vector<ParticleClass>& particle_class,
                          const std::vector<double>& divergence, const std::vector<double>& target, std::vector<double>& left);

/// Adds system.correction to state.pressure.
template <int D>
void add_correction(const PressureSystem<D>& system, State<D>& state);

/// Finds of each part of the fluid the share s in [0, 1] of the correction with which left_behind + s (still_left - left_behind) has the
/// least sum of squares.
template <int D>
void find_best_share(const Ranks& ranks, PressureSystem<D>& system);

/// Takes back what is more than that of a correction that has been added.
template <int D>
void keep_share(const PressureSystem<D>& system, State<D>& state);

/// The share of particle i.
template <int D>
double share_taken(const PressureSystem<D>& system, std::ptrdiff_t i) {
  return system.share.empty() ? 0 : system.share[system.multigrid.part_of_particle()[i]];
}

}  // namespace tern::fluid
