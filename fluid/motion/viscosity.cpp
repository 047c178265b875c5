// Viscous acceleration (Morris et al. 1997), explicit, of the velocity u^n at the begin of the step:
//   a_i = nu sum_F V_j K_ij (u_j - u_i) + nu sum_k 2 A_k w~_ik (u_k - u_i) / y_ik,   K = 2 |w'|/r
// K is that of the pressure equation. Behind a no-slip wall the velocity continues linearly through that of the wall, as if
// u - u_i = (u_k - u_i) y/y_ik at a distance y along the normal, y_ik being that of particle i from the plane of patch k;
// since K y summed over the hidden side is 2 A_k w~ (Gauss), no further table is needed, and a linear profile at a plane
// wall has no acceleration. Every term pulls velocities together: sum m a . u <= 0 between walls at rest.

#include "base/parallel.hpp"
#include "fluid/fluid.hpp"

namespace tern::fluid {
namespace {

constexpr double least_height = 1.0 / 6;  ///< of h, for y_ik: keeps the limit of the step independent of the disorder

}  // namespace

template <int D>
void Fluid<D>::apply_viscosity() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  evaluations_.viscosity += n;
  const double scale = 2 * duration_s_ * constants_.viscosity;
  const double least = least_height * constants_.kernel.smoothing_length();
  const Faces<D>& faces = seen_walls_.faces();
  const Vector<D>* velocity = state_.velocity.data();
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const Vector<D> u = velocity[i];
    Vector<D> sum = Vector<D>::Zero();
    const int last = neighbours_.begin[i] + neighbours_.count[i];
    for (int k = neighbours_.begin[i]; k < last; ++k) {
      const Vector<D>& other = velocity[neighbours_.column[k]];
      for (int c = 0; c < D; ++c) sum[c] += neighbours_.weight[k] * (other[c] - u[c]);
    }
    for (int entry = wall_rows_.begin[i]; entry < wall_rows_.begin[i] + wall_rows_.count[i]; ++entry) {
      const int k = wall_rows_.face[entry];
      if (walls_.slips(k)) continue;
      const double height = std::max((predicted_position_[i] - faces.position[k]).dot(faces.normal[k]), least);
      sum += std::max(wall_rows_.weight[entry], 0.0) / height * (faces.velocity[k] - u);
    }
    predicted_velocity_[i] += scale * sum;
  }
}

template void Fluid<2>::apply_viscosity();
template void Fluid<3>::apply_viscosity();

}  // namespace tern::fluid
