#pragma once
// The wet-able surface of the bodies: points on the true faces, each carried by the nearest particle i of its body:
//   x_k ~ x_i + F_i (X_k - X_i),  n_k = F_i^-T N_k normalised,  a_k = A_k J |F_i^-T N_k|  (Nanson).
// Place and velocity are sums over particles with constant weights, x_k = X_k + sum_j w_kj d_j, u_k = sum_j w_kj v_j, by which the load
// on k is borne, too (surface_weights.hpp): its power is f_k.u_k on both sides of the interface.
// What lies in a clamp is rigid: its points move with the clamp, and the force on them is the clamp's to bear. On shells:
// shell/shell_surface.hpp.
//
// These points are the feet of the patches that the other side sees. A patch has one foot, but in 3D on a solid that is finer than half
// the spacing of the fluid: there it has those in a cube of about that length. What a fluid particle asks of each patch grows with the
// square of their number, and what patches ask of each other with the fourth power. With the shares s_k = A_k / sum A of its feet
//   x = sum s_k x_k,  u = sum s_k u_k,  a n = sum a_k n_k,  and of its force f each foot bears s_k f,
// so that the work is the same on both sides here, too.

#include <vector>

#include "proto/interface.hpp"
#include "scene/case_file.hpp"
#include "structure/shell/shell_surface.hpp"
#include "structure/state.hpp"
#include "structure/surface_weights.hpp"

namespace tern::structure {

template <int D>
struct SurfaceAttachment {
  SurfaceProperties properties;  ///< of the patches

  // Of the feet.
  std::vector<std::uint32_t> patch;  ///< to which it belongs
  std::vector<double> share;         ///< of its area in that of the patch
  std::vector<std::uint32_t> body;
  std::vector<std::int32_t> row;       ///< of the carrying particle
  std::vector<Vector<D>> offset;       ///< X_k - X_i [m]
  SurfaceWeights weights;              ///< of those on free faces of solids
  std::vector<Vector<D>> normal;       ///< N_k
  std::vector<double> area;            ///< A_k [m^(D-1)]
  std::vector<ShellPoint<D>> shell;    ///< on a shell that is not clamped there: where
  std::vector<std::int32_t> on_shell;  ///< index of Reference::shells, or -1
  std::vector<std::int32_t> clamp;     ///< that holds it: index of Reference::clamps, or their number for one without a name; free: -1
  std::vector<std::size_t> held;       ///< the feet that a clamp holds
};

/// Feet are as far apart as the particles of the body, or, where that is less, half of those of the fluid (point_distance()). What
/// lies inside its clamps is left out, but where fluid can come: inside the container, and not on a wall or in one.
template <int D>
SurfaceAttachment<D> attach_surface(const Reference<D>& reference, const Case& scene);

/// The feet in the present state; `work` holds the deformation gradient of that state.
template <int D>
Surface<D> present_feet(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const State<D>& state,
                        const Workspace<D>& work);

/// The patches in the present state; `work` as above.
template <int D>
Surface<D> present_surface(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const State<D>& state,
                           const Workspace<D>& work);

/// By how much each of the feet that clamps hold moves from t = `begin` to `end` [s], in the order of `held` [m].
template <int D>
std::vector<Vector<D>> held_feet_moved(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, double begin, double end);

/// Adds the force f on foot k to the rows that bear it; none when a clamp holds it.
template <int D>
void add_point_force(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const Workspace<D>& work, std::size_t k,
                     const Vector<D>& f, RowVectors<D>& force) {
  for (auto n = attachment.weights.first[k]; n < attachment.weights.first[k + 1]; ++n)
    for (int a = 0; a < D; ++a) force[a][attachment.weights.bearer[n]] += attachment.weights.weight[n] * f[a];
  if (attachment.on_shell[k] < 0) return;
  const ShellBody<D>& shell = reference.shells[attachment.on_shell[k]];
  spread_force<D>(shell.layer, work.shells[shell.index], attachment.shell[k], f, [&](std::size_t j, const Vector<D>& share) {
    for (int a = 0; a < D; ++a) force[a][shell.first_row + static_cast<std::int32_t>(j)] += share[a];
  });
}

/// Velocities of the patches in a state [m/s]; `work` as above.
template <int D>
std::vector<Vector<D>> surface_velocity(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const State<D>& state,
                                        const Workspace<D>& work);

}  // namespace tern::structure
