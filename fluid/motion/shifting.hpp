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

/// C_s h |u|max dt [m^2]; 0: the scene has no shifting, or nothing moves.
template <int D>
double shifting_coefficient(const Constants<D>& constants, double duration, double bulk_speed);

/// Shifts `position` down the gradient of concentration.
template <int D>
void shift_particles(double coefficient, const Constants<D>& constants, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                     const Corrections<D>& correction, const std::vector<ParticleClass>& particle_class,
                     const std::vector<Vector<D>>& predicted_position, std::vector<Vector<D>>& position);

}  // namespace tern::fluid
