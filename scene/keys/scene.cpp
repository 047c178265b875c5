// The top of a case file and [domain].

#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

// From a few ticks of 2^-32 s to the time up to which ticks are exact in a double (base/time.hpp).
constexpr Range a_duration{1e-9, 2097152, false, true};

Member<Case> directions() {
  return {ParameterType::choices,
          [](Case& scene, const Setting& list) {
            for (const Setting& direction : list.items) scene.periodic[direction.text[0] - 'x'] = true;
          },
          {"x", "y", "z"}};
}

const Rows<Case>& scene_rows() {
  // clang-format off
  static const Rows<Case> rows = {
      {"title", &Case::title, "", "\"\"", any, "One line that says what the scene is."},
      {"dimension", &Case::dimension, "-", required, from_to(2, 3), "Space dimension D; 2D quantities are per metre of depth."},
      {"end_time", &Case::end_time, "s", required, a_duration, "The run starts at 0 and ends here."},
      {"gravity", &Case::gravity, "m/s^2", required, an_acceleration,
       "Acceleration of fluid and structure, one entry per direction; expressions in t, x, y, z."},
      {"preset", one_of(&Case::preset, {"draft", "standard", "reference", "paper"}), "", "\"standard\"", any,
       "Group of numerical options. standard: the case as it stands, with the defaults in this document. draft: twice the spacings (of "
       "an elastic body only where 4 particles remain across), or 1.75, 1.5 or 1.25 times where check refuses more, without a structure "
       "fluid.numerics gravity_courant 0.2, structure.numerics integrator auto. reference: half the spacings. Both leave numerical options "
       "alone that the case states; `tern check` prints what they make of it, docs/TRADE.md what that costs and how far off it is. paper: "
       "the published interaction, in place of what the case says: coupling.algorithm explicit, scheme riemann, vem with coefficient 5 "
       "and form seed. It loses momentum, and is refused where the added mass makes it unstable, unless --allow-unstable is given."},
  };
  // clang-format on
  return rows;
}

const Rows<Case>& domain_rows() {
  // clang-format off
  static const Rows<Case> rows = {
      {"min", &Case::domain_min, "m", required, a_place, "Lower corner."},
      {"max", &Case::domain_max, "m", required, a_place, "Upper corner."},
      {"periodic", directions(), "", "[]", any,
       "Directions in which the fluid repeats itself with the period max - min: what leaves on one side enters on the other; without "
       "elastic bodies. A wall moves along them as a box from end to end alone, like a belt."},
  };
  // clang-format on
  return rows;
}

}  // namespace

std::vector<TableDefinition> scene_tables() {
  return {{"", false, Presence::filled, "The scene as a whole.", parameters_of(scene_rows())},
          {"domain", false, Presence::optional,
           "Fluid particles that leave this box are removed and counted; default: the box around the walls (without walls: the fluid), "
           "enlarged by half of its longest side.",
           parameters_of(domain_rows())}};
}

Case read_scene(const Setting& settings, const std::filesystem::path& folder) {
  Case scene = filled(scene_rows(), settings);
  if (const Setting* domain = settings.find("domain")) fill(scene, domain_rows(), *domain);
  if (const Setting* walls = settings.find("wall"))
    for (const Setting& wall : walls->items) scene.walls.push_back(read_wall(wall, scene.dimension, folder));
  if (const Setting* fluid = settings.find("fluid")) scene.fluid = read_fluid(*fluid);
  if (const Setting* structure = settings.find("structure"))
    scene.structure = read_structure(*structure, scene.dimension, scene.fluid.has_value(), folder);
  if (const Setting* coupling = settings.find("coupling")) scene.coupling = read_coupling(*coupling);
  if (const Setting* gauges = settings.find("gauge"))
    for (const Setting& gauge : gauges->items) scene.gauges.push_back(read_gauge(gauge, scene));
  scene.output = read_output(settings.at("output"));
  return scene;
}

}  // namespace tern
