#pragma once
// One window while it lasts. Nothing here outlives it (state.hpp).

#include <vector>

#include "coupler/audit.hpp"
#include "coupler/schemes/interface_pairs.hpp"
#include "coupler/setup.hpp"
#include "coupler/surface_lumps.hpp"
#include "proto/interface.hpp"

namespace tern::coupler {

/// The fluid between faces and particles (fluid_between.hpp).
template <int D>
struct FluidBetween {
  std::vector<double> filled;        ///< of each point, sum of B_ik [m^(D-1)]
  std::vector<double> mass;          ///< of each point, what is between it and the particles; 0: it does not count [kg/m^(3-D)]
  std::vector<double> acceleration;  ///< of each point along its normal, of which the fluid is told [m/s^2]
  std::vector<double> carried;       ///< by which the pressure of the trial is larger on each point than at the particles [Pa]
  std::vector<double> seen;          ///< of each particle, sum of B_ik [m^(D-1)]
  std::vector<double> distance;      ///< of each particle from the faces that it sees, h_i [m]
  std::vector<Vector<D>> lead;       ///< rho h_i a_i of each particle [Pa]
  std::vector<double> pressure;      ///< of the particles on each point, carried to it by its weight alone [Pa]
  SurfaceAnswer answer, told;        ///< of the surface with the fluid between, and of which the fluid is told
  std::vector<Vector<D>> beyond;     ///< by which the fluid takes each point for faster than by `answer` [m/s]; empty: by nothing
  std::vector<double> part, kept;    ///< of each lump and of each particle, scratch [-]
};

template <int D>
struct Workspace {
  explicit Workspace(const Setup<D>& setup) : pairs(setup.smoothing_length, setup.spacing) {}

  double begin = 0, duration = 0;          ///< [s]
  Surface<D> surface;                      ///< velocities: of the present iteration
  InterfaceParticles<D> particles;         ///< at their predicted positions
  InterfacePairs<D> pairs;                 ///< who sees whom
  std::vector<double> responding_mass;     ///< with which each point answers a pressure, as a formula guesses it [kg/m^2]
  SurfaceAnswer answer;                    ///< how the surface is taken to answer the fluid
  std::vector<double> share;               ///< load of each point under a uniform pressure p, over p A
  std::vector<double> seen_share;          ///< the same of the pressures on it in the equation of the fluid
  FluidBetween<D> between;                 ///< faces and particles
  SurfaceLoad<D> assumed_load;             ///< under which the structure has made the present iteration
  SurfaceLoad<D> assumed_contact;          ///< the contacts in it
  InterfaceCondition<D> condition;         ///< what the fluid is told before its pressure solve
  std::vector<double> carried;             ///< pressure of every pair; times b_ik its force [Pa]
  InterfaceForce<D> particle_force;        ///< of pressure and contacts on the interface particles
  SurfaceLoad<D> answered_load;            ///< what the fluid answers an assumed load with
  SurfaceLoad<D> load;                     ///< everything that the fluid answers the present iteration with
  SurfaceLoad<D> contact;                  ///< the contacts in it; only where windows are repeated
  std::vector<Vector<D>> velocity_at_end;  ///< of the surface, as the structure has answered last [m/s]
  int iterations = 0;                      ///< of this window: pressure solves
  bool agreed = true;                      ///< fluid and structure, at the end
  WindowAudit audit;
  WindowAudit answered_audit;  ///< with the answered load
};

/// Part of the half space before a point below which nothing is before it: at the end of the kernel, where w~ may be negative, particles
/// and point feel nothing of each other.
inline constexpr double least_share = 1e-3;

/// What of the assumed load on point k the pressure carries: all but what is known of the answer and the contacts.
template <int D>
Vector<D> carried_by_trial(const Workspace<D>& window, std::size_t k) {
  return window.assumed_load.force[k] - window.load.force[k] - window.assumed_contact.force[k];
}

/// Puts +f on a surface point and -f on an interface particle.
template <int D>
void add_pair_force(const InterfacePair<D>& pair, const Vector<D>& force, SurfaceLoad<D>& load, std::vector<Vector<D>>& on_particles) {
  load.force[pair.point] += force;
  on_particles[pair.particle] -= force;
}

}  // namespace tern::coupler
