#pragma once
// What crosses the fluid-structure interface. Surface points belong to the structure, interface particles to the fluid;
// neither side learns anything else about the other. All arrays of one struct have the same length.

#include <cstdint>
#include <vector>

#include "base/vector.hpp"

namespace tern {

/// Section mass from which a point counts as held: no pressure moves it [kg/m^2].
inline constexpr double held_mass = 1e12;

/// Constant properties of the structure's surface points, sent once in the handshake.
struct SurfaceProperties {
  std::vector<std::uint32_t> body;   ///< index of the elastic body
  std::vector<double> section_mass;  ///< mass per area behind the point shared by its wet faces, rho T / N_wet; or held_mass [kg/m^2]
  std::vector<double> impedance;     ///< rho c_p of the material [kg/(m^2 s)]; times the window length it bounds the responding mass
  std::vector<double> least_mass;    ///< rho dx_s, mass per area of one particle layer [kg/m^2]
};

/// Structure surface under the old load (trial state): where it is at the middle of a window, and its velocity at the end.
/// Positions lie on the true face.
template <int D>
struct Surface {
  std::vector<Vector<D>> position;  ///< x [m]
  std::vector<Vector<D>> velocity;  ///< end-of-window velocity u [m/s]
  std::vector<Vector<D>> normal;    ///< unit, pointing out of the structure into the fluid
  std::vector<double> area;         ///< current area [m^(D-1)]

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("position", all.position...);
    visit("velocity", all.velocity...);
    visit("normal", all.normal...);
    visit("area", all.area...);
  }
};

/// Fluid particles within the kernel support of the interface, at their predicted positions.
template <int D>
struct InterfaceParticles {
  std::vector<std::uint32_t> id;    ///< particle label, stable over the run
  std::vector<Vector<D>> position;  ///< predicted position r* [m]
  std::vector<Vector<D>> velocity;  ///< predicted velocity u* [m/s]
  std::vector<double> mass;         ///< [kg/m^(3-D)]
  std::vector<double> volume;       ///< [m^D]
  std::vector<double> divergence;   ///< div u* over all phases [1/s], for the velocity-divergence-error-mitigating term; empty without it

  /// Mirror images of interface particles behind the walls they stand at, where a face of the structure sees them: the fluid
  /// beyond a wall that a face meets, which loads that face as well. Both of one length, which is not that of the others.
  std::vector<std::uint32_t> image_of;    ///< index of the interface particle
  std::vector<Vector<D>> image_position;  ///< [m]

  /// Surface points that look into a wall of the fluid instead of into room for it; ascending. Only those at walls need be named.
  std::vector<std::uint32_t> covered;

  /// Fluid beside bodies was enclosed in the last window: it asks for InterfaceCondition::answered_change.
  bool is_enclosed = false;
};

/// How the surface yields to a pressure (Robin condition). The bodies answer in lumps, parts that are pushed and move as a whole: under
/// forces f on its points, point k moves faster by sum_a share_ka (dt/m_a) sum_l share_la f_l at the end of the window.
struct SurfaceResponse {
  std::vector<std::uint32_t> lump;  ///< the same number of lumps for every point, point by point; empty: the surface does not yield
  std::vector<double> share;        ///< of the point in each of these lumps
  std::vector<double> mass;         ///< of every lump [kg/m^(3-D)]

  std::size_t lumps_per_point(std::size_t points) const { return points == 0 ? 0 : lump.size() / points; }
};

/// What the fluid is told before its pressure solve: the explicit forces on its interface particles and the Robin condition of the surface.
template <int D>
struct InterfaceCondition {
  std::vector<Vector<D>> force;            ///< on each interface particle [N/m^(3-D)]
  std::vector<double> reference_pressure;  ///< p-hat on each surface point [Pa], under which the trial state already moves
  SurfaceResponse response;                ///< to what a pressure exceeds that; the same in all coupling iterations of a window
  /// Velocity of each surface point under the load that is tried now [m/s]; empty: as in Surface.
  std::vector<Vector<D>> surface_velocity;
  bool repeats = false;  ///< the same window may be asked for once more
  /// By how much the velocity of each surface point at the end of the last window changed from that in Surface when the surface first moved
  /// under the answer of the fluid [m/s]; empty where nobody has asked for it or it is not known.
  std::vector<Vector<D>> answered_change;
  double answer_tolerance = 0;  ///< part of the change of the pressure since the last answer that this one may miss; 0: none of it
};

/// The interface particles after a pressure solve.
template <int D>
struct InterfacePressure {
  std::vector<double> pressure;     ///< p [Pa]
  std::vector<Vector<D>> velocity;  ///< velocity after all forces but the interface pressure [m/s]
};

/// Force of the whole interface on the interface particles, dissipative part excluded (it was applied before) [N/m^(3-D)].
template <int D>
struct InterfaceForce {
  std::vector<Vector<D>> force;
};

/// Where all fluid is at the end of a window. A surface that stays farther than `reach` from every particle is without any
/// influence on the fluid, and feels nothing of it.
template <int D>
struct FluidExtent {
  Vector<D> low, high;       ///< corners of a box around all particles [m]
  double largest_speed = 0;  ///< [m/s]
  double reach = 0;          ///< [m]
};

/// Force on each surface point, constant over the window [N/m^(3-D)].
template <int D>
struct SurfaceLoad {
  std::vector<Vector<D>> force;
};

}  // namespace tern
