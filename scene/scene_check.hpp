#pragma once
// Whether a scene makes sense as a whole, before anything is launched.

#include <algorithm>
#include <cmath>
#include <optional>

#include "scene/case_file.hpp"
#include "scene/settings.hpp"

namespace tern {

/// Sets the default domain, fits the spacing of the fluid to its boxes (fitted_spacing()) and collects warnings.
/// Throws BadInput if names repeat or lead nowhere, bodies overlap or
/// stand outside the walls, a body or clamp holds no particle, or a body is fewer than 2 particles thick. `settings`
/// are the effective settings the case was read from; they give the places for the sentences.
void check_scene(Case& scene, const Setting& settings);

/// Throws BadInput where the case would hold more particles or patches than a computer can; allocates nothing.
void check_sizes(const Case& scene, const Setting& settings);

/// Primitives of a shape and sides of its polygons: what is looked at to tell whether a point is inside.
double count_sides(const Shape& shape);

/// Distance between the points of a body's surface [m], see patch_length(). Those of a shell in 3D need not stand before its particles.
template <int D>
double point_distance(double spacing, bool is_shell, const std::optional<FluidCase>& fluid) {
  return D == 3 && is_shell && fluid ? std::min(spacing, 0.5 * fluid->spacing) : patch_length(spacing, fluid);
}

/// Edge of the cubes that join the points of a solid's surface to patches: the most spacings that half of one of the fluid holds [m]. 0:
/// they are not joined. In 2D they are few.
template <int D>
double joined_patch_length(double spacing, const std::optional<FluidCase>& fluid) {
  const double spacings = fluid && D == 3 ? std::floor(0.5 * fluid->spacing / spacing * (1 + 1e-9)) : 1;
  return spacings >= 2 ? spacings * spacing : 0;
}

/// Length of the patches of a wall over the spacing of the fluid (fluid/boundary/walls.cpp).
inline constexpr double wall_patch_share = 0.5;
/// Patches of all walls, also of faces that are left out later.
template <int D>
double count_wall_patches(const Case& scene);

/// Whether a wall leaves out this face, "y_max".
bool is_open(const WallCase& wall, const std::string& face);

/// Where fluid may start: the container with its open faces moved to infinity; nothing if there is no container.
std::optional<Shape> fluid_region(const Case& scene);
/// The shape of a wall, which goes on without end where it has an open face.
Shape without_open_faces(const WallCase& wall);

}  // namespace tern
