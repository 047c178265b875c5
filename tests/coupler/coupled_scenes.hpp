#pragma once
// Small coupled scenes in one process, over the whole range of what a body can be: light and heavy, thin and thick, soft and
// stiff, wet on one face or on both. A few of the plates of ./tern extremes (launcher/extremes/scenes.py), without processes.

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "coupler/window.hpp"
#include "fluid/fluid.hpp"
#include "particles/error.hpp"
#include "particles/step_control.hpp"
#include "structure/coupled_structure.hpp"
#include "tests/coupler/scenes.hpp"

namespace tern::coupler::testing {

/// A plate in a tank of water that is tilted at t = 0, so that the water begins to slosh.
struct CoupledScene {
  double density_ratio = 1;    ///< of the plate over the water
  int layers = 4;              ///< of particles across the plate
  double young_modulus = 1e6;  ///< [Pa]
  int wet_faces = 1;           ///< 1: the plate is a part of the floor; 2: it stands under water
  CouplingAlgorithm algorithm = CouplingAlgorithm::automatic;
  double window = 1;           ///< length of the windows over what the fluid takes by default
  bool sealed = false;         ///< with a lid on the water
};

inline constexpr double plate_spacing = 0.005, water_spacing = 0.01, water_depth = 0.16, tank_width = 0.24;

inline std::string describe(const CoupledScene& s) {
  return fmt::format("density ratio {:g}, {} across, E {:g} Pa, {} wet", s.density_ratio, s.layers, s.young_modulus,
                     s.wet_faces == 1 ? "one face" : "both faces");
}

inline Case case_of(const CoupledScene& s) {
  Case c;
  c.dimension = 2;
  c.domain_min = {-1, -1, -1};
  c.domain_max = {1, 1, 1};
  c.end_time = 0.3;
  c.gravity = constant(0.98, -9.81);
  c.fluid.emplace();
  c.fluid->density = 1000;
  c.fluid->spacing = water_spacing;
  const double thickness = s.layers * plate_spacing;
  StructureBody plate;
  plate.name = "plate";
  plate.spacing = plate_spacing;
  plate.density = s.density_ratio * c.fluid->density;
  plate.young_modulus = s.young_modulus;
  plate.poisson_ratio = 0.3;
  plate.velocity = constant(0);
  WallCase tank;
  tank.name = "tank";
  tank.container = true;
  tank.open = {"y_max"};
  FluidBody water;
  water.velocity = constant(0);
  if (s.wet_faces == 1) {
    tank.shape = box({0, -0.1, 0}, {tank_width, 2 * water_depth, 0});
    tank.open.push_back("y_min");
    water.shape = box({0, 0, 0}, {tank_width, water_depth, 0});
    const double held = 4 * plate_spacing;
    plate.shape = box({-held, -thickness, 0}, {tank_width + held, 0, 0});
    plate.clamps = {box({-1, -1, -1}, {0, 1, 1}), box({tank_width, -1, -1}, {1, 1, 1})};
  } else {
    tank.shape = box({0, 0, 0}, {tank_width, 2 * water_depth, 0});
    water.shape = box({0, 0, 0}, {tank_width, water_depth, 0});
    plate.shape = box({0.5 * tank_width, -4 * plate_spacing, 0}, {0.5 * tank_width + thickness, 0.5 * water_depth, 0});
    plate.clamps = {box({-1, -1, -1}, {1, 0, 1})};
    // Water on both sides of the plate and above it.
    FluidBody right = water, above = water;
    water.shape.max[0] = 0.5 * tank_width;
    water.shape.max[1] = right.shape.max[1] = above.shape.min[1] = 0.5 * water_depth;
    right.shape.min[0] = 0.5 * tank_width + thickness;
    c.fluid->bodies = {right, above};
  }
  c.fluid->bodies.push_back(water);
  if (s.sealed) {
    tank.shape.max[1] = water_depth;
    std::erase(tank.open, "y_max");
  }
  c.walls.push_back(tank);
  c.structure.emplace();
  c.structure->bodies.push_back(plate);
  c.structure->numerics.integrator = Integrator::automatic;
  c.coupling.riemann_limiter = 3;
  c.coupling.algorithm = s.algorithm;
  c.fluid->numerics.courant *= s.window;
  c.fluid->numerics.gravity_courant *= s.window;
  return c;
}

struct CoupledOutcome {
  enum class Verdict { bounded, stopped, wrong } verdict = Verdict::wrong;
  CouplingAlgorithm algorithm{};  ///< that was taken
  double largest_speed = 0;       ///< of water and surface, over sqrt(g H)
  double unrest = 0;              ///< rms change of the change of the load per window, over rho g H times the plate's length
  double trials = 0;              ///< mean per window
  int windows = 0, open_windows = 0;
  std::string message;
};

/// `bounded`: water that falls from its surface to the floor has sqrt(2 g H), and nothing here may move faster than 2 sqrt(g H);
/// and the unrest of the load, which a stiff plate keeps for a while after the start, does not grow.
inline CoupledOutcome run(const CoupledScene& s, double until) {
  const Case c = case_of(s);
  CoupledOutcome outcome;
  const double length = s.wet_faces == 1 ? tank_width : water_depth, unit = 1000 * 9.81 * water_depth * length;
  std::vector<double> changes;
  Vector<2> last = Vector<2>::Zero(), before = last;
  try {
    fluid::Fluid<2> fluid(c);
    structure::Structure<2> structure(c);
    structure::CoupledStructure<2> coupled(structure, c.coupling.algorithm);
    CouplingStep<2> step(c, structure.surface_properties());
    outcome.algorithm = step.algorithm();
    StepControl control;
    for (Ticks now = 0, end = to_ticks(until); now < end;) {
      // No step is cut to meet the end: a change of the step shows vibrations that it strobes otherwise.
      const Ticks duration = control.next(fluid.propose_step().seconds, now, 10 * end);
      run_window<2>(fluid, coupled, step, now, duration);
      now += duration;
      ++outcome.windows;
      const auto of_fluid = fluid.energies();
      const auto of_structure = structure.energies();
      step.check_energy(seconds(now), of_fluid.kinetic + of_fluid.potential + of_structure.interface_work,
                        of_fluid.kinetic + of_structure.kinetic + of_structure.strain);
      outcome.trials += (step.trials().trials() - outcome.trials) / outcome.windows;
      outcome.open_windows += !step.trials().converged();
      double fastest = fluid.largest_speed();
      for (const auto& u : structure.surface_velocity()) fastest = std::max(fastest, u.norm());
      outcome.largest_speed = std::max(outcome.largest_speed, fastest / std::sqrt(9.81 * water_depth));
      const Vector<2> load = step.total_load(0);
      if (outcome.windows > 3) changes.push_back((load - 2 * last + before).norm() / unit);
      before = std::exchange(last, load);
    }
  } catch (const Error& error) {
    outcome.verdict = CoupledOutcome::Verdict::stopped;
    outcome.message = error.what();
    return outcome;
  }
  const auto rms = [&](std::size_t first, std::size_t end) {
    double sum = 0;
    for (std::size_t n = first; n < end; ++n) sum += changes[n] * changes[n];
    return std::sqrt(sum / static_cast<double>(end - first));
  };
  const std::size_t half = changes.size() / 2;
  outcome.unrest = rms(half, changes.size());
  const bool grows = outcome.unrest > 0.1 && outcome.unrest > 1.5 * rms(0, half);
  outcome.verdict = outcome.largest_speed < 2 && !grows ? CoupledOutcome::Verdict::bounded : CoupledOutcome::Verdict::wrong;
  return outcome;
}

/// Particles of water that stand a quarter of a fluid spacing or more within a stiff plate under water after `until`.
inline int inside_plate(const CoupledScene& s, double until) {
  const Case c = case_of(s);
  fluid::Fluid<2> fluid(c);
  structure::Structure<2> structure(c);
  structure::CoupledStructure<2> coupled(structure, c.coupling.algorithm);
  CouplingStep<2> step(c, structure.surface_properties());
  StepControl control;
  for (Ticks now = 0, end = to_ticks(until); now < end;) {
    const Ticks duration = control.next(fluid.propose_step().seconds, now, 10 * end);
    run_window<2>(fluid, coupled, step, now, duration);
    now += duration;
  }
  const double margin = 0.25 * water_spacing, left = 0.5 * tank_width + margin, right = 0.5 * tank_width + s.layers * plate_spacing - margin;
  int inside = 0;
  for (const auto& x : fluid.state().position) inside += x[0] > left && x[0] < right && x[1] < 0.5 * water_depth - margin;
  return inside;
}

}  // namespace tern::coupler::testing
