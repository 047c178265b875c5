#pragma once
// The surface of a shell, cut where its particles are.

#include "scene/geometry.hpp"
#include "scene/mid_surface.hpp"

namespace tern {

/// As sample_surface(). In 2D both faces of rings and lines are cut where the middle line is cut between the cells of the particles, each
/// cell into parts of about `spacing`: every particle has its own part of each face. By lengths of their own, an inner face of 61 points
/// would leave two of 63 particles with half of their load.
template <int D>
SurfacePoints<D> sample_shell_surface(const StructureBody& body, double spacing);

}  // namespace tern
