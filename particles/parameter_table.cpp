// The keys of a case file. Defaults exist for numerics only, never for physics.

#include "particles/parameter_table.hpp"

#include <fmt/format.h>

namespace tern {
namespace {

using Type = ParameterType;
using Presence = TableDefinition::Presence;
constexpr double infinity = std::numeric_limits<double>::infinity();

const Range any{};
const Range positive{0, infinity, true, true};
const Range not_negative{0, infinity, false, true};

Range from_to(double lowest, double highest) { return {lowest, highest, false, false}; }
Range above_to(double lowest, double highest) { return {lowest, highest, true, false}; }
Range between(double lowest, double highest) { return {lowest, highest, true, true}; }

}  // namespace

// clang-format off: one parameter per entry, like the rows of a table.
const std::vector<TableDefinition>& table_definitions() {
  static const std::vector<TableDefinition> definitions = {
      {"", false, Presence::filled, "The scene as a whole."},
      {"domain", false, Presence::optional,
       "Fluid particles that leave this box are removed and counted; default: the box around the walls (without "
       "walls: the fluid), enlarged by half of its longest side."},
      {"wall", true, Presence::optional, "A rigid, impermeable wall; either `container` or `obstacle`."},
      {"fluid", false, Presence::optional, "The incompressible fluid; absent = no fluid."},
      {"fluid.body", true, Presence::required, "A region filled with fluid at the start."},
      {"fluid.numerics", false, Presence::filled, "Numerical options of the fluid."},
      {"structure", false, Presence::optional, "The elastic bodies; absent = no structure."},
      {"structure.body", true, Presence::required, "An elastic body."},
      {"structure.clamp", true, Presence::optional,
       "A clamp with a name, which can move and whose reaction can be measured; a region of `clamp` in [[structure.body]] "
       "is fixed."},
      {"structure.load", true, Presence::optional,
       "A load on a body; exactly one of `traction`, `pressure` and `body_force`, expressions in t and in the place x, y, z "
       "in the undeformed body."},
      {"structure.numerics", false, Presence::filled, "Numerical options of the structure."},
      {"coupling", false, Presence::filled,
       "What happens between fluid and structure; only in a case that has both."},
      {"coupling.vem", false, Presence::optional,
       "The velocity-divergence-error-mitigating term at the interface; absent = not evaluated."},
      {"gauge", true, Presence::optional, "A quantity written to gauges.csv."},
      {"output", false, Presence::filled, "What a run writes, and how often."},
      {"shape", false, Presence::filled,
       "A solid, written as an inline table with exactly one of these keys, e.g. `{ box = { min = [0, 0], max = [1, "
       "2] } }`."},
      {"shape.box", false, Presence::filled, "A box along the axes."},
      {"shape.polygon", false, Presence::filled, "A polygon; 2D only."},
      {"shape.ball", false, Presence::filled, "A disc (2D) or ball (3D)."},
  };
  return definitions;
}

const std::vector<Parameter>& parameters() {
  static const std::vector<Parameter> list = {
      {"", "title", Type::text, "", "\"\"", any, {}, "One line that says what the scene is."},
      {"", "dimension", Type::integer, "-", "required", from_to(2, 3), {},
       "Space dimension D; 2D quantities are per metre of depth."},
      {"", "end_time", Type::number, "s", "required", between(0, 2097152), {}, "The run starts at 0 and ends here."},
      {"", "gravity", Type::expressions, "m/s^2", "required", any, {},
       "Acceleration of fluid and structure, one entry per direction; expressions in t, x, y, z."},
      {"", "preset", Type::choice, "", "\"standard\"", any, {"draft", "standard", "reference", "paper"},
       "Group of numerical options. standard: the case as it stands, with the defaults in this document. draft: twice the spacings (of an "
       "elastic body only where 4 particles remain across), fluid.numerics courant 0.3, without a structure gravity_courant 0.2, structure.numerics integrator auto. "
       "reference: half the spacings, coupling.algorithm CM3. Both leave numerical options alone that the case states; `tern check` prints "
       "what they make of it, docs/TRADE.md what that costs and how far off it is. paper: the published interaction, in place of what the "
       "case says: coupling.algorithm CM0, scheme riemann, vem with coefficient 5 and form seed. It loses momentum, and is refused "
       "where the added mass makes it unstable, unless --allow-unstable is given."},
      {"domain", "min", Type::point, "m", "required", any, {}, "Lower corner."},
      {"domain", "max", Type::point, "m", "required", any, {}, "Upper corner."},
      {"domain", "periodic", Type::choices, "", "[]", any, {"x", "y", "z"},
       "Directions in which the fluid repeats itself with the period max - min: what leaves on one side enters on the "
       "other."},

      {"wall", "name", Type::text, "", "required", any, {}, "Name of the wall in messages; unique."},
      {"wall", "container", Type::shape, "", "absent", any, {}, "The fluid stays inside this shape."},
      {"wall", "obstacle", Type::shape, "", "absent", any, {}, "The fluid stays outside this shape."},
      {"wall", "open", Type::choices, "", "[]", any, {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"},
       "Faces left out; of a container that is a box only."},
      {"wall", "displacement", Type::expressions, "m", "absent", any, {},
       "Displacement from the initial place as expressions in t, 0 at t = 0; absent = none."},
      {"wall", "rotation", Type::expression, "rad", "absent", any, {},
       "Angle by which the wall is turned about `pivot` before it is displaced, an expression in t, 0 at t = 0; positive "
       "from x to y, in 3D by the right hand about `axis`."},
      {"wall", "motion_file", Type::text, "", "absent", any, {},
       "In place of both: a CSV file, its path relative to the case file, with a header of t_s and some of x_m, y_m, "
       "z_m, angle_rad and the first row 0 at t = 0; splines between its rows, the last row is held."},
      {"wall", "pivot", Type::point, "m", "absent", any, {}, "Point about which a wall with a rotation turns, at t = 0."},
      {"wall", "axis", Type::point, "", "absent", any, {}, "Direction of the axis of a rotation; 3D only."},
      {"wall", "slip", Type::boolean, "", "false", any, {},
       "A wall without friction although the fluid has a viscosity; without viscosity every wall is one."},

      {"fluid", "density", Type::number, "kg/m^3", "required", positive, {}, "Density."},
      {"fluid", "spacing", Type::number, "m", "required", positive, {}, "Particle spacing dx."},
      {"fluid", "viscosity", Type::number, "Pa s", "absent", positive, {},
       "Dynamic viscosity mu; absent = inviscid. The fluid then sticks to walls without `slip`; elastic bodies stay "
       "frictionless."},
      {"fluid.body", "shape", Type::shape, "", "required", any, {},
       "Region that is filled; best when its sides are whole multiples of the spacing."},
      {"fluid.body", "velocity", Type::expressions, "m/s", "absent", any, {},
       "Initial velocity, expressions in x, y, z; absent = at rest."},
      {"fluid.numerics", "smoothing_length_ratio", Type::number, "-", "1.5", from_to(1.2, 2.5), {},
       "Smoothing length over particle spacing, h/dx."},
      {"fluid.numerics", "gradient", Type::choice, "", "\"blend\"", any, {"blend", "sum"},
       "Pressure gradient in the interior: the corrected form blended with the momentum-conserving sum, or the sum "
       "alone."},
      {"fluid.numerics", "blend_theta", Type::number, "-", "0.5", from_to(0, 1), {},
       "Weight of the self-regularising part of the blended gradient."},
      {"fluid.numerics", "density_relaxation", Type::number, "-", "0.02", from_to(0, 1), {},
       "Share gamma of the density error that the pressure removes per relaxation time; 0 = off."},
      {"fluid.numerics", "shifting", Type::number, "-", "0.5", from_to(0, 10), {},
       "Coefficient of the particle shifting; 0 = off. Vortices that fill their enclosure need about 4."},
      {"fluid.numerics", "noise_damping", Type::number, "-", "0.2", from_to(0, 1), {},
       "Share of the particle-scale velocity noise (what a linear field does not explain) damped per relaxation time; 0 = "
       "off."},
      {"fluid.numerics", "courant", Type::number, "-", "0.15", above_to(0, 0.5), {},
       "Largest step as a fraction of dx/|u|max."},
      {"fluid.numerics", "gravity_courant", Type::number, "-", "0.1", above_to(0, 0.5), {},
       "Largest step as a fraction of sqrt(dx/|g|)."},
      {"fluid.numerics", "viscous_courant", Type::number, "-", "0.125", above_to(0, 0.125), {},
       "Largest step as a fraction of h^2/nu with nu = mu/rho; only with a viscosity."},
      {"fluid.numerics", "contact_distance", Type::number, "dx", "0.25", from_to(0, 0.5), {},
       "No particle approaches a face closer than this many spacings; 0 = off."},
      {"fluid.numerics", "pressure_tolerance", Type::number, "-", "1e-6", from_to(1e-12, 1e-2), {},
       "Relative residual at which the pressure solve ends."},

      {"structure.body", "name", Type::text, "", "required", any, {},
       "Name of the body in gauges and messages; unique."},
      {"structure.body", "shape", Type::shape, "", "required", any, {}, "The undeformed body."},
      {"structure.body", "spacing", Type::number, "m", "required", positive, {},
       "Particle spacing dx_s; at least 2 and better 4 particles across the thinnest part."},
      {"structure.body", "density", Type::number, "kg/m^3", "required", positive, {},
       "Density of the undeformed body."},
      {"structure.body", "young_modulus", Type::number, "Pa", "required", positive, {}, "Young's modulus E."},
      {"structure.body", "poisson_ratio", Type::number, "-", "required", between(-1, 0.5), {}, "Poisson's ratio nu."},
      {"structure.body", "clamp", Type::shapes, "", "[]", any, {}, "Particles inside any of these shapes are fixed; one layer of them is enough. The outermost ones are moved onto the face "
       "of the region."},
      {"structure.body", "material", Type::choice, "", "\"neo_hookean\"", any, {"neo_hookean", "st_venant_kirchhoff"},
       "Law of the material: compressible neo-Hookean, or St Venant-Kirchhoff (which gives way under strong compression)."},
      {"structure.body", "plane", Type::choice, "", "absent", any, {"strain", "stress"},
       "2D only: no strain (absent, strain) or no stress across the plane."},
      {"structure.body", "mass_damping", Type::number, "1/s", "absent", positive, {},
       "Damping force over momentum: Rayleigh damping in proportion to the mass; for static answers about twice the lowest "
       "angular frequency. Absent = none."},
      {"structure.body", "velocity", Type::expressions, "m/s", "absent", any, {},
       "Initial velocity, expressions in x, y, z; absent = at rest."},
      {"structure.clamp", "name", Type::text, "", "required", any, {}, "Name of the clamp in gauges and messages; unique."},
      {"structure.clamp", "body", Type::text, "", "required", any, {}, "The elastic body it holds."},
      {"structure.clamp", "region", Type::shape, "", "required", any, {},
       "Particles of the undeformed body inside this shape are held."},
      {"structure.clamp", "displacement", Type::expressions, "m", "absent", any, {},
       "Displacement from the initial place as expressions in t, 0 at t = 0; absent = none."},
      {"structure.clamp", "rotation", Type::expression, "rad", "absent", any, {},
       "Angle by which the clamp is turned about `pivot` before it is displaced, an expression in t, 0 at t = 0; positive "
       "from x to y, in 3D by the right hand about `axis`."},
      {"structure.clamp", "motion_file", Type::text, "", "absent", any, {},
       "In place of both: a CSV file as of a [[wall]]."},
      {"structure.clamp", "pivot", Type::point, "m", "absent", any, {}, "Point about which it turns, at t = 0."},
      {"structure.clamp", "axis", Type::point, "", "absent", any, {}, "Direction of the axis of a rotation; 3D only."},
      {"structure.load", "name", Type::text, "", "required", any, {}, "Name of the load in messages; unique."},
      {"structure.load", "body", Type::text, "", "required", any, {}, "The elastic body it acts on."},
      {"structure.load", "region", Type::shape, "", "absent", any, {},
       "Part of the undeformed body that is loaded; of a traction or pressure, the surface inside it. Absent = the whole."},
      {"structure.load", "traction", Type::expressions, "Pa", "absent", any, {},
       "Force per undeformed area; it keeps its direction."},
      {"structure.load", "pressure", Type::expression, "Pa", "absent", any, {},
       "Pressure on the present surface; it turns and stretches with it."},
      {"structure.load", "body_force", Type::expressions, "N/m^3", "absent", any, {}, "Force per undeformed volume."},
      {"structure.numerics", "smoothing_length_ratio", Type::number, "-", "1.1", from_to(1.0, 2.5), {},
       "Smoothing length over particle spacing, h0/dx_s."},
      {"structure.numerics", "riemann_diffusion", Type::number, "-", "1.0", from_to(0, 2), {},
       "Coefficient chi of the complete-Riemann diffusion; 0 = off."},
      {"structure.numerics", "hourglass_penalty", Type::number, "-", "0", from_to(0, 1), {},
       "Coefficient alpha of the penalty on zero-energy modes; 0 = off: the energy of the strain gradient holds them already."},
      {"structure.numerics", "courant", Type::number, "-", "0.3", above_to(0, 0.6), {},
       "Sub-step as a fraction of dx_s/(c_p + |v|max)."},
      {"structure.numerics", "integrator", Type::choice, "", "absent", any, {"explicit", "implicit", "auto"},
       "Explicit sub-steps with diffusion; implicit steps of at most 100 sub-steps, without it; auto: whichever is cheaper, by "
       "a count of what the implicit steps take. Absent = auto beside a fluid, whose steps are what the motion needs; explicit "
       "alone, where nothing but the sub-steps resolves a wave."},

      {"coupling", "algorithm", Type::choice, "", "\"auto\"", any, {"auto", "CM0", "CM2", "CM3"},
       "CM2: predict, project, correct; CM3: the same, repeated until both sides agree, for bodies of any lightness; CM0: explicit "
       "staggering, unstable where the fluid's added mass exceeds the mass of the structure; auto: CM3 where the mass behind a "
       "face is at most that of half a layer of fluid particles, else CM2."},
      {"coupling", "acceleration", Type::choice, "", "\"iqn-ils\"", any, {"iqn-ils", "aitken"},
       "How CM3 finds its next trial: quasi-Newton from the trials before, of this and earlier windows; or one factor."},
      {"coupling", "tolerance", Type::number, "-", "1e-4", between(0, 1), {},
       "Change of the load from one trial of CM3 to the next, over the load, at which the window is done."},
      {"coupling", "scheme", Type::choice, "", "\"riemann\"", any, {"fsa", "pi", "riemann"},
       "How the fluid's pressure becomes a load (docs/SCHEMES.md). riemann: particle by particle, with Riemann dissipation; pi: "
       "the mean pressure at a face times its area; fsa: the same with the corrected pressure gradient of the fluid."},
      {"coupling", "riemann_limiter", Type::number, "-", "3.0", not_negative, {},
       "Limiter eta of the Riemann dissipation, beta = min(eta max(du, 0)/c0, 1); 0 = none. Of scheme riemann only."},
      {"coupling", "robin_mass_factor", Type::number, "-", "1.0", between(0, 2), {},
       "Mass with which the interface yields in the pressure solve over the mass behind it, m_p/m_s; a light body needs "
       "less than 4/3."},
      {"coupling.vem", "coefficient", Type::number, "-", "required", above_to(0, 10), {},
       "Coefficient C; 1 is advised, 5 over-predicts impact loads."},
      {"coupling.vem", "form", Type::choice, "", "\"pairmax\"", any, {"seed", "sum", "pairmax"},
       "pairmax: pushes apart where the fluid converges; sum: pulls together too where it diverges; seed: each side switches "
       "by itself as published, which does not conserve momentum."},

      {"gauge", "kind", Type::choice, "", "required", any,
       {"displacement", "pressure", "elevation", "front", "interface_force", "force", "wall_pressure", "reaction", "flux"},
       "displacement of a body's material point [m]; pressure of the fluid at a point [Pa]; elevation of the free "
       "surface at a place [m]; front: largest x the connected fluid reaches [m]; interface_force on a body "
       "[N/m^(3-D)]; force on a rigid wall [N/m^(3-D)] and its moment [N m/m^(3-D)]; wall_pressure: mean over a sensor "
       "on a rigid wall [Pa]; reaction: force [N/m^(3-D)] and moment [N m/m^(3-D)] with which a clamp, or all clamps of a "
       "body, hold it; flux through a line or rectangle [m^D/s]."},
      {"gauge", "name", Type::text, "", "required", any, {}, "Name of the column; unique."},
      {"gauge", "body", Type::text, "", "absent", any, {}, "Elastic body; displacement, interface_force and reaction need it."},
      {"gauge", "clamp", Type::text, "", "absent", any, {},
       "A named clamp of the body, of a reaction; absent = all clamps of the body."},
      {"gauge", "at", Type::point, "m", "absent", any, {},
       "Where: displacement (in the undeformed body), pressure, elevation (whose y entry is not used) and wall_pressure (on "
       "the wall at t = 0) need it; force: the point of the moment, default the wall's pivot, else the origin. On a wall "
       "that moves, it moves along. Reaction: the point of the moment, fixed in space, default the origin."},
      {"gauge", "wall", Type::text, "", "absent", any, {}, "Rigid wall; force and wall_pressure need it."},
      {"gauge", "diameter", Type::number, "m", "absent", positive, {},
       "Of the sensor of a wall_pressure; absent = one spacing of the fluid."},
      {"gauge", "from", Type::point, "m", "absent", any, {},
       "Flux: begin of the line, or one corner of the rectangle; seen from here, flow to the right counts as positive (3D: "
       "flow along the positive axis)."},
      {"gauge", "to", Type::point, "m", "absent", any, {},
       "Flux: end of the line, or the opposite corner; in 3D both agree in one coordinate."},

      {"output", "frame_interval", Type::number, "s", "0", not_negative, {},
       "Time between frames of the particle fields; 0 = the first and the last only."},
      {"output", "gauge_interval", Type::number, "s", "0", not_negative, {},
       "Time between rows of gauges.csv; 0 = every step."},

      {"shape", "box", Type::shape, "", "absent", any, {}, "See `shape.box`."},
      {"shape", "polygon", Type::shape, "", "absent", any, {}, "See `shape.polygon`."},
      {"shape", "ball", Type::shape, "", "absent", any, {}, "See `shape.ball`."},
      {"shape", "union", Type::shapes, "", "absent", any, {},
       "List of shapes; a point of any of them belongs to the solid."},
      {"shape", "difference", Type::shapes, "", "absent", any, {}, "List of shapes; the first without the others."},
      {"shape.box", "min", Type::point, "m", "required", any, {}, "Lower corner."},
      {"shape.box", "max", Type::point, "m", "required", any, {}, "Upper corner."},
      {"shape.polygon", "vertices", Type::vertices, "m", "required", any, {},
       "Corners in order, either way round; sides must not cross."},
      {"shape.ball", "center", Type::point, "m", "required", any, {}, "Centre."},
      {"shape.ball", "radius", Type::number, "m", "required", positive, {}, "Radius."},
  };
  return list;
}
// clang-format on

std::string describe(const Range& range) {
  const bool below = range.lowest > -infinity, over = range.highest < infinity;
  if (below && over) {
    return fmt::format("from {}{} to {}{}", range.lowest, range.lowest_excluded ? " (excluded)" : "", range.highest,
                       range.highest_excluded ? " (excluded)" : "");
  }
  if (below) return fmt::format("{} {}", range.lowest_excluded ? "greater than" : "at least", range.lowest);
  if (over) return fmt::format("{} {}", range.highest_excluded ? "less than" : "at most", range.highest);
  return "";
}

}  // namespace tern
