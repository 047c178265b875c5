// Internal force, the exact negative gradient of sum_i V_i Psi(F_i) for any gradient vectors g_ij:
//   f_i = sum_j V_i V_j (P_i g_ij - P_j g_ji),
// antisymmetric in the pair, so that momentum is conserved; to it the two pair forces that keep the particles from motions
// F does not see. One loop over the neighbours for all three: they share the loads.

#include "structure/hourglass_penalty.hpp"
#include "structure/riemann_diffusion.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// Keeps 1/|x|^2 finite for lanes without neighbour, whose weight is zero.
constexpr double smallest_square = 1e-300;

template <int D>
struct Rows {
  const double* d[D];
  const double* v[D];
  const double* h[D][D];
  const double* l[D][D];
  const double* p[D][D];
};

/// c_a = (M_i + M_j) Y, M read from rows i and j.
template <int D>
inline void mean_times(const double* const (&m)[D][D], const Lanes (&own)[D][D], std::ptrdiff_t j, const Lanes (&y)[D],
                       Lanes (&c)[D]) {
  for (int a = 0; a < D; ++a) {
    c[a] = (own[a][0] + load(m[a][0] + j)) * y[0];
    for (int b = 1; b < D; ++b) c[a] += (own[a][b] + load(m[a][b] + j)) * y[b];
  }
}

template <int D, bool with_diffusion, bool with_penalty>
void forces(const Reference<D>& reference, const Workspace<D>& work, double dt, State<D>& state) {
  Rows<D> rows;
  for (int a = 0; a < D; ++a) {
    rows.d[a] = state.displacement[a].data();
    rows.v[a] = state.velocity[a].data();
    for (int b = 0; b < D; ++b) {
      rows.h[a][b] = work.displacement_gradient[a][b].data();
      rows.l[a][b] = work.velocity_gradient[a][b].data();
      rows.p[a][b] = work.stress[a][b].data();
    }
  }
  const auto blocks = static_cast<std::ptrdiff_t>(reference.blocks.size());
#pragma omp parallel for schedule(static) if (blocks > parallel_blocks)
  for (std::ptrdiff_t n = 0; n < blocks; ++n) {
    const Block& block = reference.blocks[n];
    if (!block.moves) continue;
    const Material& material = reference.bodies[block.body].material;
    const double pressure_speed = material.pressure_wave_speed(), shear_speed = material.shear_wave_speed();
    const Stencil<D>& stencil = reference.stencils[block.stencil];
    const StencilEntry<D>* entry = reference.entries.data() + stencil.first;
    const std::int32_t* offset = reference.row_offset.data() + stencil.first;
    const std::ptrdiff_t i = block.row;

    Lanes d[D], v[D], h[D][D], l[D][D], force[D], diffused = {}, stored = {};
    for (int a = 0; a < D; ++a) {
      d[a] = load(rows.d[a] + i);
      v[a] = load(rows.v[a] + i);
      force[a] = Lanes{};
      for (int b = 0; b < D; ++b) {
        h[a][b] = load(rows.h[a][b] + i);
        l[a][b] = load(rows.l[a][b] + i);
        force[a] += load(rows.p[a][b] + i) * stencil.gradient_sum[b];
      }
    }
    for (std::uint32_t k = 0; k < stencil.count; ++k) {
      const StencilEntry<D>& e = entry[k];
      const std::ptrdiff_t j = i + offset[k];
      for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) force[a] -= load(rows.p[a][b] + j) * e.mirror_gradient[b];
      if constexpr (with_diffusion || with_penalty) {
        Lanes stretch[D], jump[D], x[D], square = broadcast(smallest_square);
        for (int a = 0; a < D; ++a) {
          stretch[a] = load(rows.d[a] + j) - d[a];
          jump[a] = load(rows.v[a] + j) - v[a];
          x[a] = 2 * e.half_offset[a] + stretch[a];
          square += x[a] * x[a];
        }
        const Lanes inverse_square = 1 / square;
        if constexpr (with_penalty) {
          Lanes mismatch[D], pull[D];
          mean_times<D>(rows.h, h, j, e.half_offset, mismatch);
          for (int a = 0; a < D; ++a) mismatch[a] -= stretch[a];
          hourglass_penalty<D>(x, inverse_square, mismatch, pull);
          for (int a = 0; a < D; ++a) {
            pull[a] *= e.penalty;
            force[a] += pull[a];
            stored += pull[a] * jump[a];
          }
        }
        if constexpr (with_diffusion) {
          Lanes reconstructed[D], drag[D];
          mean_times<D>(rows.l, l, j, e.half_offset, reconstructed);
          for (int a = 0; a < D; ++a) reconstructed[a] = jump[a] - reconstructed[a];
          riemann_diffusion<D>(x, inverse_square, jump, reconstructed, pressure_speed, shear_speed, drag);
          for (int a = 0; a < D; ++a) {
            drag[a] *= e.diffusion;
            force[a] += drag[a];
            diffused += drag[a] * jump[a];
          }
        }
      }
    }
    for (int a = 0; a < D; ++a) store(state.internal_force[a].data() + i, force[a]);
    if constexpr (with_penalty) state.penalty_store[n] += dt * stored;
    if constexpr (with_diffusion) state.diffusion_loss[n] += dt * diffused;
  }
}

}  // namespace

template <int D>
void internal_force(const Reference<D>& reference, const Workspace<D>& work, double dt, State<D>& state) {
  if (reference.has_diffusion && reference.has_penalty)
    forces<D, true, true>(reference, work, dt, state);
  else if (reference.has_diffusion)
    forces<D, true, false>(reference, work, dt, state);
  else if (reference.has_penalty)
    forces<D, false, true>(reference, work, dt, state);
  else
    forces<D, false, false>(reference, work, dt, state);
}

template void internal_force<2>(const Reference<2>&, const Workspace<2>&, double, State<2>&);
template void internal_force<3>(const Reference<3>&, const Workspace<3>&, double, State<3>&);

}  // namespace tern::structure
