// [fluid], [[fluid.body]] and [fluid.numerics]

#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

const Rows<FluidCase>& fluid_rows() {
  // clang-format off
  static const Rows<FluidCase> rows = {
      {"density", &FluidCase::density, "kg/m^3", required, a_density, "Density."},
      {"spacing", &FluidCase::spacing, "m", required, a_size,
       "Particle spacing dx; stretched by a little where the boxes of the fluid are no whole multiples of it."},
      {"viscosity", &FluidCase::viscosity, "Pa s", absent, a_viscosity,
       "Dynamic viscosity mu; absent = inviscid. The fluid then sticks to walls without `slip`; elastic bodies stay frictionless."},
  };
  // clang-format on
  return rows;
}

const Rows<FluidBody>& body_rows() {
  // clang-format off
  static const Rows<FluidBody> rows = {
      {"shape", &FluidBody::shape, "", required, any,
       "Region that is filled; best when its sides are whole multiples of the spacing. Bodies and obstacles in it are cut out by "
       "`difference`."},
      {"velocity", &FluidBody::velocity, "m/s", absent, a_speed, "Initial velocity, expressions in x, y, z; absent = at rest."},
  };
  // clang-format on
  return rows;
}

const Rows<FluidNumerics>& numerics_rows() {
  // clang-format off
  static const Rows<FluidNumerics> rows = {
      {"smoothing_length_ratio", &FluidNumerics::smoothing_length_ratio, "-", "1.5", from_to(1.2, 2.5),
       "Smoothing length over particle spacing, h/dx."},
      {"gradient", one_of(&FluidNumerics::gradient, {{"blend", GradientForm::blend}, {"sum", GradientForm::sum}}), "", "\"blend\"", any,
       "Pressure gradient in the interior: the corrected form blended with the momentum-conserving sum, or the sum alone."},
      {"blend_theta", &FluidNumerics::blend_theta, "-", "1", from_to(0, 1),
       "Weight of the self-regularising part of the blended gradient."},
      {"density_relaxation", &FluidNumerics::density_relaxation, "-", "0.02", from_to(0, 1),
       "Share gamma of the density error that the pressure removes per relaxation time; 0 = off."},
      {"shifting", &FluidNumerics::shifting, "-", "1", from_to(0, 10),
       "Coefficient of the particle shifting, which evens particles out at up to 39 times this the rate of strain; 0 = off."},
      {"noise_damping", &FluidNumerics::noise_damping, "-", "0.2", from_to(0, 1),
       "Share of the particle-scale velocity noise (what a linear field does not explain) damped per relaxation time; 0 = off."},
      {"courant", &FluidNumerics::courant, "-", "0.4", above_to(0, 0.5),
       "Largest step as a fraction of dx/|u|max, to an observer who goes along where a whole scene is under way."},
      {"gravity_courant", &FluidNumerics::gravity_courant, "-", "0.1", above_to(0, 0.5),
       "Largest step as a fraction of sqrt(dx/|g|), also for the acceleration of walls in place of g."},
      {"viscous_courant", &FluidNumerics::viscous_courant, "-", "0.125", above_to(0, 0.125),
       "Largest step as a fraction of h^2/nu with nu = mu/rho; only with a viscosity."},
      {"contact_distance", &FluidNumerics::contact_distance, "dx", "0.25", from_to(0, 0.5),
       "No particle approaches a face closer than this many spacings; 0 = off."},
      {"pressure_tolerance", &FluidNumerics::pressure_tolerance, "-", "1e-6", from_to(1e-12, 1e-2),
       "Relative residual at which a pressure solve ends at the latest. Beside bodies it ends at a hundredth of the residual that it "
       "starts with, once that is below 1e-3, unless coupling.tolerance, coupling.max_iterations = 1 or a body of next to no mass asks for "
       "exact answers. Where there is no body, a second solve answers what the first one leaves, which ends at a tenth of what was left "
       "before. If the key is finer than 1e-6, all of these are finer in proportion, the last one a thousand times the key."},
  };
  // clang-format on
  return rows;
}

}  // namespace

std::vector<TableDefinition> fluid_tables() {
  return {{"fluid", false, Presence::optional, "The incompressible fluid; absent = no fluid.", parameters_of(fluid_rows())},
          {"fluid.body", true, Presence::required, "A region filled with fluid at the start.", parameters_of(body_rows())},
          {"fluid.numerics", false, Presence::filled, "Numerical options of the fluid.", parameters_of(numerics_rows())}};
}

FluidCase read_fluid(const Setting& table) {
  FluidCase fluid = filled(fluid_rows(), table);
  for (const Setting& body : table.at("body").items) fluid.bodies.push_back(filled(body_rows(), body));
  fill(fluid.numerics, numerics_rows(), table.at("numerics"));
  return fluid;
}

FluidNumerics default_fluid_numerics() {
  static const FluidNumerics numerics = [] {
    FluidNumerics all{};
    fill_defaults(all, numerics_rows());
    return all;
  }();
  return numerics;
}

}  // namespace tern
