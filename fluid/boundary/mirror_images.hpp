#pragma once
// Images of fluid particles in the walls they stand at. Only a face of the structure that meets a wall looks at them: part of
// the half space before its points lies beyond the wall, where the fluid is mirrored and loads the face as before it.

#include <vector>

#include "sph/faces.hpp"

namespace tern::fluid {

/// Sets `images` to the places of particle i, at x, mirrored in each plane of walls before which it stands, and in the planes
/// one after the other where all are at right angles. `rows`: what particles see of the walls. `close`: images nearer to each
/// other than this are one, of neighbouring patches of one wall [m].
template <int D>
void mirror_in_walls(const Faces<D>& walls, const FaceRows& rows, int i, const Vector<D>& x, double close, std::vector<Vector<D>>& images);

}  // namespace tern::fluid
