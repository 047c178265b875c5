#pragma once
// The checks of a scene, by subject. `settings` are the effective settings the case was read from; they give the places for the
// sentences. All throw BadInput.

#include "scene/case_file.hpp"
#include "scene/key_sentences.hpp"
#include "scene/settings.hpp"

namespace tern {

/// Names are unique in their table and break no table of results.
void check_names(const Setting& settings);
/// At most one container; no walls without a fluid.
void check_walls(const Case& scene, const Setting& settings);

/// Patches of the surface of a shape, about as many as sample_surface() makes of it before it leaves any out. A double, because it may be
/// more than there are integers.
template <int D>
double count_patches(const Shape& shape, double spacing);
/// Particles and patches are few enough for a computer; nothing is made of the shapes before.
template <int D>
void check_sizes(const Case& scene, const Setting& settings);
/// Bodies of fluid that reach out of the container or the domain by more than a spacing are told before they are filled.
template <int D>
void check_fluid_boxes(const Case& scene, const Setting& settings);
/// Frames and rows are few enough.
void check_output(const Case& scene, const Setting& settings);
/// Motions, gravity and speeds stay finite, and within the ranges of their keys, where and when they are looked at. Warns of motions that
/// jump, and of those that start at speed.
template <int D>
void check_motions(Case& scene, const Setting& settings);
/// Warns of what is allowed, but hardly meant.
template <int D>
void check_plausible(Case& scene, const Setting& settings);

/// The box around all places of a moving wall during the run.
template <int D>
Shape swept_box(const WallCase& wall, double end_time);
/// The domain around walls, or fluid and bodies, where the case gives none.
template <int D>
void set_default_domain(Case& scene, const Setting& settings);
/// The domain of the case has an extent and its periodic directions can repeat themselves; may warn.
template <int D>
void check_domain(Case& scene, const Setting& settings);

/// Clamps and loads name a body, and hold or load some of it.
template <int D>
void check_structure(const Case& scene, const Setting& settings);

/// What the definitions of the gauges demand (scene/gauges/).
void check_gauges(const Case& scene, const Setting& settings);

/// The elastic body that `what`, "gauge 'tip'", names.
const StructureBody& body_named(const std::string& name, const Case& scene, const std::string& where, const std::string& what);

}  // namespace tern
