#pragma once
// Where the particles of a scene come to lie.

#include "scene/case_file.hpp"
#include "scene/settings.hpp"

namespace tern {

/// Takes a smaller spacing of the fluid, down to 0.7 of the one asked for, where the particles of one of its bodies would else have a mass
/// more than 5 % off that of its shape; a warning says so.
template <int D>
void fit_spacing_of_fluid(Case& scene, const Setting& settings);

/// The same for each solid.
template <int D>
void fit_spacings_of_bodies(Case& scene, const Setting& settings);

/// Throws BadInput if a body holds no particle, lies outside the container or the domain, or overlaps another body or
/// an obstacle; if a clamp holds no or all particles; if a body is fewer than 2 particles thick (fewer than 4: a
/// warning; so is a thin part that is not along its lattice), or its particles have a mass more than 5 % off (1 %: a
/// warning); if an initial velocity or gravity is not finite where a particle starts.
template <int D>
void check_placement(Case& scene, const Setting& settings);

/// Thickness of the body's thinnest sheet [m]: between opposite parallel faces that hold at least 5 % of its surface,
/// so that sharp edges, which are thin in every body, do not count. The median thickness where there is no such sheet.
template <int D>
double thin_section(const StructureBody& body);

/// The same of the thin sheets whose faces are not along the body's lattice; 0: there is none.
template <int D>
double toothed_section(const StructureBody& body);

}  // namespace tern
