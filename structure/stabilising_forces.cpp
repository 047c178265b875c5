// The two pair forces that keep particles from motions F does not see: Riemann diffusion (riemann_diffusion.hpp) and
// hourglass penalty (hourglass_penalty.hpp). Both measure how far a pair departs from the linear field of its ends,
//   (F_i + F_j)/2 X_ji - x_ji = (H_i + H_j)/2 X_ji - (d_j - d_i)   and   v_j - v_i - (L_i + L_j)/2 X_ji,
// and both are equal and opposite on the two ends, so each pair is computed once.

#include <algorithm>

#include "structure/hourglass_penalty.hpp"
#include "structure/riemann_diffusion.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// Keeps 1/|x|^2 finite for lanes without neighbour, whose weight is zero.
constexpr double smallest_square = 1e-300;

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

/// Forces of the pairs into work.pair_force, their sum over the pairs that begin in a row into state.internal_force.
template <int D, bool with_diffusion, bool with_penalty>
void pair_forces(const Reference<D>& reference, double dt, State<D>& state, Workspace<D>& work) {
  const auto rows = static_cast<std::ptrdiff_t>(reference.rows);
  for_each_deforming_block(reference, [&](std::ptrdiff_t n, const Block& block, const Stencil<D>& stencil) {
    const std::ptrdiff_t i = block.row;
    const Material& material = reference.bodies[block.body].material;
    const double pressure_speed = material.pressure_wave_speed(), shear_speed = material.shear_wave_speed();
    const std::uint32_t first = stencil.first + stencil.count - stencil.pairs;
    const Gradient<D> displacement_gradient(work.displacement_gradient, i);
    const Gradient<D> velocity_gradient(work.velocity_gradient, i);

    const double *d[D], *v[D];
    Lanes own_d[D], own_v[D], force[D] = {}, dissipated = {}, stored = {};
    for (int a = 0; a < D; ++a) {
      d[a] = state.displacement[a].data();
      v[a] = state.velocity[a].data();
      own_d[a] = load(d[a] + i);
      own_v[a] = load(v[a] + i);
    }
    for (std::uint32_t k = 0; k < stencil.pairs; ++k) {
      const Pair<D>& pair = reference.pairs[stencil.first_pair + k];
      const std::ptrdiff_t j = i + reference.row_offset[first + k];
      Lanes moved[D], jump[D], x[D], pair_force[D] = {}, square = broadcast(smallest_square);
      for (int a = 0; a < D; ++a) {
        moved[a] = load(d[a] + j) - own_d[a];
        jump[a] = load(v[a] + j) - own_v[a];
        x[a] = 2 * pair.half_offset[a] + moved[a];
        square += x[a] * x[a];
      }
      const Lanes inverse_square = 1 / square;
      if constexpr (with_penalty) {
        Lanes mismatch[D], pull[D];
        displacement_gradient.sum_times(j, pair.half_offset, mismatch);
        for (int a = 0; a < D; ++a) mismatch[a] -= moved[a];
        hourglass_penalty<D>(x, inverse_square, mismatch, pull);
        for (int a = 0; a < D; ++a) {
          pull[a] *= pair.penalty;
          pair_force[a] += pull[a];
          stored += pull[a] * jump[a];
        }
      }
      if constexpr (with_diffusion) {
        Lanes reconstructed[D], drag[D];
        velocity_gradient.sum_times(j, pair.half_offset, reconstructed);
        for (int a = 0; a < D; ++a) reconstructed[a] = jump[a] - reconstructed[a];
        riemann_diffusion<D>(x, inverse_square, jump, reconstructed, pressure_speed, shear_speed, drag);
        for (int a = 0; a < D; ++a) {
          drag[a] *= pair.diffusion;
          pair_force[a] += drag[a];
          dissipated += drag[a] * jump[a];
        }
      }
      const std::ptrdiff_t place = reference.pair_slot[first + k] * rows + i;
      for (int a = 0; a < D; ++a) {
        force[a] += pair_force[a];
        store(work.pair_force[a].data() + place, pair_force[a]);
      }
    }
    for (int a = 0; a < D; ++a) store(state.internal_force[a].data() + i, force[a]);
    if constexpr (with_penalty) state.penalty_store[n] += dt * stored;
    if constexpr (with_diffusion) state.diffusion_loss[n] += dt * dissipated;
  });
}

/// Subtracts from the force of every row that of the pairs that end in it. The energy that a pair loses is its force times the
/// velocity in the middle of the kick, f dt/(2m) past the present one.
template <int D>
void collect(const Reference<D>& reference, double dt, const Workspace<D>& work, State<D>& state) {
  const auto rows = static_cast<std::ptrdiff_t>(reference.rows);
  for_each_deforming_block(reference, [&](std::ptrdiff_t n, const Block& block, const Stencil<D>& stencil) {
    Lanes force[D];
    for (int a = 0; a < D; ++a) force[a] = load(state.internal_force[a].data() + block.row);
    for (std::uint32_t k = stencil.first; k < stencil.first + stencil.count - stencil.pairs; ++k) {
      const std::ptrdiff_t place = reference.pair_slot[k] * rows + block.row + reference.row_offset[k];
      for (int a = 0; a < D; ++a) force[a] -= load(work.pair_force[a].data() + place);
    }
    Lanes squared = {};
    for (int a = 0; a < D; ++a) {
      store(state.internal_force[a].data() + block.row, force[a]);
      squared += force[a] * force[a];
    }
    if (reference.has_diffusion) state.diffusion_loss[n] -= 0.5 * dt * dt * load(reference.inverse_mass.data() + block.row) * squared;
  });
}

}  // namespace

template <int D>
void stabilising_forces(const Reference<D>& reference, double dt, State<D>& state, Workspace<D>& work) {
  if (!reference.has_diffusion && !reference.has_penalty) {
    for (auto& axis : state.internal_force) std::fill(axis.begin(), axis.end(), 0);
    return;
  }
  if (reference.has_diffusion) work.evaluations.riemann_diffusion += reference.rows;
  if (reference.has_penalty) work.evaluations.hourglass_penalty += reference.rows;
  if (reference.has_diffusion && reference.has_penalty)
    pair_forces<D, true, true>(reference, dt, state, work);
  else if (reference.has_diffusion)
    pair_forces<D, true, false>(reference, dt, state, work);
  else
    pair_forces<D, false, true>(reference, dt, state, work);
  collect(reference, dt, work, state);
}

template void stabilising_forces<2>(const Reference<2>&, double, State<2>&, Workspace<2>&);
template void stabilising_forces<3>(const Reference<3>&, double, State<3>&, Workspace<3>&);

}  // namespace tern::structure
