#pragma once
// The surface of a shell, cut where its particles, walls and clamps are.

#include "scene/geometry.hpp"
#include "scene/mid_surface.hpp"

namespace tern {

/// As sample_surface(). In 2D both faces of rings and lines are cut where the middle line is cut between the cells of the particles, each
/// cell into parts of about `spacing`: every particle has its own part of each face. By lengths of their own, an inner face of 61 points
/// would leave two of 63 particles with half of their load. Boxes are cut where the faces of walls and clamps that are boxes pass through
/// them: the part of a patch beyond a wall or its floor bears no load, and in coarse patches that part is some per cent of all.
template <int D>
SurfacePoints<D> sample_shell_surface(const StructureBody& body, const std::vector<WallCase>& walls, double spacing);

}  // namespace tern
