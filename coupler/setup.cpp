#include "coupler/setup.hpp"

#include <algorithm>

#include "coupler/schemes/scheme.hpp"
#include "scene/estimate.hpp"

namespace tern::coupler {
namespace {

/// A light body follows the load at once, and what a window changes of it, above all which particles touch, is more than the coupling
/// iterations can bring to agree in windows as long as the fluid alone takes them.
constexpr double window_share_of_light = 0.5;
/// Largest Robin mass of a surface whose answer is not learnt when windows are repeated, in layers of fluid particles; from 2 to 12 the
/// iterations are as many. In long windows few motions of a light body answer with its mass, all others are held by its stiffness. A mass
/// like the fluid's own lies between the two; the iterations find out what it gets wrong.
constexpr double layers_of_held = 5;

/// Of every body, whether it has no more behind its faces than so many layers of fluid particles.
std::vector<bool> are_below(double layers, const Case& scene, const SurfaceProperties& properties) {
  std::vector<bool> below;
  for (std::size_t b = 0; b < scene.structure->bodies.size(); ++b) {
    const double mass = section_mass(properties, b);
    below.push_back(mass > 0 && mass <= layers * scene.fluid->density * scene.fluid->spacing);
  }
  return below;
}

bool any(const std::vector<bool>& bodies) { return std::find(bodies.begin(), bodies.end(), true) != bodies.end(); }

/// What to change when the coupling diverges.
const char* remedy_of(const CouplingCase& coupling) {
  if (coupling.algorithm == CouplingAlgorithm::explicit_staggering)
    return "explicit staggering is unstable for a body that is light for its fluid, or that vibrates faster than the windows resolve, use "
           "coupling.algorithm = \"auto\"";
  if (coupling.max_iterations == 1) return "one pass is not enough for this body, leave out coupling.max_iterations = 1";
  return "the windows are too long for this body, use a smaller fluid.numerics.gravity_courant and courant";
}

/// Whether first passes tell how the surface answers: not where a tolerance of the load is asked for, nor where a body has next to no mass.
bool learns_from_first_passes(const Case& scene, const SurfaceProperties& properties) {
  if (scene.coupling.algorithm == CouplingAlgorithm::explicit_staggering) return false;
  if (scene.coupling.max_iterations == 1) return true;
  return !scene.coupling.tolerance && !any(are_below(layers_of_lightest, scene, properties));
}

}  // namespace

template <int D>
Setup<D>::Setup(const Case& scene, const SurfaceProperties& of_surface)
    : coupling(scene.coupling),
      iterates(scene.coupling.algorithm == CouplingAlgorithm::automatic),
      learns(learns_from_first_passes(scene, of_surface)),
      remedy(remedy_of(scene.coupling)),
      scheme(scheme_of<D>(scene.coupling.scheme)),
      first_window(tern::first_window(scene)),
      window_of_loads(tern::window_of_loads(scene)),
      is_light(are_below(layers_of_light, scene, of_surface)),
      window_share(any(is_light) ? window_share_of_light : 1),
      density(scene.fluid->density),
      spacing(scene.fluid->spacing),
      smoothing_length(scene.fluid->numerics.smoothing_length_ratio * scene.fluid->spacing),
      contact_distance(scene.fluid->numerics.contact_distance * scene.fluid->spacing),
      courant(window_share * scene.fluid->numerics.courant),
      robin_mass_factor(iterates && !learns ? 1 : coupling.robin_mass_factor),
      mass_of_held(iterates && !learns ? layers_of_held * density * spacing : 0),
      gravity(scene.gravity),
      properties(of_surface),
      meetable(scene, of_surface.body),
      kernel(smoothing_length),
      fluid_weight(weight_of_fluid<D>(scene)) {
  for (const double depth : moved_depths<D>(scene, fluid_weight)) moved_mass.push_back(density * depth);
  for (const StructureBody& body : scene.structure->bodies) {
    is_held.push_back(!body.clamps.empty());
    body_density.push_back(body.density);
    body_name.push_back(body.name);
  }
}

template struct Setup<2>;
template struct Setup<3>;

}  // namespace tern::coupler
