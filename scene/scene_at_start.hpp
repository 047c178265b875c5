#pragma once
// A scene as it stands before the first step, for pictures: the places of the particles, and where walls and clamps go.

#include <cstddef>
#include <string>

#include "scene/case_file.hpp"

namespace tern {

/// JSON text.
/// `bodies`, those of the fluid first: kind, name, spacing [m], number of particles and of clamped ones; `fastest`, the largest speed
/// at the start [m/s], and `velocity`, place [m] and velocity [m/s] of some particles where that is not 0. Where the scene has at most
/// `most_points` particles also `step` [m] and `rows`, of the clamped ones `clamped_rows`: the first point [m] and the number of points,
/// one step apart along x. Of the clamped ones the structure later moves those beside the face of a clamp onto it.
/// `walls` and `clamps`: name and, of what moves, `path`: time [s], angle [rad] and where the points are that were at the origin and 1 m
/// from it along each axis before it moved.
/// `gravity` [m/s^2] at t = 0 in the middle of the domain; `domain` [m]; `periodic` per direction; `count` of all particles.
std::string scene_at_start(const Case& scene, std::size_t most_points);

}  // namespace tern
