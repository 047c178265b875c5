#pragma once
// What the pressure drives the divergence of the velocity to.

#include <cstdint>
#include <vector>

#include "fluid/neighbours.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// q_i of every particle [1/s] in a window of this duration [s]. `velocities`: u^n with its gradient; `density_source`: s_i [1/s],
/// empty: none.
template <int D>
void set_divergence_target(double duration, const Neighbours<D>& neighbours, const std::vector<int>& at_structure,
                           const PackedVelocities<D>& velocities, const std::vector<double>& density_source, std::vector<double>& target);

/// Calls what(i) for each particle that sees the structure and for its neighbours, whose divergence is not known before the coupler has
/// answered. Some are called several times.
template <int D, class What>
void for_each_beside_structure(const Neighbours<D>& neighbours, const std::vector<int>& at_structure, What&& what) {
  for (int i : at_structure) {
    what(i);
    neighbours.for_each(i, [&](int j, float) { what(j); });
  }
}

/// The particles at the structure and their neighbours, each once.
struct BesideStructure {
  std::vector<int> list;
  std::vector<std::uint8_t> listed;  ///< by particle
};
template <int D>
void list_beside_structure(const Neighbours<D>& neighbours, const std::vector<int>& at_structure, BesideStructure& beside);

}  // namespace tern::fluid
