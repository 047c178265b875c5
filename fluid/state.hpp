#pragma once
// The state of the fluid: everything a later step needs. A fluid of the same scene that is given it at the end of a window goes
// on with the same bits. All else is rebuilt from it every step.

#include <cstdint>
#include <vector>

#include "base/time.hpp"
#include "base/vector.hpp"
#include "fluid/boundary/walls.hpp"
#include "fluid/particle_class.hpp"

namespace tern::fluid {

/// What enclosed regions were asked for and cannot do, over the run so far.
struct EnclosedAccount {
  bool any = false;         ///< there was an enclosed region
  double largest_flux = 0;  ///< net sum V (div u* - s) taken out of the source of a region, largest by size [m^D/s]
  double volume_error = 0;  ///< volume that faces have pushed into a region over its volume, largest by size [-]
  bool warned = false;
  double way = 0;  ///< volume that faces of bodies have swept in enclosed fluid, to and fro [m^D]
  bool warned_of_lag = false;
  std::vector<double> pushed;  ///< volume error by label of the particle, which keeps it while regions join and part; empty: none yet

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("any", all.any...);
    visit("largest_flux", all.largest_flux...);
    visit("volume_error", all.volume_error...);
    visit("warned", all.warned...);
    visit("way", all.way...);
    visit("warned_of_lag", all.warned_of_lag...);
    visit("pushed", all.pushed...);
  }
};

/// What is known of the enclosed regions beside bodies of the last window, by region.
struct EnclosedPast {
  static constexpr std::uint32_t none = ~std::uint32_t{0};  ///< number of no region

  std::vector<int> size;           ///< particles
  std::vector<double> pushed_in;   ///< volume that faces have pushed into it since it is enclosed [m^D]
  std::vector<double> lasting;     ///< what of that lasts: its mean over the last windows, of which late ones count more [m^D]
  std::vector<double> mean_size;   ///< mean of its absolute value over the same windows [m^D]
  std::vector<double> taken_away;  ///< of its rate: what the first pass of the window told the fluid to take away [m^D/s]
  /// What bodies have answered to that, times what they were told, and the square of this, four fifths of each kept per window [m^2D/s^2].
  std::vector<double> answered, square;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("size", all.size...);
    visit("pushed_in", all.pushed_in...);
    visit("lasting", all.lasting...);
    visit("mean_size", all.mean_size...);
    visit("taken_away", all.taken_away...);
    visit("answered", all.answered...);
    visit("square", all.square...);
  }
};

/// How often each term was evaluated, in particles (walls, faces of the structure), over the run so far. What a case leaves out
/// counts nothing.
struct Evaluations {
  long viscosity = 0, noise_damping = 0, density_source = 0, shifting = 0, moving_walls = 0, structure_surface = 0;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("viscosity", all.viscosity...);
    visit("noise_damping", all.noise_damping...);
    visit("density_source", all.density_source...);
    visit("shifting", all.shifting...);
    visit("moving_walls", all.moving_walls...);
    visit("structure_surface", all.structure_surface...);
  }
};

template <int D>
struct State {
  Ticks time = 0;

  // One value per particle: for_each_particle_field() lists them.
  std::vector<Vector<D>> position;            ///< [m]
  std::vector<Vector<D>> velocity;            ///< [m/s]
  std::vector<double> pressure;               ///< [Pa]
  std::vector<double> pressure_correction;    ///< the part of it that answers what the first solve has left behind [Pa]
  std::vector<Vector<D>> stopped;             ///< by contact with walls in the last window: the velocity taken away, over it [m/s^2]
  std::vector<std::uint32_t> region;          ///< of EnclosedPast, that it is in; EnclosedPast::none: in none
  std::vector<std::uint32_t> id;              ///< label, stable over the run
  std::vector<ParticleClass> particle_class;  ///< of the last step

  FollowedWalls<D> walls;                ///< of the last window, if any wall moves
  double wall_speed = 0;                 ///< largest of a patch of them [m/s]
  double wall_speed_in_frame = 0;        ///< the same to the observer who goes along (Fluid::frame_velocity) [m/s]
  double wall_acceleration = 0;          ///< largest of a patch, along its normal [m/s^2]
  double body_speed = 0;                 ///< largest of the structure's surface where it was wet in the last window [m/s]
  double body_speed_in_frame = 0;        ///< largest of all of it, to that observer [m/s]
  std::vector<Vector<D>> face;           ///< A n of the structure's surface in the last window [m^(D-1)]
  std::vector<Vector<D>> face_position;  ///< of its points then, on their way (FaceMotion::place) [m]
  double last_duration = 0;              ///< of the last window [s]; 0: there was none
  bool has_pressure = false;             ///< there was a pressure solve
  double left_share = 0;                 ///< what the first solve of the last window left behind, of its source; 0: not known
  bool fills_enclosure = false;          ///< all fluid is enclosed by fixed walls: it has no free surface and cannot get one
  EnclosedAccount enclosed;
  EnclosedPast enclosed_past;
  double reference_speed = 0;      ///< of the scene; 0: not known [m/s]
  int windows_of_collapse = 0;     ///< with a step far shorter than the reference speed asks for
  int windows_of_lost_volume = 0;  ///< beside bodies, with more or less of it than there can be
  int fallback_solves = 0;         ///< without the multigrid
  std::size_t removed = 0;         ///< particles that left the domain
  std::size_t leaked = 0;          ///< that went through a wall or the structure
  double potential = 0;            ///< minus the work of gravity since t = 0 [J/m^(3-D)]
  Evaluations evaluations;

  std::size_t size() const { return id.size(); }

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("time", all.time...);
    visit("position", all.position...);
    visit("velocity", all.velocity...);
    visit("pressure", all.pressure...);
    visit("pressure_correction", all.pressure_correction...);
    visit("stopped", all.stopped...);
    visit("region", all.region...);
    visit("id", all.id...);
    visit("particle_class", all.particle_class...);
    visit("walls", all.walls...);
    visit("wall_speed", all.wall_speed...);
    visit("wall_speed_in_frame", all.wall_speed_in_frame...);
    visit("wall_acceleration", all.wall_acceleration...);
    visit("body_speed", all.body_speed...);
    visit("body_speed_in_frame", all.body_speed_in_frame...);
    visit("face", all.face...);
    visit("face_position", all.face_position...);
    visit("last_duration", all.last_duration...);
    visit("has_pressure", all.has_pressure...);
    visit("left_share", all.left_share...);
    visit("fills_enclosure", all.fills_enclosure...);
    visit("enclosed", all.enclosed...);
    visit("enclosed_past", all.enclosed_past...);
    visit("reference_speed", all.reference_speed...);
    visit("windows_of_collapse", all.windows_of_collapse...);
    visit("windows_of_lost_volume", all.windows_of_lost_volume...);
    visit("fallback_solves", all.fallback_solves...);
    visit("removed", all.removed...);
    visit("leaked", all.leaked...);
    visit("potential", all.potential...);
    visit("evaluations", all.evaluations...);
  }
};

/// Calls visit(name, unit, values) for each array with one value per particle: what sorting by cell, the removal of escaped
/// particles, frames and comparisons go through. Unit null: no field to look at, not in frames.
template <class AnyState, class Visit>
void for_each_particle_field(AnyState& state, Visit&& visit) {
  visit("position", "m", state.position);
  visit("velocity", "m/s", state.velocity);
  visit("pressure", "Pa", state.pressure);
  visit("pressure_correction", nullptr, state.pressure_correction);
  visit("stopped", nullptr, state.stopped);
  visit("region", nullptr, state.region);
  visit("id", "", state.id);
  visit("flag", "", state.particle_class);
}

}  // namespace tern::fluid
