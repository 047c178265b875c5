#pragma once
// Particles of an elastic body that stand alone in a sharp corner of its shape.

#include "scene/geometry.hpp"

namespace tern {

/// The points of a lattice without those in sharp corners whose neighbours do not span the space, so that no strain could be computed
/// there. A corner of 20 degrees has some two of them in 2D. What is narrower than the spacing for longer than a corner is, or ties two
/// parts of the body together, stays: whoever computes strains refuses it. So does everything in a box of more than 1e9 cells.
template <int D>
LatticePoints<D> without_loose_particles(const LatticePoints<D>& points);

}  // namespace tern
