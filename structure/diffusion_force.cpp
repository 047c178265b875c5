// The Riemann diffusion (riemann_diffusion.hpp): a pair force that answers how far the velocities of a pair depart from the linear field
// of its ends, v_j - v_i - (l_i + l_j)/2 x_ji. It is equal and opposite on the two ends, so each pair is computed once.

#include <algorithm>
#include <cmath>

#include "structure/cofactor.hpp"
#include "structure/riemann_diffusion.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// Keeps 1/|x|^2 finite for lanes without neighbour, whose weight is zero.
constexpr double smallest_square = 1e-300;

/// Pairs whose moments are added one after the other.
template <int D>
constexpr std::uint32_t together = D == 2 ? 1 : 16;

template <int D>
struct Gradient {
  const double* rows[D][D];
  Lanes own[D][D];

  Gradient(const RowMatrices<D>& m, std::ptrdiff_t i) {
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) {
        rows[a][b] = m[a][b].data();
        own[a][b] = load(rows[a][b] + i);
      }
  }

  /// c = (M_i + M_j) y.
  void sum_times(std::ptrdiff_t j, const Lanes (&y)[D], Lanes (&c)[D]) const {
    for (int a = 0; a < D; ++a) {
      c[a] = (own[a][0] + load(rows[a][0] + j)) * y[0];
      for (int b = 1; b < D; ++b) c[a] += (own[a][b] + load(rows[a][b] + j)) * y[b];
    }
  }
};

/// Forces of the pairs into work.drag. Of the pairs that begin in a row, their sum into state.internal_force, and that of f_ij x x_ji
/// into work.diffusion_stress.
template <int D>
void pair_forces(const Reference<D>& reference, State<D>& state, Workspace<D>& work) {
  const auto rows = static_cast<std::ptrdiff_t>(reference.rows);
  for_each_deforming_block(reference, [&](std::ptrdiff_t n, const Block& block, const Stencil<D>& stencil) {
    const std::ptrdiff_t i = block.row;
    const Material& material = reference.bodies[block.body].material;
    const double pressure_speed = material.pressure_wave_speed(), shear_speed = material.shear_wave_speed();
    const Gradient<D> velocity_gradient(work.velocity_gradient, i);

    const double *d[D], *v[D];
    double* drags[D];
    Lanes own_d[D], own_v[D], force[D] = {}, moment[D][D] = {}, dissipated = {};
    for (int a = 0; a < D; ++a) {
      d[a] = state.displacement[a].data();
      v[a] = state.velocity[a].data();
      drags[a] = work.drag[a].data();
      own_d[a] = load(d[a] + i);
      own_v[a] = load(v[a] + i);
    }
    // Pair after pair, and in 3D the moment of some of them after their forces: forces and moment at once do not stay in registers.
    Lanes place_of[together<D>][D], drag_of[together<D>][D];
    const auto add_moments = [&](std::uint32_t count) {
      for (std::uint32_t k = 0; k < count; ++k)
        for (int a = 0; a < D; ++a)
          for (int b = 0; b < D; ++b) moment[a][b] += drag_of[k][a] * place_of[k][b];
    };
    std::uint32_t kept = 0;
    for (std::uint32_t k = stencil.later; k < stencil.first + stencil.count; ++k) {
      const Pair<D>& pair = reference.pairs[k];
      const std::ptrdiff_t j = i + reference.row_offset[k], place = reference.pair_slot[k] * rows + i;
      Lanes moved[D], jump[D], x[D], square = broadcast(smallest_square);
      for (int a = 0; a < D; ++a) {
        moved[a] = load(d[a] + j) - own_d[a];
        jump[a] = load(v[a] + j) - own_v[a];
        x[a] = 2 * pair.half_offset[a] + moved[a];
        square += x[a] * x[a];
      }
      const Lanes inverse_square = 1 / square;
      Lanes reconstructed[D], drag[D];
      velocity_gradient.sum_times(j, x, reconstructed);
      for (int a = 0; a < D; ++a) reconstructed[a] = jump[a] - 0.5 * reconstructed[a];
      riemann_diffusion<D>(x, inverse_square, reconstructed, pressure_speed, shear_speed, drag);
      for (int a = 0; a < D; ++a) {
        drag[a] *= pair.diffusion;
        dissipated += drag[a] * reconstructed[a];
        store(drags[a] + place, drag[a]);
        drag_of[kept][a] = drag[a];
        place_of[kept][a] = x[a];
        force[a] += drag[a];
      }
      if (++kept == together<D>) {
        add_moments(kept);
        kept = 0;
      }
    }
    add_moments(kept);
    for (int a = 0; a < D; ++a) store(state.internal_force[a].data() + i, force[a]);
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) store(work.diffusion_stress[a][b].data() + i, moment[a][b]);
    state.diffusion_power[n] = dissipated;
  });
}

/// Subtracts from the force of every row that of the pairs that end in it, and completes the stress of the diffusion.
template <int D>
void collect(const Reference<D>& reference, State<D>& state, Workspace<D>& work) {
  const auto rows = static_cast<std::ptrdiff_t>(reference.rows);
  for_each_deforming_block(reference, [&](std::ptrdiff_t, const Block& block, const Stencil<D>& stencil) {
    const std::ptrdiff_t i = block.row;
    Lanes force[D], moment[D][D];
    for (int a = 0; a < D; ++a) {
      force[a] = load(state.internal_force[a].data() + i);
      for (int b = 0; b < D; ++b) moment[a][b] = load(work.diffusion_stress[a][b].data() + i);
    }
    for (std::uint32_t k = stencil.first; k < stencil.later; ++k) {
      const std::ptrdiff_t j = i + reference.row_offset[k], place = reference.pair_slot[k] * rows + j;
      Lanes x[D];
      for (int a = 0; a < D; ++a) {
        const double* d = state.displacement[a].data();
        x[a] = 2 * reference.pairs[k].half_offset[a] + load(d + j) - load(d + i);
      }
      for (int a = 0; a < D; ++a) {
        const Lanes drag = load(work.drag[a].data() + place);
        force[a] -= drag;
        for (int b = 0; b < D; ++b) moment[a][b] -= drag * x[b];
      }
    }
    for (int a = 0; a < D; ++a) store(state.internal_force[a].data() + i, force[a]);
    Lanes f[D][D], inverse_transposed[D][D];
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) f[a][b] = load(fitted_gradient(work)[a][b].data() + i) + (a == b ? 1.0 : 0.0);
    const Lanes factor = -0.5 / (reference.bodies[block.body].cell_volume * cofactor(f, inverse_transposed));
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) {
        Lanes p = moment[a][0] * inverse_transposed[0][b];
        for (int c = 1; c < D; ++c) p += moment[a][c] * inverse_transposed[c][b];
        store(work.diffusion_stress[a][b].data() + i, factor * p);
      }
  });
}

/// Adds the divergence of the stress of the diffusion.
template <int D>
void spread(const Reference<D>& reference, const Workspace<D>& work, State<D>& state) {
  for_each_deforming_block(reference, [&](std::ptrdiff_t, const Block& block, const Stencil<D>& stencil) {
    // One sum per entry of the stress: a single one would wait for each of its own additions.
    const double* p[D][D];
    Lanes sum[D][D];
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) {
        p[a][b] = work.diffusion_stress[a][b].data() + block.row;
        sum[a][b] = load(p[a][b]) * stencil.gradient_sum[b];
      }
    for (std::uint32_t k = stencil.first; k < stencil.first + stencil.count; ++k)
      for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b) sum[a][b] -= load(p[a][b] + reference.row_offset[k]) * reference.neighbours[k].mirror_gradient[b];
    for (int a = 0; a < D; ++a) {
      double* f = state.internal_force[a].data() + block.row;
      Lanes force = load(f);
      for (int b = 0; b < D; ++b) force += sum[a][b];
      store(f, force);
    }
  });
}

}  // namespace

template <int D>
void diffusion_force(const Reference<D>& reference, State<D>& state, Workspace<D>& work) {
  if (!reference.has_diffusion) {
    for (auto& axis : state.internal_force) std::fill(axis.begin(), axis.end(), 0);
    return;
  }
  work.evaluations.riemann_diffusion += reference.rows;
  pair_forces(reference, state, work);
  collect(reference, state, work);
  spread(reference, work, state);
}

template void diffusion_force<2>(const Reference<2>&, State<2>&, Workspace<2>&);
template void diffusion_force<3>(const Reference<3>&, State<3>&, Workspace<3>&);

}  // namespace tern::structure
