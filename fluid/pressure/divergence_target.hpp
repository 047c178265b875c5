#pragma once
// What the pressure drives the divergence of the velocity to.

#include <cstdint>
#include <vector>

#include "fluid/domain.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// The particles that see the structure and their neighbours, each once in their order: their divergence is not known before the coupler
/// has answered.
struct BesideStructure {
  std::vector<int> list;
  std::vector<std::uint8_t> listed;  ///< by particle
};
/// `particles`: with those of other ranks, whose neighbours here are listed as well.
template <int D>
void list_beside_structure(const Domain<D>& domain, std::size_t particles, const Neighbours<D>& neighbours,
                           const std::vector<int>& at_structure, BesideStructure& beside);

/// q_i of every particle [1/s] in a window of this duration [s]. `velocities`: u^n with its gradient; `density_source`: s_i [1/s],
/// empty: none.
template <int D>
void set_divergence_target(double duration, const Neighbours<D>& neighbours, const BesideStructure& beside,
                           const PackedVelocities<D>& velocities, const std::vector<double>& density_source, std::vector<double>& target);

}  // namespace tern::fluid
