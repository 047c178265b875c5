// First Piola-Kirchhoff stress of the neo-Hookean solid (seed paper eq. 4):
//   P = mu (F - F^-T) + lambda ln J F^-T,   F^-T = cof F / J.

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "particles/error.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// Cofactors of F; returns J.
Lanes cofactor(const Lanes (&f)[2][2], Lanes (&c)[2][2]) {
  c[0][0] = f[1][1];
  c[0][1] = -f[1][0];
  c[1][0] = -f[0][1];
  c[1][1] = f[0][0];
  return f[0][0] * c[0][0] + f[0][1] * c[0][1];
}

Lanes cofactor(const Lanes (&f)[3][3], Lanes (&c)[3][3]) {
  for (int a = 0; a < 3; ++a) {
    const int p = (a + 1) % 3, q = (a + 2) % 3;
    for (int b = 0; b < 3; ++b) {
      const int r = (b + 1) % 3, s = (b + 2) % 3;
      c[a][b] = f[p][r] * f[q][s] - f[p][s] * f[q][r];
    }
  }
  return f[0][0] * c[0][0] + f[0][1] * c[0][1] + f[0][2] * c[0][2];
}

bool all_positive_and_finite(const Lanes& j) {
  for (int lane = 0; lane < lane_count; ++lane)
    if (!(j[lane] > 0 && j[lane] <= std::numeric_limits<double>::max())) return false;
  return true;
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
  for (int a = 0; a < D; ++a)
    place += fmt::format("{}{:.5g}", a ? ", " : "", reference.position[a][row] + state.displacement[a][row]);
  const Body& body = reference.bodies[reference.particle_body.at(particle)];
  throw NumericalFailure(fmt::format(
      "Structure particle {} of body '{}' at ({}) m has J = det F = {:.4g} at t = {:.6g} s, but volume must stay positive; "
      "the load is too violent for this material and resolution: refine [structure] spacing ({:.3g} m), lower "
      "structure.numerics.courant, or raise structure.numerics.riemann_diffusion or hourglass_penalty.",
      particle, body.name, place, j, time_s, body.spacing));
}

}  // namespace

template <int D>
void first_piola_kirchhoff(const Reference<D>& reference, const State<D>& state, double time_s, Workspace<D>& work) {
  const double* h[D][D];
  double* p[D][D];
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) {
      h[a][b] = work.displacement_gradient[a][b].data();
      p[a][b] = work.stress[a][b].data();
    }
  const auto blocks = static_cast<std::ptrdiff_t>(reference.blocks.size());
  std::atomic<std::ptrdiff_t> failed = blocks;  // the lowest block that failed: the same one for any number of threads
  for_each_block(blocks, [&](std::ptrdiff_t n) {
    const Block& block = reference.blocks[n];
    if (!block.deforms) return;
    const Material& material = reference.bodies[block.body].material;
    Lanes f[D][D], c[D][D];
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) f[a][b] = load(h[a][b] + block.row) + (a == b ? 1.0 : 0.0);
    const Lanes j = cofactor(f, c);
    if (!all_positive_and_finite(j)) {
      for (auto lowest = failed.load(); n < lowest && !failed.compare_exchange_weak(lowest, n);) {}
      return;
    }
    Lanes log_j;
    Eigen::Map<Eigen::Array4d>(reinterpret_cast<double*>(&log_j)) =
        Eigen::Map<const Eigen::Array4d>(reinterpret_cast<const double*>(&j)).log();
    const Lanes factor = (material.lambda * log_j - material.mu) / j;
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) store(p[a][b] + block.row, material.mu * f[a][b] + factor * c[a][b]);
  });
  if (failed < blocks) fail(reference, state, time_s, work, reference.blocks[failed].row);
}

template void first_piola_kirchhoff<2>(const Reference<2>&, const State<2>&, double, Workspace<2>&);
template void first_piola_kirchhoff<3>(const Reference<3>&, const State<3>&, double, Workspace<3>&);

}  // namespace tern::structure
