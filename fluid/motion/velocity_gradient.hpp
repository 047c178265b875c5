#pragma once
// S_i = sum_F V_j (u_j - u_i) grad w_ij^T, from which velocity gradient and divergence are made.

#include "fluid/correction_matrix.hpp"
#include "fluid/motion/motion.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

template <bool periodic, int D>
Matrix<D> velocity_gradient_sum(const Neighbours<D>& neighbours, const PackedPeriod<periodic, D>& period,
                                const std::vector<Motion<D>>& motion, std::ptrdiff_t i) {
  const Packed<D> x = motion[i].position, u = motion[i].velocity;
  std::array<Packed<D>, D> even, odd;
  even.fill(Packed<D>::Zero());
  odd.fill(Packed<D>::Zero());
  for_row_in_turns(neighbours, i, even, odd, [&](std::array<Packed<D>, D>& column, int k) {
    const Motion<D>& other = motion[neighbours.column[k]];
    const Packed<D> r = double(neighbours.weight[k]) * period.between(x, other.position), jump = other.velocity - u;
    for (int b = 0; b < D; ++b) column[b] += jump * r[b];
  });
  Matrix<D> sum;
  for (int b = 0; b < D; ++b)
    for (int a = 0; a < D; ++a) sum(a, b) = even[b][a] + odd[b][a];
  return sum;
}

/// Half of L_i = S_i C^F_i of every particle, exact for linear fields; 0 where the support is too poor for that; and the rate of
/// strain in it. Packs position and velocity.
template <int D>
void compute_velocity_gradient(const Period<D>& space, const Neighbours<D>& neighbours, const Corrections<D>& correction,
                               const std::vector<ParticleClass>& particle_class, const std::vector<Vector<D>>& position,
                               const std::vector<Vector<D>>& velocity, PackedVelocities<D>& packed);

}  // namespace tern::fluid
