#include "scene/scene_check.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "scene/checks/checks.hpp"
#include "scene/placement.hpp"

namespace tern {
namespace {

template <int D>
void check_scene_in(Case& scene, const Setting& settings) {
  check_names(settings);
  check_output(scene, settings);
  check_sizes<D>(scene, settings);
  check_walls(scene, settings);
  check_motions<D>(scene, settings);
  set_default_domain<D>(scene, settings);
  check_domain<D>(scene, settings);
  check_fluid_boxes<D>(scene, settings);
  if (scene.fluid) {
    std::vector<Shape> shapes;
    for (const FluidBody& body : scene.fluid->bodies) shapes.push_back(body.shape);
    const double asked = std::exchange(scene.fluid->spacing, fitted_spacing<D>(shapes, scene.fluid->spacing));
    constexpr double said = 0.01;
    if (std::abs(scene.fluid->spacing - asked) > said * asked)
      scene.warnings.push_back(
          fmt::format("{}: the boxes of the fluid are no whole multiples of the spacing {:.4g} m; {:.4g} m is taken, with "
                      "which their particles have their mass.",
                      settings.at("fluid").at("spacing").where, asked, scene.fluid->spacing));
  }
  fit_spacings_of_bodies<D>(scene, settings);
  check_structure<D>(scene, settings);
  check_placement<D>(scene, settings);
  check_gauges(scene, settings);
  check_plausible<D>(scene, settings);
}

}  // namespace

void check_sizes(const Case& scene, const Setting& settings) {
  scene.dimension == 2 ? check_sizes<2>(scene, settings) : check_sizes<3>(scene, settings);
}

void check_scene(Case& scene, const Setting& settings) {
  scene.dimension == 2 ? check_scene_in<2>(scene, settings) : check_scene_in<3>(scene, settings);
}

}  // namespace tern
