#pragma once
// Patches of walls that several ranks fill.

#include "fluid/boundary/boundary.hpp"
#include "fluid/domain.hpp"

namespace tern::fluid {

/// How far a patch is wet is a sum over the particles of all ranks around it. Those have a copy of the sum that hold the patch and whose
/// particles may see it or count the dry patches around what they see. It belongs to the one of them in whose part it lies, or else to the
/// first. Everyone knows all this from the cuts and the boxes of what ranks hold. To be called in each window: does nothing until one of
/// these is another, or walls have moved.
template <int D>
void share_patches(const Domain<D>& domain, const Constants<D>& constants, const Period<D>& period, Boundary<D>& boundary);

}  // namespace tern::fluid
