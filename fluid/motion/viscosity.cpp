// Viscous acceleration (Morris et al. 1997), explicit, of the velocity u^n at the begin of the step:
//   a_i = nu sum_F V_j K_ij (u_j - u_i) + nu sum_k 2 A_k w~_ik (u_k - u_i) / y_ik,   K = 2 |w'|/r
// K is that of the pressure equation. Behind a no-slip wall the velocity continues linearly through that of the wall, as if
// u - u_i = (u_k - u_i) y/y_ik at a distance y along the normal, y_ik being that of particle i from the plane of patch k;
// since K y summed over the hidden side is 2 A_k w~ (Gauss), no further table is needed, and a linear profile at a plane
// wall has no acceleration. Every term pulls velocities together: sum m a . u <= 0 between walls at rest.

#include "fluid/motion/viscosity.hpp"

#include "base/parallel.hpp"

namespace tern::fluid {
template <int D>
void add_viscosity(const Constants<D>& constants, double duration, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                   const std::vector<Vector<D>>& position, const ByAxis<D>& velocity, std::vector<Vector<D>>& predicted_velocity) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(neighbours.rows());
  const double scale = 2 * duration * constants.viscosity;
  const Faces<D>& faces = boundary.seen_walls();
  parallel_for(n, [&](std::ptrdiff_t i) {
    std::array<Four, D> sums{};
    for_groups(
        neighbours, i, [&](int j, Four weight) __attribute__((always_inline)) {
          for (int c = 0; c < D; ++c) sums[c] += weight * (load(velocity[c].data() + j) - velocity[c][i]);
        });
    Vector<D> total, u;
    for (int c = 0; c < D; ++c) total[c] = sum(sums[c]), u[c] = velocity[c][i];
    for (int entry = boundary.wall_rows.begin[i]; entry < boundary.wall_rows.begin[i] + boundary.wall_rows.count[i]; ++entry) {
      const int k = boundary.wall_rows.face[entry];
      if (boundary.walls.slips(k)) continue;
      const double height = seen_height(constants, (position[i] - faces.position[k]).dot(faces.normal[k]));
      total += std::max(boundary.wall_rows.weight[entry], 0.0) / height * (faces.velocity_of(k) - u);
    }
    predicted_velocity[i] += scale * total;
  });
}

template void add_viscosity<2>(const Constants<2>&, double, const Neighbours<2>&, const Boundary<2>&, const std::vector<Vector<2>>&,
                               const ByAxis<2>&, std::vector<Vector<2>>&);
template void add_viscosity<3>(const Constants<3>&, double, const Neighbours<3>&, const Boundary<3>&, const std::vector<Vector<3>>&,
                               const ByAxis<3>&, std::vector<Vector<3>>&);

}  // namespace tern::fluid
