#pragma once
// Changes of positions at the end of a step that are no motion of the fluid.

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/reference.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// Moves particles that are nearer to a face than the contact distance back towards it.
template <int D>
void move_off_faces(const Constants<D>& constants, const Boundary<D>& boundary, const std::vector<Vector<D>>& predicted_position,
                    std::vector<Vector<D>>& position);

/// Shifts `position` down the gradient of concentration, as the rate of strain in the packed velocities asks for, and takes `velocity`
/// half of the way.
template <int D>
void shift_particles(const Constants<D>& constants, double duration, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                     const Corrections<D>& correction, const std::vector<ParticleClass>& particle_class, const PackedVelocities<D>& packed,
                     const std::vector<std::uint32_t>& label, const std::vector<Vector<D>>& predicted_position,
                     std::vector<Vector<D>>& position, std::vector<Vector<D>>& velocity);

}  // namespace tern::fluid
