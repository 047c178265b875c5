#pragma once
// What the interface gives back to particles under a uniform pressure.

#include "fluid/boundary/boundary.hpp"
#include "fluid/reference.hpp"
#include "proto/interface.hpp"
#include "ranks/ranks.hpp"

namespace tern::fluid {

/// Sets boundary.sums.reaction of the particles `at_structure`. `particles`: these, with their images.
template <int D>
void find_interface_reaction(const Constants<D>& constants, const Ranks& ranks, const InterfaceParticles<D>& particles, const std::vector<int>& at_structure,
                             Boundary<D>& boundary);

}  // namespace tern::fluid
