// Elastic force, the exact negative gradient of sum_i V_i W(F_i, K_i) for any derivative vectors g_ij and k_ij:
//   f_i = sum_j V_i V_j (P_i g_ij - P_j g_ji + Q_i:k_ij - Q_j:k_ji),
// antisymmetric in the pair, so that momentum is conserved.

#include <algorithm>

#include "structure/shell/shell_body.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// Sums of each component of the force. A single one would wait for each of its own additions, and in 2D every row of P and Q has its own;
/// in 3D more than two for each of the three components do not stay in registers.
template <int D>
constexpr int sums = D == 2 ? D + curvature_components<D> : 2;

/// The elastic force on a block. Each derivative vector is loaded once for all components.
template <int D>
inline void force_of_block(const Workspace<D>& work, std::int32_t row, const Stencil<D>& stencil, const Neighbour<D>* neighbour,
                           const std::int32_t* offset, Lanes (&force)[D]) {
  constexpr int terms = D + curvature_components<D>;
  const double* stress[D][terms];  // P, then Q
  Lanes sum[D][sums<D>] = {};
  for (int a = 0; a < D; ++a)
    for (int n = 0; n < terms; ++n) {
      stress[a][n] = (n < D ? work.stress[a][n].data() : work.double_stress[a][n - D].data()) + row;
      const Lanes own = load(stress[a][n]) * (n < D ? stencil.gradient_sum[n] : stencil.curvature_sum[n - D]);
      sum[a][n % sums<D>] = n < sums<D> ? own : sum[a][n % sums<D>] + own;
    }
  for (std::uint32_t k = 0; k < stencil.count; ++k)
    for (int n = 0; n < terms; ++n) {
      const Lanes weight = n < D ? neighbour[k].mirror_gradient[n] : neighbour[k].mirror_curvature[n - D];
      for (int a = 0; a < D; ++a) sum[a][n % sums<D>] -= load(stress[a][n] + offset[k]) * weight;
    }
  for (int a = 0; a < D; ++a) {
    force[a] = sum[a][0];
    for (int n = 1; n < sums<D>; ++n) force[a] += sum[a][n];
  }
}

}  // namespace

template <int D>
void elastic_force(const Reference<D>& reference, const Workspace<D>& work, State<D>& state) {
  for_each_deforming_block(reference, [&](std::ptrdiff_t n, const Block& block, const Stencil<D>& stencil) {
    Lanes elastic[D], product = {};
    const Neighbour<D>* neighbour = reference.neighbours.data() + stencil.first;
    const std::int32_t* offset = reference.row_offset.data() + stencil.first;
    force_of_block<D>(work, block.row, stencil, neighbour, offset, elastic);
    for (int a = 0; a < D; ++a) {
      double* force = state.internal_force[a].data() + block.row;
      const Lanes stabilising = load(force), total = stabilising + elastic[a];
      product += stabilising * total;
      store(force, total);
    }
    // The power of the diffusion, -f . v, falls by f . (total force)/m in a second.
    if (reference.has_diffusion) state.diffusion_brake[n] = load(reference.inverse_mass.data() + block.row) * product;
  });
}

template <int D>
bool evaluate_elastic_force(const Reference<D>& reference, State<D>& state, Workspace<D>& work) {
  state.force_is_elastic = false;
  displacement_gradients(reference, state, work);
  if (!stresses(reference, work)) return false;
  for (auto& axis : state.internal_force) std::fill(axis.begin(), axis.end(), 0);
  elastic_force(reference, work, state);
  if (!shell_elastic_forces(reference, state, work)) return false;
  work.evaluations.elastic_force += reference.rows;
  state.force_is_elastic = true;
  return true;
}

template bool evaluate_elastic_force<2>(const Reference<2>&, State<2>&, Workspace<2>&);
template bool evaluate_elastic_force<3>(const Reference<3>&, State<3>&, Workspace<3>&);
template void elastic_force<2>(const Reference<2>&, const Workspace<2>&, State<2>&);
template void elastic_force<3>(const Reference<3>&, const Workspace<3>&, State<3>&);

}  // namespace tern::structure
