#pragma once
// The longest explicit step that the forces of a body allow, measured on the forces themselves.

#include <vector>

#include "structure/reference.hpp"

namespace tern::structure {

/// Longest stable step of undamped and damped motions: with the largest frequency `omega` [1/s] of the elastic forces and
/// the largest rate `decay` [1/s] of the diffusion, which acts with the velocity of half a step before. Of the mode v' = -omega^2 x -
/// decay v the map of a step has its eigenvalues within the unit circle for dt^2 omega^2 + 2 dt decay < 4.
double longest_stable_step(double omega, double decay);

/// longest_stable_step() of each body in its reference configuration [s]. A lattice that its shape cuts askew has particles with few
/// neighbours, and these have higher frequencies than dx/c of the material tells.
template <int D>
std::vector<double> stable_steps_at_rest(const Reference<D>& reference);

}  // namespace tern::structure
