// A particle method can let two layers pass through each other while J stays positive everywhere: the pattern is one that F
// does not see. The bond then points against the direction that F of its ends gives it, (F_i + F_j)/2 X_ji . x_ji < 0.

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// Rows of the first bond found, in the order of the blocks, that points backwards; {-1, -1} when there is none.
template <int D>
std::pair<std::int32_t, std::int32_t> backward_bond(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work) {
  for (const Block& block : reference.blocks) {
    if (!block.deforms) continue;
    const Stencil<D>& stencil = reference.stencils[block.stencil];
    for (std::uint32_t k = stencil.later; k < stencil.first + stencil.count; ++k) {
      const Pair<D>& pair = reference.pairs[k];
      const std::ptrdiff_t i = block.row, j = i + reference.row_offset[k];
      Lanes along = {};
      for (int a = 0; a < D; ++a) {
        Lanes expected = 2 * pair.half_offset[a];
        for (int b = 0; b < D; ++b) {
          const double* h = work.displacement_gradient[a][b].data();
          expected += (load(h + i) + load(h + j)) * pair.half_offset[b];
        }
        const double* d = state.displacement[a].data();
        along += expected * (2 * pair.half_offset[a] + load(d + j) - load(d + i));
      }
      for (int lane = 0; lane < lane_count; ++lane)
        if (along[lane] < 0) return {static_cast<std::int32_t>(i) + lane, static_cast<std::int32_t>(j) + lane};
    }
  }
  return {-1, -1};
}

}  // namespace

template <int D>
void check_bond_order(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work) {
  const auto [first, second] = backward_bond(reference, state, work);
  if (first < 0) return;
  const auto particle_of = [&](std::int32_t row) {
    return std::find(reference.particle_row.begin(), reference.particle_row.end(), row) - reference.particle_row.begin();
  };
  const auto particle = particle_of(first);
  std::string place;
  for (int a = 0; a < D; ++a) place += fmt::format("{}{:.5g}", a ? ", " : "", reference.position[a][first] + state.displacement[a][first]);
  const Body& body = reference.bodies[reference.particle_body[particle]];
  throw NumericalFailure(fmt::format(
      "Structure particles {} and {} of body '{}', near ({}) m, have passed through each other at t = {:.6g} s. Likely cause: a load "
      "that the material cannot carry at this resolution, beside a clamp or an edge. Refine [structure] spacing ({:.3g} m).",
      particle, particle_of(second), body.name, place, seconds(state.time), body.spacing));
}

template void check_bond_order<2>(const Reference<2>&, const State<2>&, const Workspace<2>&);
template void check_bond_order<3>(const Reference<3>&, const State<3>&, const Workspace<3>&);

}  // namespace tern::structure
