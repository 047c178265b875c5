#pragma once
// What the pressure equation leaves of the divergence it was to drive out, and the correction of the pressure for it.

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

/// What is to be left behind in the next window, from the mean over the last windows and the mean of that mean. Exact where it grows or
/// falls by as much in every window.
double expected_left_behind(double mean, double mean_of_mean);

/// Finds of each part of the fluid the share s in [0, 1] of the correction with which expected - s answered has the least sum of squares.
/// `answered` comes as what is left with the correction in full.
template <int D>
void find_best_share(const Ranks& ranks, PressureSystem<D>& system);

/// Takes back what is more than that of a correction that has been added.
template <int D>
void keep_share(const PressureSystem<D>& system, State<D>& state);

/// Adds the share of the correction to a pressure without it.
template <int D>
void add_share(const PressureSystem<D>& system, State<D>& state);

/// Takes what the first solve of this window has left behind into the means of the state.
template <int D>
void remember_left_behind(const PressureSystem<D>& system, State<D>& state);

/// The share of particle i.
template <int D>
double share_taken(const PressureSystem<D>& system, std::ptrdiff_t i) {
  return system.share.empty() ? 0 : system.share[system.multigrid.part_of_particle()[i]];
}

}  // namespace tern::fluid
