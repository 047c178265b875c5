// Internal force, the exact negative gradient of sum_i V_i W(F_i, K_i) for any derivative vectors g_ij and k_ij:
//   f_i = sum_j V_i V_j (P_i g_ij - P_j g_ji + Q_i:k_ij - Q_j:k_ji),
// antisymmetric in the pair, so that momentum is conserved. The stabilising forces of the pairs are collected here too.

#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

template <int D, bool with_pair_forces>
void forces(const Reference<D>& reference, const Workspace<D>& work, State<D>& state) {
  const double* p[D][D];
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) p[a][b] = work.stress[a][b].data();
  constexpr int pairs = curvature_components<D>;
  const double* q[D][pairs];
  for (int a = 0; a < D; ++a)
    for (int c = 0; c < pairs; ++c) q[a][c] = work.double_stress[a][c].data();
  const auto rows = static_cast<std::ptrdiff_t>(reference.rows);

  for_each_block(static_cast<std::ptrdiff_t>(reference.blocks.size()), [&](std::ptrdiff_t n) {
    const Block& block = reference.blocks[n];
    if (!block.deforms) return;
    const std::ptrdiff_t i = block.row;
    const Stencil<D>& stencil = reference.stencils[block.stencil];
    const Neighbour<D>* neighbour = reference.neighbours.data() + stencil.first;
    const std::int32_t* offset = reference.row_offset.data() + stencil.first;
    const std::int32_t* slot = reference.pair_slot.data() + stencil.first;

    Lanes force[D];
    for (int a = 0; a < D; ++a) {
      force[a] = with_pair_forces ? load(state.internal_force[a].data() + i) : Lanes{};
      for (int b = 0; b < D; ++b) force[a] += load(p[a][b] + i) * stencil.gradient_sum[b];
      for (int c = 0; c < pairs; ++c) force[a] += load(q[a][c] + i) * stencil.curvature_sum[c];
    }
    const auto add_elastic = [&](std::uint32_t k) {
      const std::ptrdiff_t j = i + offset[k];
      for (int a = 0; a < D; ++a) {
        for (int b = 0; b < D; ++b) force[a] -= load(p[a][b] + j) * neighbour[k].mirror_gradient[b];
        for (int c = 0; c < pairs; ++c) force[a] -= load(q[a][c] + j) * neighbour[k].mirror_curvature[c];
      }
    };
    const std::uint32_t earlier = stencil.count - stencil.pairs;
    for (std::uint32_t k = 0; k < earlier; ++k) {
      add_elastic(k);
      if constexpr (with_pair_forces)
        for (int a = 0; a < D; ++a) force[a] -= load(work.pair_force[a].data() + slot[k] * rows + i + offset[k]);
    }
    for (std::uint32_t k = earlier; k < stencil.count; ++k) add_elastic(k);
    for (int a = 0; a < D; ++a) store(state.internal_force[a].data() + i, force[a]);
  });
}

}  // namespace

template <int D>
void internal_force(const Reference<D>& reference, const Workspace<D>& work, State<D>& state) {
  if (reference.has_diffusion || reference.has_penalty)
    forces<D, true>(reference, work, state);
  else
    forces<D, false>(reference, work, state);
}

template <int D>
bool elastic_force(const Reference<D>& reference, State<D>& state, Workspace<D>& work) {
  displacement_gradients(reference, state, work);
  if (!stresses(reference, work)) return false;
  forces<D, false>(reference, work, state);
  return true;
}

template bool elastic_force<2>(const Reference<2>&, State<2>&, Workspace<2>&);
template bool elastic_force<3>(const Reference<3>&, State<3>&, Workspace<3>&);
template void internal_force<2>(const Reference<2>&, const Workspace<2>&, State<2>&);
template void internal_force<3>(const Reference<3>&, const Workspace<3>&, State<3>&);

}  // namespace tern::structure
