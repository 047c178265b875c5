#pragma once
// Patches of walls that several ranks fill.

#include "fluid/boundary/boundary.hpp"
#include "fluid/domain.hpp"

namespace tern::fluid {

/// How far a patch is wet is a sum over the particles of all ranks around it. It belongs to the rank in whose part it lies, and all ranks
/// have a copy whose particles may see it or count the dry patches around what they see. Everyone knows both from the cuts alone. To be
/// called in each window: does nothing until space is cut anew or walls have moved.
template <int D>
void share_patches(const Domain<D>& domain, const Constants<D>& constants, const Period<D>& period, Boundary<D>& boundary);

}  // namespace tern::fluid
