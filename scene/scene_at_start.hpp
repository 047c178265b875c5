#pragma once
// A scene as it stands before the first step, for pictures: the places of the particles, and where walls and clamps go.

#include <cstddef>
#include <string>

#include "scene/case_file.hpp"

namespace tern {

/// JSON text. `bodies`: of each fluid and structure body kind, name, spacing [m], number of particles and of clamped ones. Where the
/// scene has at most `most_points` particles also `step` [m] and `rows`, and of clamped ones `clamped_rows`: first point [m] and number
/// of points, one step apart along x; and `velocity`, place [m] and velocity [m/s] of some, where it is not zero. `walls` and `clamps`:
/// name and, of what moves, `path`: time [s], angle [rad] and where the points are that were at t = 0 at the origin and 1 m from it along each axis.
/// `gravity` [m/s^2] at t = 0 in the middle of the domain; `domain` [m]; `periodic` per direction.
std::string scene_at_start(const Case& scene, std::size_t most_points);

}  // namespace tern
