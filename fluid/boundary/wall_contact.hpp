#pragma once
// Contact of particles with walls.

#include "fluid/boundary/boundary.hpp"
#include "fluid/reference.hpp"

namespace tern::fluid {

/// Takes out of `velocity` what would bring a particle nearer to a wall than the contact distance in a window of this duration [s], and
/// says what that was of each particle, over the duration: `stopped` [m/s^2]. The walls bear the force -m times it.
template <int D>
void settle_wall_contacts(const Constants<D>& constants, double duration, const Boundary<D>& boundary,
                          const std::vector<Vector<D>>& position, std::vector<Vector<D>>& velocity, std::vector<Vector<D>>& stopped);

}  // namespace tern::fluid
