// Stresses of a particle's cell, a cube of side dx in the reference configuration: with F = F_i + K_i (X - X_i) in it,
//   W = Psi(F_i) + dx^2/24 sum_a [ lambda (tr D_a)^2 + 2 mu D_a:D_a ],   D_a = sym(B_a),   B_a = dF/dX_a F^-1,
// at small strains to second order in dx. The second term is what a value at the middle of the cell leaves out: of n layers
// across a plate in bending, 1/n^2 of the stiffness. It also holds the zigzag motions that F_i alone does not see, and under
// compression it stiffens as the neo-Hookean solid does.
//   P = dW/dF = dPsi/dF - sum_a B_a^T Q_a,   Q_a = dW/d(dF/dX_a) = dx^2/12 S_a F^-T,   S_a = lambda tr(D_a) I + 2 mu D_a,
// dPsi/dF is that of the material (structure/material/registry.hpp), F^-T = cof F / J. Where the derivatives of the fit were completed
// (unseen_fields.hpp), P and Q become the derivatives of W over those of the fit.

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "structure/cofactor.hpp"
#include "structure/strain_gradient.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

bool all_positive_and_finite(const Lanes& j) {
  const auto fine = (j > Lanes{}) & (j <= broadcast(std::numeric_limits<double>::max()));
  return (fine[0] & fine[1] & fine[2] & fine[3]) != 0;
}

/// What most likely drives a particle to J <= 0, as a clause.
template <int D>
std::string likely_cause(const State<D>& state, const Body& body, std::int32_t row, double j) {
  if (!std::isfinite(j)) return "a load, a prescribed motion or the time integration has made the state infinite";
  double squared = 0;
  for (int a = 0; a < D; ++a) squared += state.velocity[a][row] * state.velocity[a][row];
  const double speed = std::sqrt(squared), wave_speed = body.material.pressure_wave_speed();
  if (speed > 0.5 * wave_speed)
    return fmt::format(
        "it moves at {:.3g} m/s, the pressure wave at {:.3g} m/s: the load is faster than the material can "
        "pass on",
        speed, wave_speed);
  const char* weakness = std::visit([](const auto& law) { return law.weakness; }, body.material.law);
  if (weakness != nullptr) return weakness;
  return "the load is too violent for this material and resolution";
}

template <int D>
[[noreturn]] void fail(const Reference<D>& reference, const State<D>& state, double time_s, const Workspace<D>& work,
                       std::int32_t first_row) {
  std::int32_t row = first_row;
  double j = 0;
  for (; row < first_row + lane_count; ++row) {
    j = deformation_gradient_of<D>(work, row).determinant();
    if (!(j > 0 && j <= std::numeric_limits<double>::max())) break;
  }
  const auto found = std::find(reference.particle_row.begin(), reference.particle_row.end(), row);
  const auto particle = static_cast<std::size_t>(found - reference.particle_row.begin());
  std::string place;
  double squared = 0;
  for (int a = 0; a < D; ++a) {
    place += fmt::format("{}{:.5g}", a ? ", " : "", reference.position[a][row] + state.displacement[a][row]);
    for (int b = 0; b < D; ++b) squared += work.stress[a][b][row] * work.stress[a][b][row];
  }
  const Body& body = reference.bodies[reference.particle_body.at(particle)];
  throw NumericalFailure(
      fmt::format("Structure particle {} of body '{}' at ({}) m has J = det F = {:.4g} at t = {:.6g} s, but volume must stay positive; "
                  "its stress one sub-step before was {:.3g} Pa (norm of P). Likely cause: {}. Refine [structure] spacing ({:.3g} m), "
                  "lower structure.numerics.courant, or raise structure.numerics.riemann_diffusion.",
                  particle, body.name, place, j, time_s, std::sqrt(squared), likely_cause(state, body, row, j), body.spacing));
}

/// Turns the stresses of a block into those of its fit.
template <int D>
void stresses_of_fit(const Reference<D>& reference, const Stencil<D>& stencil, const Workspace<D>& work, std::int32_t row,
                     Lanes (&stress)[D][D], Lanes (&double_stress)[D][curvature_components<D>]) {
  Lanes g[D][D], inverse_transposed[D][D], k[D][curvature_components<D>];
  for (int a = 0; a < D; ++a) {
    for (int b = 0; b < D; ++b) g[a][b] = load(work.fitted_gradient[a][b].data() + row) + (a == b ? 1.0 : 0.0);
    for (int c = 0; c < curvature_components<D>; ++c) k[a][c] = load(work.fitted_curvature[a][c].data() + row);
  }
  const Lanes inverse_j = 1 / cofactor(g, inverse_transposed);
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) inverse_transposed[a][b] *= inverse_j;
  stress_of_fit<D>(reference.unseen.data() + stencil.first_unseen, stencil.unseen, g, inverse_transposed, k, stress, double_stress);
}

/// Stresses of all blocks; returns the lowest one that failed, or their number.
template <int D>
std::ptrdiff_t stresses_of_blocks(const Reference<D>& reference, Workspace<D>& work) {
  constexpr int pairs = curvature_components<D>;
  const double *h[D][D], *k[D][pairs];
  double *p[D][D], *q[D][pairs];
  for (int a = 0; a < D; ++a) {
    for (int b = 0; b < D; ++b) {
      h[a][b] = work.displacement_gradient[a][b].data();
      p[a][b] = work.stress[a][b].data();
    }
    for (int c = 0; c < pairs; ++c) {
      k[a][c] = work.curvature[a][c].data();
      q[a][c] = work.double_stress[a][c].data();
    }
  }
  const auto blocks = static_cast<std::ptrdiff_t>(reference.blocks.size());
  std::atomic<std::ptrdiff_t> failed = blocks;  // the lowest block that failed: the same one for any number of threads
  for_each_block(blocks, [&](std::ptrdiff_t n) {
    const Block& block = reference.blocks[n];
    if (!block.deforms) return;
    const Body& body = reference.bodies[block.body];
    const Material& material = body.material;
    Lanes gradient[D][D], f[D][D], inverse_transposed[D][D], stress[D][D];
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) {
        gradient[a][b] = load(h[a][b] + block.row);
        f[a][b] = gradient[a][b] + (a == b ? 1.0 : 0.0);
      }
    const Lanes j = cofactor(f, inverse_transposed);
    if (!all_positive_and_finite(j)) {
      for (auto lowest = failed.load(); n < lowest && !failed.compare_exchange_weak(lowest, n);) {}
      return;
    }
    const Lanes inverse_j = 1 / j;
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) inverse_transposed[a][b] *= inverse_j;
    std::visit([&](const auto& law) { law.template stress<D>(gradient, f, inverse_transposed, j, stress); }, material.law);
    // Energy belongs to free particles: what a particle on the face of a clamp thinks of its neighbours exerts no force.
    const Lanes zero = {};
    const auto has_energy = block.has_face ? load(reference.volume.data() + block.row) > zero : zero == zero;
    Lanes second[D][pairs], double_stress[D][pairs] = {};
    for (int a = 0; a < D; ++a)
      for (int c = 0; c < pairs; ++c) second[a][c] = load(k[a][c] + block.row);
    strain_gradient<D>(material, body.spacing * body.spacing / 12, inverse_transposed, second, stress, double_stress);
    if (const Stencil<D>& stencil = reference.stencils[block.stencil]; stencil.unseen > 0)
      stresses_of_fit(reference, stencil, work, block.row, stress, double_stress);
    for (int a = 0; a < D; ++a)
      for (int c = 0; c < pairs; ++c) store(q[a][c] + block.row, has_energy ? double_stress[a][c] : zero);
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) store(p[a][b] + block.row, has_energy ? stress[a][b] : zero);
  });
  return failed;
}

}  // namespace

template <int D>
bool stresses(const Reference<D>& reference, Workspace<D>& work) {
  return stresses_of_blocks(reference, work) == static_cast<std::ptrdiff_t>(reference.blocks.size());
}

template <int D>
void first_piola_kirchhoff(const Reference<D>& reference, const State<D>& state, double time_s, Workspace<D>& work) {
  const auto failed = static_cast<std::size_t>(stresses_of_blocks(reference, work));
  if (failed < reference.blocks.size()) fail(reference, state, time_s, work, reference.blocks[failed].row);
}

template bool stresses<2>(const Reference<2>&, Workspace<2>&);
template bool stresses<3>(const Reference<3>&, Workspace<3>&);

template void first_piola_kirchhoff<2>(const Reference<2>&, const State<2>&, double, Workspace<2>&);
template void first_piola_kirchhoff<3>(const Reference<3>&, const State<3>&, double, Workspace<3>&);

}  // namespace tern::structure
