#pragma once
// The wet-able surface of the bodies: points on the true faces, each carried by the nearest particle j of its body:
//   x_k = x_j + F_j (X_k - X_j),  n_k = F_j^-T N_k normalised,  a_k = A_k J |F_j^-T N_k|  (Nanson),  u_k = v_j.
// The force on k acts on j. Its work is then f_k . v_j, so u_k = v_j makes the work counted on both sides of the interface
// the same; the neglected rotation of X_k - X_j (half a spacing) is below the resolution of the particles. What lies in a clamp is rigid:
// its points move with the clamp, and the force on them is the clamp's to bear.

#include <vector>

#include "proto/interface.hpp"
#include "scene/case_file.hpp"
#include "structure/state.hpp"

namespace tern::structure {

template <int D>
struct SurfaceAttachment {
  SurfaceProperties properties;
  std::vector<std::int32_t> row;    ///< of the carrying particle
  std::vector<Vector<D>> offset;    ///< X_k - X_j [m]
  std::vector<Vector<D>> normal;    ///< N_k
  std::vector<double> area;         ///< A_k [m^(D-1)]
  std::vector<std::int32_t> clamp;  ///< that holds it: index of Reference::clamps, or their number for one without a name; free: -1
};

/// Samples every body at its own spacing, or that of the fluid where it is smaller. What lies inside its clamps is left out, but where
/// fluid can come: inside the container, and not on a wall or in one.
template <int D>
SurfaceAttachment<D> attach_surface(const Reference<D>& reference, const Case& scene);

/// The surface in the present state; `work` holds the deformation gradient of that state.
template <int D>
Surface<D> present_surface(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const State<D>& state,
                           const Workspace<D>& work);

/// Velocities of the surface points in a state [m/s].
template <int D>
std::vector<Vector<D>> surface_velocity(const SurfaceAttachment<D>& attachment, const State<D>& state);

}  // namespace tern::structure
