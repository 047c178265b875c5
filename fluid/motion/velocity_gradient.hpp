#pragma once
// S_i = sum_F V_j (u_j - u_i) grad w_ij^T, from which velocity gradient and divergence are made.

#include "fluid/correction_matrix.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

template <bool periodic, int D>
Matrix<D> velocity_gradient_sum(const Neighbours<D>& neighbours, const LanePeriod<periodic, D>& period, const ByAxis<D>& velocity,
                                std::ptrdiff_t i) {
  std::array<double, D> x, u;
  for (int c = 0; c < D; ++c) x[c] = neighbours.position[c][i], u[c] = velocity[c][i];
  std::array<std::array<Four, D>, D> sums{};
  for_groups(
      neighbours, i, [&](int j, Four weight) __attribute__((always_inline)) {
        std::array<Four, D> jump;
        for (int a = 0; a < D; ++a) jump[a] = load(velocity[a].data() + j) - u[a];
        for (int b = 0; b < D; ++b) {
          const Four r = weight * period.between(x[b], neighbours.position[b].data() + j, b);
          for (int a = 0; a < D; ++a) sums[a][b] += jump[a] * r;
        }
      });
  Matrix<D> result;
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) result(a, b) = sum(sums[a][b]);
  return result;
}

/// Half of L_i = S_i C^F_i of every particle, exact for linear fields; 0 where the support is too poor for that; the rate of strain in it
/// and its size, of the packed velocity.
template <int D>
void compute_velocity_gradient(const Period<D>& space, const Neighbours<D>& neighbours, const Corrections<D>& correction,
                               const std::vector<ParticleClass>& particle_class, PackedVelocities<D>& packed);

}  // namespace tern::fluid
