// Deformation gradient  F_i = I + H_i,  H_i = sum_j V_j (d_j - d_i) x g_ij,  from displacements, not positions, so that
// round-off does not grow with the distance from the origin, and its own gradient, K_i^ab = sum_j V_j (d_j - d_i) k_ij^ab.
// Where the neighbours do not determine second derivatives, both are completed (unseen_fields.hpp), and F_i below is that of the fit.
// The velocity gradient l_i is that in the present place, l_i = (sum_j V_j (v_j - v_i) x g_ij) F_i^-1: in a rigid rotation it is the
// spin, however the body is deformed.

#include "structure/cofactor.hpp"
#include "structure/shell/shell_body.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// One component of the block at `row`: gradient and second derivatives of the displacement d, and gradient of the velocity v.
/// Component by component, so that all sums stay in registers.
template <int D, bool with_velocity>
inline void gradients_of_component(const Stencil<D>& stencil, const Neighbour<D>* neighbour, const std::int32_t* offset, const double* d,
                                   const double* v, Lanes (&gradient)[D], Lanes (&second)[curvature_components<D>],
                                   Lanes (&velocity_gradient)[D]) {
  const Lanes own_d = load(d), own_v = with_velocity ? load(v) : Lanes{};
  for (std::uint32_t k = 0; k < stencil.count; ++k) {
    const Neighbour<D>& n = neighbour[k];
    const Lanes moved = load(d + offset[k]) - own_d;
    for (int b = 0; b < D; ++b) gradient[b] += moved * n.gradient[b];
    for (int c = 0; c < curvature_components<D>; ++c) second[c] += moved * n.curvature[c];
    if constexpr (with_velocity) {
      const Lanes jump = load(v + offset[k]) - own_v;
      for (int b = 0; b < D; ++b) velocity_gradient[b] += jump * n.gradient[b];
    }
  }
}

/// Completes the derivatives of a block, which the workspace has from the fit.
template <int D>
void complete_block(const Reference<D>& reference, const Block& block, const Stencil<D>& stencil, Workspace<D>& work) {
  Lanes h[D][D], f[D][D], inverse_transposed[D][D], k[D][curvature_components<D>];
  for (int a = 0; a < D; ++a) {
    for (int b = 0; b < D; ++b) {
      h[a][b] = load(work.displacement_gradient[a][b].data() + block.row);
      store(work.fitted_gradient[a][b].data() + block.row, h[a][b]);
      f[a][b] = h[a][b] + (a == b ? 1.0 : 0.0);
    }
  }
  if (stencil.unseen == 0) return;
  for (int a = 0; a < D; ++a)
    for (int c = 0; c < curvature_components<D>; ++c) {
      k[a][c] = load(work.curvature[a][c].data() + block.row);
      store(work.fitted_curvature[a][c].data() + block.row, k[a][c]);
    }
  const Lanes inverse_j = 1 / cofactor(f, inverse_transposed);
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) inverse_transposed[a][b] *= inverse_j;
  complete<D>(reference.unseen.data() + stencil.first_unseen, stencil.unseen, f, inverse_transposed, h, k);
  for (int a = 0; a < D; ++a) {
    for (int b = 0; b < D; ++b) store(work.displacement_gradient[a][b].data() + block.row, h[a][b]);
    for (int c = 0; c < curvature_components<D>; ++c) store(work.curvature[a][c].data() + block.row, k[a][c]);
  }
}

/// All derivatives of a block.
template <int D, bool with_velocity>
inline void gradients_of_block(const Reference<D>& reference, const Block& block, const Stencil<D>& stencil, const State<D>& state,
                               Workspace<D>& work) {
  const Neighbour<D>* neighbour = reference.neighbours.data() + stencil.first;
  const std::int32_t* offset = reference.row_offset.data() + stencil.first;
  Lanes f[D][D], material_gradient[D][D] = {};
  for (int a = 0; a < D; ++a) {
    Lanes gradient[D] = {}, second[curvature_components<D>] = {};
    gradients_of_component<D, with_velocity>(stencil, neighbour, offset, state.displacement[a].data() + block.row,
                                             state.velocity[a].data() + block.row, gradient, second, material_gradient[a]);
    for (int b = 0; b < D; ++b) {
      store(work.displacement_gradient[a][b].data() + block.row, gradient[b]);
      f[a][b] = gradient[b] + (a == b ? 1.0 : 0.0);
    }
    for (int c = 0; c < curvature_components<D>; ++c) store(work.curvature[a][c].data() + block.row, second[c]);
  }
  if constexpr (with_velocity) {
    Lanes inverse_transposed[D][D];
    const Lanes inverse_j = 1 / cofactor(f, inverse_transposed);
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) {
        Lanes l = material_gradient[a][0] * inverse_transposed[b][0];
        for (int c = 1; c < D; ++c) l += material_gradient[a][c] * inverse_transposed[b][c];
        store(work.velocity_gradient[a][b].data() + block.row, l * inverse_j);
      }
  }
  if (!reference.unseen.empty()) complete_block(reference, block, stencil, work);
}

template <int D, bool with_velocity>
void gradients(const Reference<D>& reference, const State<D>& state, Workspace<D>& work) {
  for_each_deforming_block(reference, [&](std::ptrdiff_t, const Block& block, const Stencil<D>& stencil) {
    gradients_of_block<D, with_velocity>(reference, block, stencil, state, work);
  });
}

}  // namespace

template <int D>
void deformation_gradient(const Reference<D>& reference, const State<D>& state, Workspace<D>& work) {
  if (reference.has_diffusion)
    gradients<D, true>(reference, state, work);
  else
    gradients<D, false>(reference, state, work);
  shell_derivatives(reference, state, work);
}

template <int D>
void displacement_gradients(const Reference<D>& reference, const State<D>& state, Workspace<D>& work) {
  gradients<D, false>(reference, state, work);
  shell_derivatives(reference, state, work);
}

template void displacement_gradients<2>(const Reference<2>&, const State<2>&, Workspace<2>&);
template void displacement_gradients<3>(const Reference<3>&, const State<3>&, Workspace<3>&);
template void deformation_gradient<2>(const Reference<2>&, const State<2>&, Workspace<2>&);
template void deformation_gradient<3>(const Reference<3>&, const State<3>&, Workspace<3>&);

}  // namespace tern::structure
