// Deformation gradient  F_i = I + H_i,  H_i = sum_j V_j (d_j - d_i) x g_ij,  from displacements, not positions, so that
// round-off does not grow with the distance from the origin, and its own gradient, K_i^ab = sum_j V_j (d_j - d_i) k_ij^ab.
// The velocity gradient L_i is the sum of H over velocities.

#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

template <int D, bool with_velocity>
void gradients(const Reference<D>& reference, const State<D>& state, Workspace<D>& work) {
  constexpr int fields = with_velocity ? 2 * D : D;
  const double* field[fields];
  double* gradient[fields][D];
  constexpr int pairs = curvature_components<D>;
  double* curvature[D][pairs];
  for (int a = 0; a < D; ++a) {
    field[a] = state.displacement[a].data();
    for (int b = 0; b < D; ++b) gradient[a][b] = work.displacement_gradient[a][b].data();
    for (int c = 0; c < pairs; ++c) curvature[a][c] = work.curvature[a][c].data();
    if constexpr (with_velocity) {
      field[D + a] = state.velocity[a].data();
      for (int b = 0; b < D; ++b) gradient[D + a][b] = work.velocity_gradient[a][b].data();
    }
  }
  for_each_block(static_cast<std::ptrdiff_t>(reference.blocks.size()), [&](std::ptrdiff_t n) {
    const Block& block = reference.blocks[n];
    if (!block.deforms) return;
    const Stencil<D>& stencil = reference.stencils[block.stencil];
    const Neighbour<D>* neighbour = reference.neighbours.data() + stencil.first;
    const std::int32_t* offset = reference.row_offset.data() + stencil.first;
    Lanes own[fields], sum[fields][D] = {}, second[D][pairs] = {};
    for (int a = 0; a < fields; ++a) own[a] = load(field[a] + block.row);
    for (std::uint32_t k = 0; k < stencil.count; ++k) {
      const std::ptrdiff_t j = block.row + offset[k];
      for (int a = 0; a < fields; ++a) {
        const Lanes difference = load(field[a] + j) - own[a];
        for (int b = 0; b < D; ++b) sum[a][b] += difference * neighbour[k].gradient[b];
        if (a >= D) continue;
        for (int c = 0; c < pairs; ++c) second[a][c] += difference * neighbour[k].curvature[c];
      }
    }
    for (int a = 0; a < D; ++a)
      for (int c = 0; c < pairs; ++c) store(curvature[a][c] + block.row, second[a][c]);
    for (int a = 0; a < fields; ++a)
      for (int b = 0; b < D; ++b) store(gradient[a][b] + block.row, sum[a][b]);
  });
}

}  // namespace

template <int D>
void deformation_gradient(const Reference<D>& reference, const State<D>& state, Workspace<D>& work) {
  if (reference.has_diffusion)
    gradients<D, true>(reference, state, work);
  else
    gradients<D, false>(reference, state, work);
}

template <int D>
void displacement_gradients(const Reference<D>& reference, const State<D>& state, Workspace<D>& work) {
  gradients<D, false>(reference, state, work);
}

template void displacement_gradients<2>(const Reference<2>&, const State<2>&, Workspace<2>&);
template void displacement_gradients<3>(const Reference<3>&, const State<3>&, Workspace<3>&);
template void deformation_gradient<2>(const Reference<2>&, const State<2>&, Workspace<2>&);
template void deformation_gradient<3>(const Reference<3>&, const State<3>&, Workspace<3>&);

}  // namespace tern::structure
