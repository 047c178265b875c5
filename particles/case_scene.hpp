#pragma once
// Whether a scene makes sense as a whole, before anything is launched.

#include "particles/case_file.hpp"
#include "particles/settings.hpp"

namespace tern {

/// Sets the default domain and collects warnings. Throws BadInput if names repeat or lead nowhere, bodies overlap or stand
/// outside the walls, a body or clamp holds no particle, or a body is fewer than 2 particles thick. `settings` are the
/// effective settings the case was read from; they give the places for the sentences.
void check_scene(Case& scene, const Setting& settings);

/// Thickness that 10 % of the body's surface falls below [m]: the thickness of a plate, however long its ends are.
template <int D>
double thin_section(const StructureBody& body);

}  // namespace tern
