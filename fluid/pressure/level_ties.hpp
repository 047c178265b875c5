#pragma once
// Which enclosed regions of the fluid have bodies beside them, and of which these tie the level of the pressure.
//
// A level pushes both faces of a thin plate, whose lumps (yielding_surface.hpp) do not move by it: it would have to make the plate thinner,
// which a lump cannot. So two regions with a body between them have a level in common that nothing tells, besides the difference of their
// levels that moves the body, and a region all round a plate has one.

#include <vector>

#include "fluid/pressure/enclosed_regions.hpp"
#include "fluid/pressure/yielding_surface.hpp"

namespace tern::fluid {

/// By number of the enclosed regions, for select_regions().
struct LevelTies {
  std::vector<int> beside_bodies;  ///< own number of each region that pushes a body; -1: none
  /// A number for those whose level nothing ties. Those that push the same body share it: they are one sealed region.
  std::vector<int> sealed;
};

/// A level is tied where it moves a body by at least half of what it would if no face of the body undid the push of another: by the sum of
/// squares over the lumps of their pushes, each over its mass. `at_structure`: as of `yielding`, which has been assembled.
template <int D>
LevelTies find_level_ties(const YieldingSurface<D>& yielding, const std::vector<int>& at_structure, const EnclosedRegions& enclosed);

}  // namespace tern::fluid
