// [structure], [[structure.body]] and [structure.numerics]

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.hpp"
#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"
#include "scene/mid_surface.hpp"
#include "structure/material/registry.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

/// The materials in words, "a, b, or c".
std::string material_meanings() {
  std::vector<std::string> meanings;
  structure::for_each_material([&]<class Law>() { meanings.push_back(Law::meaning); });
  meanings.back() = "or " + meanings.back();
  return fmt::format("{}", fmt::join(meanings, ", "));
}

const Rows<StructureBody>& body_rows() {
  // clang-format off
  static const Rows<StructureBody> rows = {
      {"name", &StructureBody::name, "", required, any, "Name of the body in gauges and messages; unique."},
      {"shape", &StructureBody::shape, "", required, any, "The undeformed body."},
      {"spacing", &StructureBody::spacing, "m", required, a_size,
       "Particle spacing dx_s; at least 2 and better 4 particles across the thinnest part. Made smaller, down to 0.7 of it, where the "
       "particles would have a mass more than 5 % off that of the shape."},
      {"density", &StructureBody::density, "kg/m^3", required, a_density, "Density of the undeformed body."},
      {"young_modulus", &StructureBody::young_modulus, "Pa", required, a_modulus, "Young's modulus E."},
      {"poisson_ratio", &StructureBody::poisson_ratio, "-", required, between(-1, 0.5), "Poisson's ratio nu."},
      {"clamp", &StructureBody::clamps, "", "[]", any,
       "Particles inside any of these shapes are fixed; one layer of them is enough. The outermost ones are moved onto the face of the "
       "region. Where fluid can come to it, its surface is wet."},
      {"hinge", &StructureBody::hinges, "", "[]", any,
       "Of a shell: each of these shapes contains one edge of its mid-surface and holds it in its place; the edge may turn. None reaches "
       "farther into the body than its thickness."},
      {"material", one_of(&StructureBody::material, structure::material_keys()), "", "\"neo_hookean\"", any,
       "Law of the material: " + material_meanings() + "."},
      {"model", one_of(&StructureBody::is_shell, {{"solid", false}, {"shell", true}}), "", absent, any,
       "solid (absent): particles fill the shape, in lines along the longest side of a polygon or line, the axes of a plate, else along "
       "the coordinates. shell: one layer of particles on the mid-surface of a box, whose shortest side is the "
       "thickness, of a ring or a line (2D), of a plate, a tube or a ball less a smaller one about its centre (3D). Clamps hold whole "
       "edges, those of a box are boxes, those of a plate reach into it by less than its thickness; a ball has none. Shells must "
       "not touch: there are no joints. It bends without transverse shear, so it has to be thin: 30 thicknesses between two "
       "clamps, 10 as a cantilever. A spacing of one to two thicknesses "
       "is enough; a ring needs 30 particles."},
      {"mooney_ratio", &StructureBody::mooney_ratio, "-", absent, from_to(0, 1),
       "Of mooney_rivlin: C01/(C10 + C01), how much of the shear modulus is that of the second invariant; absent = 0.2."},
      {"plane", one_of(&StructureBody::plane_stress, {{"strain", false}, {"stress", true}}), "", absent, any,
       "2D only: no strain (absent, strain) or no stress across the plane."},
      {"mass_damping", &StructureBody::mass_damping, "1/s", absent, a_rate,
       "Damping force over momentum: Rayleigh damping in proportion to the mass; for static answers about twice the lowest angular "
       "frequency. Absent = none. It acts on the whole velocity: what moves along with a clamp is held back as well."},
      {"velocity", &StructureBody::velocity, "m/s", absent, a_speed, "Initial velocity, expressions in x, y, z; absent = at rest."},
  };
  // clang-format on
  return rows;
}

const Rows<StructureNumerics>& numerics_rows() {
  // clang-format off
  static const Rows<StructureNumerics> rows = {
      {"smoothing_length_ratio", &StructureNumerics::smoothing_length_ratio, "-", "1.1", from_to(1.0, 2.5),
       "Smoothing length over particle spacing, h0/dx_s, of solids; 1.1 of shells."},
      {"riemann_diffusion", &StructureNumerics::riemann_diffusion, "-", "1.0", from_to(0, 2),
       "Coefficient chi of the complete-Riemann diffusion; 0 = off. Of a shell: its viscosity, as a multiple of the one that gives the "
       "fastest motion a tenth of critical damping."},
      {"courant", &StructureNumerics::courant, "-", "0.3", above_to(0, 0.6), "Sub-step as a fraction of dx_s/(c_p + |v|max)."},
      {"integrator",
       one_of(&StructureNumerics::integrator,
              {{"explicit", Integrator::explicit_steps}, {"implicit", Integrator::implicit_steps}, {"auto", Integrator::automatic}}),
       "", absent, any,
       "Explicit sub-steps with diffusion; one implicit step a window, without it; auto: whichever is cheaper, by a count "
       "of what the implicit steps take. Absent = auto beside a fluid, whose steps are what the motion needs; explicit alone, where "
       "nothing but the sub-steps resolves a wave."},
  };
  // clang-format on
  return rows;
}

/// Refuses what a shell has no equations for.
void check_shells(const StructureCase& structure, int dimension, const Setting& table) {
  for (std::size_t i = 0; i < structure.bodies.size(); ++i) {
    const StructureBody& body = structure.bodies[i];
    const std::string& where = table.at("body").items[i].where;
    if (!body.is_shell && !body.hinges.empty())
      throw BadInput(
          fmt::format("{}: the solid '{}' has a hinge, but only the edge of a shell is thin enough to turn in one; clamp it, or "
                      "make it a shell (model = \"shell\").",
                      where, body.name));
    if (!body.is_shell) continue;
    try {
      dimension == 2 ? void(mid_surface<2>(body)) : void(mid_surface<3>(body));
    } catch (const BadInput& fault) {
      throw BadInput(fmt::format("{}: {}", where, fault.what()));
    }
    if (!structure::Material(body).has_law_of_a_layer())
      throw BadInput(fmt::format("{}: the shell '{}' is of {}, which has no law of a layer; use another material, or model it as a solid.",
                                 where, body.name, body.material));
  }
}

}  // namespace

std::vector<TableDefinition> structure_tables() {
  return {{"structure", false, Presence::optional, "The elastic bodies; absent = no structure.", {}},
          {"structure.body", true, Presence::required, "An elastic body.", parameters_of(body_rows())},
          clamp_table(),
          load_table(),
          {"structure.numerics", false, Presence::filled, "Numerical options of the structure.", parameters_of(numerics_rows())}};
}

StructureCase read_structure(const Setting& table, int dimension, bool coupled, const std::filesystem::path& folder) {
  StructureCase structure;
  for (const Setting& item : table.at("body").items) {
    const StructureBody body = filled(body_rows(), item);
    if (const Setting* plane = item.find("plane"); plane && dimension == 3) {
      throw BadInput(
          fmt::format("{}: the body '{}' is in plane {}, which has no meaning in 3D; remove it.", plane->where, body.name, plane->text));
    }
    structure.bodies.push_back(body);
  }
  if (const Setting* clamps = table.find("clamp"))
    for (const Setting& clamp : clamps->items) structure.clamps.push_back(read_clamp(clamp, dimension, folder));
  for (const ClampCase& clamp : structure.clamps)
    for (StructureBody& body : structure.bodies)
      if (body.name == clamp.body) (clamp.is_hinge ? body.hinges : body.clamps).push_back(clamp.region);
  for (StructureBody& body : structure.bodies) body.clamps.insert(body.clamps.end(), body.hinges.begin(), body.hinges.end());
  if (const Setting* loads = table.find("load"))
    for (const Setting& load : loads->items) structure.loads.push_back(read_load(load));
  if (coupled) structure.numerics.integrator = Integrator::automatic;  // unless the case says another
  fill(structure.numerics, numerics_rows(), table.at("numerics"));
  check_shells(structure, dimension, table);
  return structure;
}

StructureNumerics default_structure_numerics() {
  static const StructureNumerics numerics = [] {
    StructureNumerics all{};
    fill_defaults(all, numerics_rows());
    return all;
  }();
  return numerics;
}

}  // namespace tern
