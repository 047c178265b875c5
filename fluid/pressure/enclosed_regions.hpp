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

/// Those of `regions` whose number has this `property`.
void select_regions(const EnclosedRegions& regions, const std::vector<std::uint8_t>& property, bool value, EnclosedRegions& selected);

/// Accounts for what the regions are asked for and cannot do, into state.enclosed, with one warning; finds whether the fluid fills its
/// enclosure for good. `source`: right-hand side of the pressure equation. Uses regions.sum.
template <int D>
void account_for_enclosed_fluid(const Reference<D>& reference, const Window& window, const Boundary<D>& boundary,
                                const std::vector<double>& source, EnclosedRegions& regions, State<D>& state);

}  // namespace tern::fluid
