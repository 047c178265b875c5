#pragma once
// What a case will take: particles, steps, memory, time; for `tern-case check` and `explain`.

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/case_file.hpp"

namespace tern {

/// Cost of one particle in one step in 2D [CPU s], h/dx 1.5 (fluid) and 1.1 (structure). The defaults were measured on one core
/// of a 2-core x86-64 server: 1.9 and 2.0 us for the fluid of the dam break (to 0.35 s) and of the tank at rest (6.4 s), 70
/// (quiet) to 100 ns (busy) for the plate of bench-structure_substep. 3D: three times that for the fluid, estimated; 3 to 12
/// times for the structure (solid_work).
struct Costs {
  double fluid = 2.0e-6;
  double structure = 8.0e-8;                                ///< per sub-step
  double window = 3.5e-4;                                   ///< of the coupler for one window [CPU s]
  std::vector<std::pair<std::string, double>> fluid_parts;  ///< name and share; empty if not measured
  std::string measured;                                     ///< date, empty for the defaults
};
inline constexpr double implicit_window = 19;         ///< cost of a window in implicit steps, in sub-steps, of at most a thousand particles
inline constexpr double implicit_window_in_3d = 120;  ///< the same in 3D, of some thousand particles; of some hundred it is 40
inline constexpr double implicit_window_of_shell_in_3d = 8;  ///< the same of a shell: `dam_break_plate_3d` to 0.3 s in implicit steps

/// Mass behind the faces of a body, in layers of fluid particles: at most so many, and windows are half as long; or, how it answers is not
/// learnt, and every window is repeated. A plate of just this mass is one of them, whatever its rounding.
inline constexpr double layers_of_light = 0.5 * (1 + 1e-9), layers_of_lightest = 0.05 * (1 + 1e-9);

/// Throws InputOutputError, BadInput.
Costs read_costs(const std::string& path);

struct BodyEstimate {
  std::string name;
  long particles = 0;
  long clamped = 0;
  long surface_points = 0;      ///< outside the clamps
  double thickness = 0;         ///< thin section [m]
  double wave_speed = 0;        ///< c_p [m/s]
  double sub_step = 0;          ///< [s]
  double added_mass_ratio = 0;  ///< of one wet face, first cantilever mode; 0 = not thin or no fluid
  double bending_period = 0;    ///< of the first bending with one wet face [s]; 0 = not thin or no fluid
  double displaced_mass = 0;    ///< of a loose body: of the fluid that it displaces when it dives, over its own; 0 = held or no fluid
};

struct Estimate {
  long fluid_particles = 0;
  double gravity = 0;       ///< largest |g| at t = 0 in the fluid [m/s^2]
  bool settled = false;     ///< the fluid starts at rest, and nowhere has room to fall
  double speed = 0;         ///< of free fall to the lowest wall, of the start, of walls and clamps: mean of the largest [m/s]
  double gravity_step = 0;  ///< limit gravity_courant sqrt(dx/|g|) [s]; infinite without gravity
  double flow_step = 0;     ///< limit courant dx/speed [s]; infinite at rest
  double viscous_step = 0;  ///< limit viscous_courant h^2/nu [s]; infinite without viscosity
  /// Limit of the error of the motion of bodies that vibrate from the start on, or that loads move [s]; infinite without such.
  double motion_step = std::numeric_limits<double>::infinity();
  double step = 0;   ///< the smallest of those that apply; of a structure alone, its window [s]
  double steps = 0;  ///< in the whole run
  std::vector<BodyEstimate> bodies;
  double sub_steps = 0;                                      ///< of the structure in one step
  bool light = false, lightest = false;                      ///< the layers that a body has behind its faces are as few as that
  double iterations = 1;                                     ///< of the coupling in one step
  double memory = 0;                                         ///< all processes [bytes]
  double fluid_cpu = 0, structure_cpu = 0, coupler_cpu = 0;  ///< [s]
  double factor_of_walls = 1;                                ///< of the cost of a step of the fluid in 3D
  double gauge_row = 0;                                      ///< what gauges of forces on walls take in 3D, each time [s]
};

Estimate estimate(const Case& scene, const Costs& costs = {});

/// Length of the first window of fluid and structure at most [s]; infinite where no body moves at the start and none is loaded. A body
/// that does may vibrate, and nothing has yet been seen of that: ten times as long as sound takes from particle to particle.
double first_window(const Case& scene);

/// Window that resolves how the loads on the bodies change in time [s]; infinite where they do not. An eighth of the ratio of their size
/// to their rate, root mean squares over the run: a load that swings has 50 windows a period.
double window_of_loads(const Case& scene);

/// Of an observer who goes along with the scene, by its number: where all walls move, the one that he stands on, the first container or
/// else the first of them. Nothing where a wall is at rest, or there is none.
std::optional<std::size_t> wall_of_frame(const Case& scene);

/// Window of a fluid in which nothing moves, and on which nothing acts, yet [s]: what the largest speed and acceleration of walls and
/// clamps in the run ask for; without such the whole run. `goes_along`: to that observer.
double window_at_rest(const Case& scene, bool goes_along = false);

/// Of a point of a clamp, in the whole run [m/s].
double largest_clamp_speed(const Case& scene);

/// Sub-steps of a structure alone between two looks at interruption, progress and the stable sub-step: a step of its run, unless
/// an output comes before. Forces and motions that change in time are constant over them, so there are fewer where there are such.
double sub_steps_per_window(const Case& scene);

/// Numbers of the estimate as lines of text; the wall time is that of a machine of as many cores.
std::string check_text(const Case& scene, const Costs& costs = {}, int cores = 1);
/// The scene in plain words: what is modelled, what is not, what binds the step, what it costs.
std::string explain_text(const Case& scene, const Costs& costs = {});

}  // namespace tern
