#pragma once
// One window while it lasts. Nothing here outlives it (state.hpp).

#include <vector>

#include "coupler/audit.hpp"
#include "coupler/schemes/interface_pairs.hpp"
#include "coupler/schemes/scheme.hpp"
#include "coupler/setup.hpp"
#include "coupler/surface_lumps.hpp"
#include "proto/interface.hpp"

namespace tern::coupler {

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
  SurfaceLoad<D> assumed_load;             ///< under which the structure has made the present iteration
  SurfaceLoad<D> assumed_contact;          ///< the contacts in it
  bool contacts_are_given = false;         ///< by it, for they come to no agreement
  InterfaceCondition<D> condition;         ///< what the fluid is told before its pressure solve
  PointPressures<D> point_pressures;       ///< what the scheme makes of the pressures of the particles
  PointSums point_sums;                    ///< kept, so that a window allocates nothing
  std::vector<Vector<D>> image_force;      ///< of the pressure of every pair of an image
  InterfaceForce<D> particle_force;        ///< of pressure and contacts on the interface particles
  std::vector<double> answered_speed;      ///< of every point along its normal, by the answer to what exceeds the assumed load [m/s]
  SurfaceLoad<D> answered_load;            ///< what the fluid answers an assumed load with
  SurfaceLoad<D> load;                     ///< everything that the fluid answers the present iteration with
  SurfaceLoad<D> contact;                  ///< the contacts in it; only where windows are repeated
  std::vector<Vector<D>> velocity_at_end;  ///< of the surface, as the structure has answered last [m/s]
  int iterations = 0;                      ///< of this window: pressure solves
  bool agreed = true;                      ///< fluid and structure, at the end
  WindowAudit audit;
  WindowAudit answered_audit;  ///< with the answered load
};

/// Puts +f on a surface point and -f on an interface particle.
template <int D>
void add_pair_force(const InterfacePair<D>& pair, const Vector<D>& force, SurfaceLoad<D>& load, std::vector<Vector<D>>& on_particles) {
  load.force[pair.point] += force;
  on_particles[pair.particle] -= force;
}

}  // namespace tern::coupler
