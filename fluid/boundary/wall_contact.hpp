#pragma once
// Contact of particles with walls.

#include "fluid/boundary/boundary.hpp"
#include "fluid/reference.hpp"

namespace tern::fluid {

/// Takes the approach to walls in reach out of `velocity`.
template <int D>
void settle_wall_contacts(const Constants<D>& constants, const Boundary<D>& boundary, const std::vector<Vector<D>>& position,
                          std::vector<Vector<D>>& velocity);

}  // namespace tern::fluid
