#include "scene/scene_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "scene/checks/checks.hpp"
#include "scene/placement.hpp"

namespace tern {
namespace {

/// Of sentences that say the same of several bodies the first one stands, with the names of the others.
void say_once_of_many_bodies(Case& scene) {
  constexpr std::size_t named = 5;
  struct Sentence {
    std::string text, rest;  ///< rest: without the place in the file and the name of the body
    std::vector<std::string> others;
  };
  std::vector<Sentence> kept;
  for (const std::string& warning : scene.warnings) {
    Sentence sentence{warning, warning, {}};
    std::string about;
    for (const StructureBody& body : scene.structure->bodies) {
      const std::string quoted = "'" + body.name + "'";
      const std::size_t at = warning.find(quoted), sentence_begin = warning.find(": ");
      if (at == std::string::npos || sentence_begin > at) continue;
      about = quoted;
      sentence.rest = warning.substr(sentence_begin, at - sentence_begin) + warning.substr(at + quoted.size());
      break;
    }
    const auto alike = std::find_if(kept.begin(), kept.end(), [&](const Sentence& other) { return other.rest == sentence.rest; });
    if (about.empty() || alike == kept.end())
      kept.push_back(std::move(sentence));
    else
      alike->others.push_back(about);
  }
  scene.warnings.clear();
  for (Sentence& sentence : kept) {
    std::vector<std::string>& others = sentence.others;
    if (!others.empty()) {
      const std::size_t more = others.size() > named ? others.size() - named : 0;
      others.resize(others.size() - more);
      sentence.text += fmt::format(" The same holds of {}{}.", fmt::join(others, ", "), more > 0 ? fmt::format(" and {} more", more) : "");
    }
    scene.warnings.push_back(std::move(sentence.text));
  }
}

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
    fit_spacing_of_fluid<D>(scene, settings);
  }
  fit_spacings_of_bodies<D>(scene, settings);
  check_structure<D>(scene, settings);
  check_placement<D>(scene, settings);
  check_gauges(scene, settings);
  check_plausible<D>(scene, settings);
  if (scene.structure) say_once_of_many_bodies(scene);
}

}  // namespace

void check_sizes(const Case& scene, const Setting& settings) {
  scene.dimension == 2 ? check_sizes<2>(scene, settings) : check_sizes<3>(scene, settings);
}

void check_scene(Case& scene, const Setting& settings) {
  scene.dimension == 2 ? check_scene_in<2>(scene, settings) : check_scene_in<3>(scene, settings);
}

}  // namespace tern
