// Elastic force, the exact negative gradient of sum_i V_i W(F_i, K_i) for any derivative vectors g_ij and k_ij:
//   f_i = sum_j V_i V_j (P_i g_ij - P_j g_ji + Q_i:k_ij - Q_j:k_ji),
// antisymmetric in the pair, so that momentum is conserved.

#include <algorithm>

#include "structure/shell/shell_body.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// One component of the elastic force on a block, from the rows of P and Q of that component. One sum per row of P and Q: a
/// single one would wait for each of its own additions.
template <int D>
inline Lanes component_of_force(const Stencil<D>& stencil, const Neighbour<D>* neighbour, const std::int32_t* offset,
                                const double* const (&p)[D], const double* const (&q)[curvature_components<D>]) {
  Lanes by_p[D], by_q[curvature_components<D>];
  for (int b = 0; b < D; ++b) by_p[b] = load(p[b]) * stencil.gradient_sum[b];
  for (int c = 0; c < curvature_components<D>; ++c) by_q[c] = load(q[c]) * stencil.curvature_sum[c];
  for (std::uint32_t k = 0; k < stencil.count; ++k) {
    const Neighbour<D>& n = neighbour[k];
    for (int b = 0; b < D; ++b) by_p[b] -= load(p[b] + offset[k]) * n.mirror_gradient[b];
    for (int c = 0; c < curvature_components<D>; ++c) by_q[c] -= load(q[c] + offset[k]) * n.mirror_curvature[c];
  }
  Lanes force = by_p[0];
  for (int b = 1; b < D; ++b) force += by_p[b];
  for (int c = 0; c < curvature_components<D>; ++c) force += by_q[c];
  return force;
}

}  // namespace

template <int D>
void elastic_force(const Reference<D>& reference, const Workspace<D>& work, State<D>& state) {
  constexpr int pairs = curvature_components<D>;
  for_each_deforming_block(reference, [&](std::ptrdiff_t n, const Block& block, const Stencil<D>& stencil) {
    const Neighbour<D>* neighbour = reference.neighbours.data() + stencil.first;
    const std::int32_t* offset = reference.row_offset.data() + stencil.first;
    Lanes product = {};
    for (int a = 0; a < D; ++a) {
      const double *p[D], *q[pairs];
      for (int b = 0; b < D; ++b) p[b] = work.stress[a][b].data() + block.row;
      for (int c = 0; c < pairs; ++c) q[c] = work.double_stress[a][c].data() + block.row;
      double* force = state.internal_force[a].data() + block.row;
      const Lanes stabilising = load(force), total = stabilising + component_of_force<D>(stencil, neighbour, offset, p, q);
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
