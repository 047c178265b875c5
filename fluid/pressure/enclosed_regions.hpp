#pragma once
// Fluid that is enclosed all round, by walls, by bodies or by its own periodic images: no free surface ties its pressure to a value. Each
// connected region is treated by itself. Where bodies yield to it, they tie the level of its pressure. Where nothing does, it is sealed:
// its pressure equation has a solution only if no net volume flows in.
//
// A region is enclosed unless one of its particles lacks at least half of what those of a flat surface lack of their support. Less is
// disorder. Where a lattice is cut by a curved or oblique face, it exceeds now and then what the pressure equation takes for a surface
// elsewhere, and would tie the pressure to zero there, in some windows and not in others.
//
// If all fluid is enclosed between fixed walls, it fills its enclosure once and for all. Flows that stretch their particles (stagnation
// points) may then lack more, and would blow up if that were taken for a surface.

#include <cstdint>
#include <vector>

#include "fluid/boundary/boundary.hpp"
#include "fluid/domain.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// The regions of one step.
struct EnclosedRegions {
  Ranks ranks;                     ///< that have parts of them
  std::vector<int> region;         ///< of each own row; -1: in none
  std::vector<int> size;           ///< rows of each region, of all ranks
  std::vector<double> sum;         ///< scratch, one per region
  std::vector<int> queue;          ///< scratch
  std::vector<std::uint8_t> tied;  ///< scratch

  bool any() const { return !size.empty(); }
  /// sum[k] = sum of the values over region k. Over all ranks, as all functions here.
  void add_up(const std::vector<double>& values);
  /// Takes the mean over each region out of the values of its rows.
  void subtract_means(std::vector<double>& values);
  /// Shifts the values of the rows of each region by as much as lets them sum to `scale` times this.
  void set_sums(const std::vector<double>& sums, double scale, std::vector<double>& values);
};

/// Finds the connected sets of unknowns none of which is `at_surface`. Costs little where all is tied: ties spread along the order of the
/// particles, back and forwards, and only what they do not reach is searched.
template <int D>
void find_enclosed_regions(const Neighbours<D>& neighbours, const std::vector<ParticleClass>& particle_class,
                           const std::vector<std::uint8_t>& at_surface, EnclosedRegions& regions);

/// The same of several ranks, in the order of the least label in each region. `label`: of the own particles.
template <int D>
void find_enclosed_regions_of_ranks(const Domain<D>& domain, const Neighbours<D>& neighbours,
                                    const std::vector<ParticleClass>& particle_class, const std::vector<std::uint32_t>& label,
                                    const std::vector<std::uint8_t>& at_surface, EnclosedRegions& regions);

/// Those of `regions` that get a number, 0, 1, ...; -1: none. Regions of the same number become one.
void select_regions(const EnclosedRegions& regions, const std::vector<int>& number, EnclosedRegions& selected);

/// What the level of an enclosed pressure takes away of the volume that bodies sweep [m^D/s]: nearly all of the `rate` that is theirs
/// under the load of the last window, and a tenth of what they have pushed in, given as a rate over one window, as far as it lasts. A part
/// of the rate alone makes of the enclosed fluid a spring, the stiffer the more nearly it is all: that feeds no motion, of however many
/// modes. With more than all of it the spring would be one that pushes the wrong way. What has been pushed in is an integral: it feeds
/// vibrations, but what these push in has hardly a mean. `lasting`: the mean of what has been pushed in over the mean of its size, from -1
/// to 1 (tests/coupler/interface_velocity_test.cpp).
inline double level_taken_away(double rate, double pushed_in, double lasting) { return 0.95 * rate + 0.1 * lasting * lasting * pushed_in; }
inline constexpr double newest_in_mean = 0.02;  ///< part of the last window in both means

/// How the faces of the structure have moved since the middle of the last window; where that is not known, since the begin of this one, as
/// their velocity has it.
template <int D>
struct FaceMotion {
  double time = 0;  ///< since then, to the middle of this window [s]
  /// In the middle of the window, on their way [m]. The surface that fluid sees stands halfway between both ends of the window, on the
  /// chord: that of a body that turns by theta within it is smaller by theta^2/8 of its radius.
  std::vector<Vector<D>> place;
  std::vector<Vector<D>> displacement;  ///< in it [m]
  std::vector<Vector<D>> mean_normal;   ///< over it: mean of A n, over A
  std::vector<Vector<D>> turn;          ///< what n is more at the end of this window than in its middle, if it goes on so

  void find(double duration, const Faces<D>& surface, const State<D>& state);
};

/// What faces push into enclosed regions, by the share of each face that bears its load: the power of a uniform pressure on the structure
/// over that pressure. Counted in the frame of the wall that bounds most of the region, in which a container that moves as a whole sweeps
/// nothing.
template <int D>
struct SweptVolume {
  /// By region, at the end of the window [m^D/s]. Faces stand where they are in its middle; were it not for `turn`, a surface that goes to
  /// and fro would push half a window of the square of its velocity each time.
  std::vector<double> rate;
  /// Of these regions: what they have pushed in up to the middle of this window, and how they have answered up to the last one.
  EnclosedPast past;
  double way = 0, area = 0;  ///< in the window, of all regions: what faces of bodies sweep to and fro [m^D], and their area
  FaceMotion<D> motion;      ///< scratch
  std::vector<double> sums;  ///< scratch
  /// Scratch, the same in all coupling iterations of a window: what a patch of a wall counts for, over the weights with which it is seen.
  std::vector<double> wall_share;

  /// `load`: of a coupling iteration. Later ones than the first have other velocities at the same places.
  void find(const Constants<D>& constants, double duration, const InterfaceCondition<D>& load, const Boundary<D>& boundary,
            const EnclosedRegions& regions, const State<D>& state);
  /// How many times as much as it is told the volume of a region changes by a load.
  double answer(std::size_t region) const;
  /// Of a region in the first pass of a window: what its level takes away of `rate` [m^D/s].
  double taken_away(std::size_t region, double duration) const;
  /// Into the state, for the window to come.
  void remember(double duration, const Faces<D>& surface, const EnclosedRegions& regions, State<D>& state);
  /// Warns once where what has been pushed in is no longer small beside what bodies have swept: windows are too long for them.
  void watch_lag(const Constants<D>& constants, const Window& window, const EnclosedRegions& regions, State<D>& state) const;
};

/// Accounts for what the regions are asked for and cannot do, into state.enclosed, with one warning; finds whether the fluid fills its
/// enclosure for good. `source`: right-hand side of the pressure equation. `swept`: of the regions `beside_bodies`. Uses regions.sum.
template <int D>
void account_for_enclosed_fluid(const Reference<D>& reference, const Window& window, const Boundary<D>& boundary,
                                const std::vector<double>& source, const EnclosedRegions& beside_bodies, const SweptVolume<D>& swept,
                                EnclosedRegions& regions, State<D>& state);

}  // namespace tern::fluid
