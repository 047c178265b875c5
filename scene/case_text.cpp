// `tern-case check` and `tern-case explain`: the estimate and the scene as text.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/threads.hpp"
#include "scene/estimate.hpp"
#include "scene/mid_surface.hpp"
#include "structure/material/registry.hpp"

namespace tern {
namespace {

std::string words_of(const CouplingCase& coupling) {
  if (coupling.algorithm == CouplingAlgorithm::explicit_staggering) return "the explicit coupling (staggered)";
  const std::string pass = "one pass a window (predict, project, correct)";
  if (coupling.max_iterations == 1) return pass;
  if (coupling.tolerance) return fmt::format("{}, repeated until the load changes by less than {:g} of itself", pass, *coupling.tolerance);
  return pass + ", repeated where fluid and structure do not agree after it";
}

/// A ratio with one decimal, as a whole number from 100 on, or in brief where it is absurd.
std::string ratio(double number) {
  return number < 1e6 ? fmt::format("{:.{}f}", number, number < 100 ? 1 : 0) : fmt::format("{:.3g}", number);
}

/// A count in full, or in brief where it is absurd.
std::string count(double number) { return number < 1e9 ? fmt::format("{:.0f}", number) : fmt::format("{:.3g}", number); }

std::string duration(double seconds) {
  if (seconds < 1) return "less than a second";
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} min", seconds / 60);
  if (seconds < 3.6e9) return fmt::format("{:.1f} h", seconds / 3600);
  return fmt::format("{:.3g} years", seconds / (365.25 * 86400));
}

std::string iterations_text(const Estimate& e) {
  return e.iterations >= 1.5 ? fmt::format(" of about {:.0f} coupling iterations", e.iterations) : "";
}

std::string step_limits(const Case& scene, const Estimate& e) {
  std::string text;
  if (scene.fluid) {
    if (std::isfinite(e.gravity_step)) {
      text += fmt::format("  {:<16} {:.3g} s = {} sqrt(dx/{}\n", e.gravity > 0 ? "gravity" : "walls", e.gravity_step,
                          scene.fluid->numerics.gravity_courant, e.gravity > 0 ? "|g|)" : "a), a: of walls that move, in the mean");
    }
    if (std::isfinite(e.viscous_step)) {
      text += fmt::format("  viscosity        {:.3g} s = {} h^2/nu\n", e.viscous_step, scene.fluid->numerics.viscous_courant);
    }
    if (std::isfinite(e.flow_step)) {
      text += fmt::format("  speed            {:.3g} s = {} dx/|u| at {:.3g} m/s, {}, or bodies, walls and clamps that move\n", e.flow_step,
                          scene.fluid->numerics.courant, e.speed,
                          e.settled ? "half of sqrt(|g| H), the least that is reckoned with"
                                    : "the free fall over the height of the scene, the initial speed");
    }
  }
  if (e.light) text += "  light body       half of the least of these: it weighs less than half a layer of fluid particles\n";
  if (std::isfinite(e.motion_step)) {
    text += fmt::format("  motion           {:.3g} s = what leaves 1e-4 dx of the place of a body that vibrates from the start on\n",
                        e.motion_step);
  }
  for (const BodyEstimate& body : e.bodies) {
    text += fmt::format("  {:<16} {:.3g} s = {} dx_s/c_p, c_p = {:.4g} m/s (sub-step)\n", body.name, body.sub_step,
                        scene.structure->numerics.courant, body.wave_speed);
    constexpr double windows_of_a_vibration = 20;
    // In fluid at rest the speed that is reckoned with binds nothing, and whether a body is light does not matter.
    const bool by_gravity = std::isfinite(e.gravity_step) && (e.settled || e.gravity_step <= e.flow_step);
    if (const double windows = body.bending_period / e.step; scene.fluid && windows > 0 && windows < windows_of_a_vibration)
      text += fmt::format(
          "  {:<16} its first bending takes about {:.2g} s, {:.2g} windows: vibrations of less than some hundredths of dx die "
          "out; to see them, {} {:.2g}\n",
          "", body.bending_period, windows, by_gravity ? "fluid.numerics.gravity_courant =" : "fluid.numerics.courant =",
          (by_gravity ? scene.fluid->numerics.gravity_courant : scene.fluid->numerics.courant) * windows / windows_of_a_vibration);
  }
  if (scene.structure)
    text += fmt::format(
        "  sub-steps        {} of the structure in a step{}{}\n", count(e.sub_steps),
        scene.fluid ? "" : fmt::format(", {:.3g} s: at most {:.0f}, and to the next output", e.step, sub_steps_per_window(scene)),
        scene.structure->numerics.integrator == Integrator::explicit_steps   ? ""
        : scene.structure->numerics.integrator == Integrator::implicit_steps ? ", replaced by implicit ones"
                                                                             : ", or implicit ones where cheaper");
  return text;
}

std::string origin(const Costs& costs) {
  return costs.measured.empty() ? "typical costs; ./tern measures those of this machine once it is built"
                                : "measured on this machine on " + costs.measured;
}

// By the clock: a share of the fluid's step has one thread, whatever there are (docs/SPEED.md, Threads).
std::string wall_time_text(const Case& scene, const Estimate& e, int cores) {
  constexpr double on_one_thread = 0.2;
  const int threads = scene.fluid ? threads_worth(e.fluid_particles, cores) : 1;
  const double wall = e.structure_cpu + e.coupler_cpu + e.fluid_cpu * (on_one_thread + (1 - on_one_thread) / threads);
  const std::string waiting = scene.fluid && scene.structure ? "fluid and structure mostly wait for each other, so " : "";
  if (threads == 1) return waiting + "wall time is about the same";
  return fmt::format("{}wall time is about {} with {} threads of the fluid", waiting, duration(wall), threads);
}

// One line per change; nothing for a case as it stands.
std::string preset_text(const Case& scene) {
  if (scene.preset_changes.empty()) return "";
  std::string text = fmt::format("preset {} (its error and cost: docs/TRADE.md; --set goes on top)\n", scene.preset);
  for (const std::string& change : scene.preset_changes) text += "  " + change + "\n";
  return text;
}

}  // namespace

std::string check_text(const Case& scene, const Costs& costs, int cores) {
  const Estimate e = estimate(scene, costs);
  std::string text = fmt::format("{}: valid ({}D, hash {})\n", scene.name, scene.dimension, scene.hash);
  text += "particles\n";
  if (scene.fluid) text += fmt::format("  fluid            {} of {} m\n", e.fluid_particles, scene.fluid->spacing);
  for (std::size_t i = 0; i < e.bodies.size(); ++i) {
    const BodyEstimate& body = e.bodies[i];
    const double spacing = scene.structure->bodies[i].spacing;
    text += fmt::format("  {:<16} {} of {} m, {} of them held, {:.3g} across; {} surface points\n", body.name, body.particles, spacing,
                        body.clamped, body.thickness / spacing, body.surface_points);
  }
  text += preset_text(scene);
  text += "step limits\n" + step_limits(scene, e);
  for (const BodyEstimate& body : e.bodies) {
    if (body.added_mass_ratio > 0) {
      text += fmt::format("added mass over mass of {}: about {} with one wet face, {} with two\n", body.name, ratio(body.added_mass_ratio),
                          ratio(2 * body.added_mass_ratio));
    }
  }
  const double cpu = e.fluid_cpu + e.structure_cpu + e.coupler_cpu;
  text += fmt::format("expected for {} s: about {} steps{}, {} of CPU", scene.end_time, count(e.steps), iterations_text(e), duration(cpu));
  if (scene.fluid && scene.structure) {
    text += fmt::format(" (fluid {}, structure {}, coupler {})", duration(e.fluid_cpu), duration(e.structure_cpu), duration(e.coupler_cpu));
  }
  text += fmt::format(", {:.0f} MB\n", e.memory / 1e6);
  text += fmt::format("  (from {:.2g} us per fluid particle and step and {:.0f} ns per structure particle and sub-step in 2D, {};\n  {})\n",
                      costs.fluid * 1e6, costs.structure * 1e9, origin(costs), wall_time_text(scene, e, cores));
  for (const std::string& warning : scene.warnings) text += "warning: " + warning + "\n";
  return text;
}

namespace {

/// What "auto" does in a window, as far as that follows from the mass behind a face.
std::string algorithm_choice(const Case& scene, const Estimate& e) {
  const double layer = scene.fluid->density * scene.fluid->spacing;
  const auto words = [&](double mass) {
    return mass <= layers_of_lightest * layer ? "every window is repeated, and half as long"
           : mass <= layers_of_light * layer  ? "one pass a window, repeated where it is not enough, and windows half as long"
                                              : "one pass a window, repeated where it is not enough";
  };
  std::string text;
  for (std::size_t i = 0; i < e.bodies.size(); ++i) {
    const double mass = scene.structure->bodies[i].density * e.bodies[i].thickness;
    const std::string with_one = words(mass), with_both = words(0.5 * mass);
    text += fmt::format(
        "Behind a wet face of '{}' lie {:.3g} kg/m^2 ({:.3g} if the opposite one is wet as well), a layer of fluid particles has {:.3g}: "
        "{}.\n",
        e.bodies[i].name, mass, 0.5 * mass, layer, with_one == with_both ? with_one : with_one + "; if both are wet, " + with_both);
  }
  return text;
}

/// Whether a body would better be a shell, or a solid; nothing where it cannot be a shell.
template <int D>
std::string shell_text(const StructureBody& body) {
  StructureBody shell = body;
  ShellFit fit;
  try {
    shell.is_shell = true;
    fit = shell_fit<D>(shell);
    shell.spacing = body.is_shell ? body.spacing : std::max(fit.thickness, fit.length / fit.wanted_particles);
    fit = shell_fit<D>(shell);
  } catch (const BadInput&) {
    return "";
  }
  const bool is_thin = fit.without_shear <= most_without_shear;
  if (!is_thin && !body.is_shell) return "";
  const std::string numbers =
      fmt::format("{} thicknesses long, it bends {:.2g} % too little without transverse shear, and {:.2g} % too {} at {} particles {}",
                  ratio(fit.length / fit.thickness), 100 * fit.without_shear, 100 * std::abs(fit.by_spacing),
                  fit.by_spacing > 0 ? "much" : "little", fit.count, fit.held);
  if (body.is_shell) return fmt::format("  {}: {}{}.\n", body.name, numbers, is_thin ? "" : "; it would better be a solid");
  return fmt::format("  '{}' could be a shell (model = \"shell\", spacing = {:.2g}) of {} particles: {}.\n", body.name, shell.spacing,
                     fill_body<D>(shell).size(), numbers);
}

std::string shell_text(int dimension, const StructureBody& body) {
  if (!structure::Material(body).has_law_of_a_layer()) return "";
  return dimension == 2 ? shell_text<2>(body) : shell_text<3>(body);
}

std::string what_it_costs(const Case& scene, const Estimate& e, const Costs& costs) {
  const double total = e.fluid_cpu + e.structure_cpu + e.coupler_cpu;
  std::string text = fmt::format("\nWhat it costs: about {} steps{}, {} of CPU, {:.0f} MB ({})\n", count(e.steps), iterations_text(e),
                                 duration(total), e.memory / 1e6, origin(costs));
  const auto line = [&](const char* name, double seconds, const std::string& of_what) {
    if (seconds > 0) text += fmt::format("  {:<16} {:<10} {:>3.0f} %  {}\n", name, duration(seconds), 100 * seconds / total, of_what);
  };
  std::string parts;
  for (const auto& [part, share] : costs.fluid_parts) {
    std::string name = part;
    std::replace(name.begin(), name.end(), '_', ' ');
    parts += fmt::format("{}{} {:.0f} %", parts.empty() ? "" : ", ", name, 100 * share);
  }
  line("fluid", e.fluid_cpu, parts);
  line("structure", e.structure_cpu,
       scene.structure && scene.fluid ? fmt::format("a trial and the window itself in each of {} windows", count(e.steps)) : "");
  line("coupler", e.coupler_cpu, "with its side of the messages; less while the fluid cannot reach a body");
  return text;
}

}  // namespace

std::string explain_text(const Case& scene, const Costs& costs) {
  const Estimate e = estimate(scene, costs);
  const bool coupled = scene.fluid && scene.structure;
  std::string text = fmt::format("{}{}{}\n\n", scene.name, scene.title.empty() ? "" : ": ", scene.title);
  text += "Modelled\n";
  if (scene.fluid) {
    text += fmt::format(
        "* An incompressible, {} fluid of {} kg/m^3 in {} bod{} ({} particles); where it ends short of a wall it has a free "
        "surface at zero pressure.\n",
        scene.fluid->viscosity ? fmt::format("viscous ({} Pa s)", *scene.fluid->viscosity) : "inviscid", scene.fluid->density,
        scene.fluid->bodies.size(), scene.fluid->bodies.size() == 1 ? "y" : "ies", e.fluid_particles);
  }
  for (const WallCase& wall : scene.walls) {
    const bool sticks = scene.fluid && scene.fluid->viscosity && !wall.slip;
    text += fmt::format("* The rigid, {} {} '{}'{}{}.\n", sticks ? "no-slip" : "frictionless", wall.container ? "container" : "obstacle",
                        wall.name, wall.open.empty() ? "" : fmt::format(", open at {}", fmt::join(wall.open, ", ")),
                        wall.motion ? ", which moves" : "");
  }
  if (scene.structure) {
    for (std::size_t i = 0; i < e.bodies.size(); ++i) {
      const StructureBody& body = scene.structure->bodies[i];
      text +=
          fmt::format("* The elastic body '{}'{}: {}{}, {} kg/m^3, E = {} Pa, Poisson's ratio {}, {:.3g} mm thick; {}.\n", body.name,
                      body.is_shell ? ", a shell of one layer of particles" : "", structure::Material(body).name(),
                      scene.dimension == 3 ? ""
                      : body.plane_stress  ? " in plane stress"
                                           : " in plane strain",
                      body.density, body.young_modulus, body.poisson_ratio, 1e3 * e.bodies[i].thickness,
                      body.clamps.empty() ? "free" : fmt::format("{} of {} particles held", e.bodies[i].clamped, e.bodies[i].particles));
    }
    for (const StructureBody& body : scene.structure->bodies) text += shell_text(scene.dimension, body);
    for (const ClampCase& clamp : scene.structure->clamps)
      if (clamp.motion) text += fmt::format("* The clamp '{}' of '{}', which moves.\n", clamp.name, clamp.body);
    for (const LoadCase& load : scene.structure->loads) {
      const bool pressure = load.kind == LoadCase::Kind::pressure;
      std::string value = load.value[0].text();
      for (int d = 1; d < scene.dimension && !pressure; ++d) value += ", " + load.value[d].text();
      text += fmt::format("* The {} '{}' on '{}', ({}) {}.\n",
                          pressure                                ? "pressure"
                          : load.kind == LoadCase::Kind::traction ? "traction"
                                                                  : "body load",
                          load.name, load.body, value, load.kind == LoadCase::Kind::body_force ? "N/m^3" : "Pa");
    }
  }
  for (int d = 0; d < scene.dimension; ++d) {
    if (!scene.periodic[d]) continue;
    text += fmt::format("* Space that repeats itself in direction {} with a period of {:.6g} m.\n", "xyz"[d],
                        scene.domain_max[d] - scene.domain_min[d]);
  }
  text += fmt::format("* Gravity ({}) m/s^2.\n", [&] {
    std::string list;
    for (int d = 0; d < scene.dimension; ++d) list += (d ? ", " : "") + scene.gravity[d].text();
    return list;
  }());
  if (coupled) {
    text += fmt::format("* Their interaction through {}; loads {}; {}.\n", words_of(scene.coupling), name_of(scene.coupling.scheme).meaning,
                        scene.coupling.vem_coefficient ? fmt::format("with the VEM term, C = {}", *scene.coupling.vem_coefficient)
                                                       : "without the VEM term");
  }
  text += "\nNot modelled\n";
  if (scene.fluid)
    text += fmt::format(
        "* {}urbulence, surface tension, cavitation, and air: a closed air pocket is empty space, and so is what opens where water parts "
        "from a face. Inside of it the pressure may fall below that of the air by any amount.\n",
        scene.fluid->viscosity ? "T" : "Viscosity, t");
  if (scene.fluid) text += "* Inflow and outflow: what leaves the domain is removed and counted.\n";
  if (scene.structure && scene.fluid && scene.fluid->viscosity) text += "* Friction between the fluid and elastic bodies.\n";
  if (scene.structure) text += "* Plasticity, damage, material damping, contact: bodies that enter each other or a wall stop the run.\n";
  if (!scene.structure) text += "* Elastic bodies: no [structure] in the case, so no structure and no coupler process.\n";
  if (!scene.fluid) text += "* A fluid: no [fluid] in the case, so no fluid and no coupler process.\n";
  if (const std::string changes = preset_text(scene); !changes.empty()) text += "\nChanged by the " + changes;
  text += "\nWhat binds the step\n" + step_limits(scene, e);
  for (const BodyEstimate& body : e.bodies) {
    if (body.added_mass_ratio <= 0) continue;
    text += fmt::format(
        "\nThe fluid that '{}' has to move weighs about {} times the body with one wet face and {} times with "
        "two.\n"
        "The explicit coupling is {}.\n",
        body.name, ratio(body.added_mass_ratio), ratio(2 * body.added_mass_ratio),
        body.added_mass_ratio > 1 ? "predicted to be unstable, whatever the step; the default is predicted to be stable"
                                  : "possibly stable here; above 1 it is not");
  }
  if (coupled && scene.coupling.repeats_as_needed()) text += algorithm_choice(scene, e);
  text += what_it_costs(scene, e, costs);
  if (scene.fluid) text += "Halving the fluid's spacing multiplies the fluid's cost by about ";
  if (scene.fluid) text += scene.dimension == 2 ? "8.\n" : "16.\n";
  for (const std::string& warning : scene.warnings) text += "Warning: " + warning + "\n";
  return text;
}

}  // namespace tern
