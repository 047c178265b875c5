#pragma once
// The case file: one TOML file per scene, read by all three processes. Absent table = absent model.
// The keys, their defaults and the members they fill stand in scene/keys/, from which docs/PARAMETERS.md is generated as well.

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scene/expression.hpp"
#include "scene/geometry.hpp"
#include "scene/interface_schemes.hpp"
#include "scene/rigid_motion.hpp"
#include "structure/material/parameters.hpp"

namespace tern {

enum class GradientForm { sum, blend };  ///< pairwise sum form, or corrected interior blended with it
/// Staggered; or predict, project, correct, repeated until both sides agree.
enum class CouplingAlgorithm { explicit_staggering, automatic };
enum class Integrator { explicit_steps, implicit_steps, automatic };
enum class VemForm { seed, sum, pairmax };  ///< which of the two pressures of a pair pull

/// Rigid walls. A container holds the fluid inside its shape; an obstacle is solid itself.
struct WallCase {
  std::string name;
  bool container = false;
  Shape shape;
  bool slip = false;                  ///< frictionless although the fluid is viscous
  std::vector<std::string> open;      ///< box container only: faces left out, of "x_min" "x_max" "y_min" "y_max" "z_min" "z_max"
  std::optional<RigidMotion> motion;  ///< absent for a fixed wall
  /// Periodic directions from end to end of which it reaches, as a box that does not turn: shifted along them it is where it was.
  std::array<bool, 3> continues{};
};

/// Where a wall that has a motion is at time t [s].
template <int D>
Placement<D> placement(const WallCase& wall, double t) {
  Placement<D> place = placement<D>(*wall.motion, t);
  for (int d = 0; d < D; ++d)
    if (wall.continues[d]) place.shift[d] = 0;
  return place;
}

struct FluidBody {
  Shape shape;
  VectorExpression velocity;  ///< initial velocity [m/s] in x, y, z
};

/// Without a default of its own: default_fluid_numerics() has those of the rows in scene/keys/fluid.cpp.
struct FluidNumerics {
  double smoothing_length_ratio;  ///< h/dx
  GradientForm gradient;
  double blend_theta;         ///< weight of the self-regularising part of the blended gradient
  double density_relaxation;  ///< gamma of the density source
  double shifting;            ///< coefficient of the particle shifting; 0 = off
  double noise_damping;       ///< chi of the damping of particle-scale velocity noise; 0 = off
  double courant;             ///< dx/|u|max fraction
  double gravity_courant;     ///< sqrt(dx/|g|) fraction
  double viscous_courant;     ///< h^2/nu fraction
  double contact_distance;    ///< in dx; closer than this no particle approaches a face
  double pressure_tolerance;  ///< relative residual of the pressure solve
};
FluidNumerics default_fluid_numerics();

struct FluidCase {
  double density = 0;               ///< [kg/m^3]
  double spacing = 0;               ///< dx [m]
  std::optional<double> viscosity;  ///< dynamic [Pa s]; absent = inviscid, not evaluated
  std::vector<FluidBody> bodies;
  FluidNumerics numerics = default_fluid_numerics();
};

struct StructureBody : MaterialParameters {
  bool is_shell = false;  ///< one layer of particles on the mid-surface
  std::string name;
  Shape shape;
  double spacing = 0;         ///< dx_s [m]
  double mass_damping = 0;    ///< [1/s]; 0 = not evaluated
  std::vector<Shape> clamps;  ///< particles inside are held; regions of the named clamps included, and last the hinges
  std::vector<Shape> hinges;  ///< of a shell: they hold an edge in its place and let it turn
  VectorExpression velocity;  ///< initial velocity [m/s] in x, y, z

  /// Clamps that hold the slope as well.
  std::span<const Shape> rigid_clamps() const { return {clamps.data(), clamps.size() - hinges.size()}; }
};

/// Length of the patches of a body's surface: its spacing, or a whole part of it that is at most half of the fluid's [m]. To a fluid
/// particle longer patches are no even face: half a spacing before patches of a whole one its sums change by 1 % from the middle of a patch
/// to its edge (before those of half a spacing by 0.02 %), and twice the pressure times that would push it.
inline double patch_length(double spacing, const std::optional<FluidCase>& fluid) {
  if (!fluid) return spacing;
  const double longest = 0.5 * fluid->spacing;
  return spacing > longest ? spacing / std::ceil(spacing / longest * (1 - 1e-9)) : spacing;
}

/// A clamp with a name: it can move, and its reaction can be measured.
struct ClampCase {
  std::string name;
  std::string body;
  Shape region;
  std::optional<RigidMotion> motion;  ///< absent for a fixed clamp
  bool is_hinge = false;              ///< holds an edge of a shell in its place alone
};

/// What acts on a body from outside, by expressions in t and the place in the undeformed body.
struct LoadCase {
  enum class Kind {
    traction,   ///< force per undeformed area, of constant direction [Pa]
    pressure,   ///< against the normal of the present surface [Pa]
    body_force  ///< force per undeformed volume [N/m^3]
  };
  Kind kind = Kind::traction;
  std::string name;
  std::string body;
  std::optional<Shape> region;  ///< part of the undeformed body; absent = all of its surface (volume)
  VectorExpression value;       ///< of a pressure: the first entry
};

struct StructureNumerics {
  double smoothing_length_ratio;  ///< h0/dx_s
  double riemann_diffusion;       ///< chi of the complete-Riemann diffusion; 0 = off
  double courant;                 ///< dx_s/(c_p + |v|max) fraction
  Integrator integrator;          ///< explicit where a case built in code does not say another
};
StructureNumerics default_structure_numerics();

struct StructureCase {
  std::vector<StructureBody> bodies;
  std::vector<ClampCase> clamps;
  std::vector<LoadCase> loads;
  StructureNumerics numerics = default_structure_numerics();
};

struct CouplingCase {
  CouplingAlgorithm algorithm;
  InterfaceScheme scheme;
  double riemann_limiter;                 ///< eta in beta = min(eta max(du,0)/c0, 1)
  std::optional<double> vem_coefficient;  ///< C of the velocity-divergence-error-mitigating term; absent = not evaluated
  VemForm vem_form;
  double robin_mass_factor;         ///< m_p / m_s
  int max_iterations;               ///< passes of a window at most
  std::optional<double> tolerance;  ///< change of the load at which a window is done; absent = where the velocities agree

  /// Whether windows are repeated where they have to be, and nothing else is asked for.
  bool repeats_as_needed() const { return algorithm == CouplingAlgorithm::automatic && max_iterations > 1 && !tolerance; }
};
CouplingCase default_coupling();

/// A quantity written to gauges.csv. Which keys it has and what they mean is up to its kind (scene/gauges/).
struct GaugeCase {
  std::string kind, name;
  std::map<std::string, std::string> texts;  ///< by key, the same below
  std::map<std::string, double> numbers;
  std::map<std::string, std::array<double, 3>> points;

  // Empty, 0 or the origin where the case leaves the key out.
  std::string text(const std::string& key) const;
  double number(const std::string& key) const;
  std::array<double, 3> point(const std::string& key) const;
  template <int D>
  Vector<D> place(const std::string& key) const {
    return Eigen::Map<const Vector<D>>(point(key).data());
  }
};

struct OutputCase {
  double frame_interval;       ///< [s]; 0 = only the first and the last frame
  double gauge_interval;       ///< [s]; 0 = every step
  double checkpoint_interval;  ///< [wall s]; 0 = no checkpoints
};
OutputCase default_output();

struct Case {
  std::string path;  ///< of the file
  std::string name;  ///< folder name
  std::string title;
  std::string hash;          ///< hexadecimal; of the effective settings (preset and overrides included) and of the motion files
  std::string hash_of_rest;  ///< the same without what a run that goes on may change: end_time, the intervals of output, and gauges
  std::map<std::string, std::string> gauge_hashes;  ///< by name; a run that goes on may have more of them, not others
  std::string settings;                             ///< the effective settings as JSON text, for run.json
  std::string preset;                               ///< the group of numerical options
  std::vector<std::string> preset_changes;          ///< what it made of the case, "key = value" each; --set goes on top
  int dimension = 0;
  double end_time = 0;                               ///< [s]
  VectorExpression gravity;                          ///< [m/s^2] in t, x, y, z
  std::array<double, 3> domain_min{}, domain_max{};  ///< fluid particles that leave it are removed and counted
  std::array<bool, 3> periodic{};                    ///< directions in which the fluid repeats itself with the period of the domain
  std::vector<WallCase> walls;
  std::optional<FluidCase> fluid;
  std::optional<StructureCase> structure;
  CouplingCase coupling = default_coupling();
  std::vector<GaugeCase> gauges;
  OutputCase output = default_output();
  std::vector<std::string> warnings;  ///< sentences about what is allowed but doubtful; for the log
};

struct CaseOptions {
  std::vector<std::pair<std::string, std::string>> overrides;  ///< --set key=value, in order
  std::string preset;                                          ///< --preset; empty = as the case says
};

/// Reads, validates and checks the scene (bodies inside walls, no overlap, particles per thickness). `name_or_path`:
/// a case.toml, its folder, or a name under cases/. Throws BadInput with one sentence: file, line, key, value, limit, remedy.
Case read_case(const std::string& name_or_path, const CaseOptions& options = {});

}  // namespace tern
