// The pressure equation is not exactly the divergence of the pressure gradient. What one solve leaves of the divergence is a second
// right-hand side of the same matrix: one step of the method of minimal residuals, with the matrix as its preconditioner. The whole
// answer would leave eps^2 of a motion of which one solve leaves eps. Where water breaks, the moments of some particles are far from
// whole, eps is below -1 for a few windows, and the answer would grow with them. The share that is taken is a number for each part of
// the fluid, so that waters which a wall keeps apart do not feel each other through it.
//
// The part of the pressure gradient that keeps the particles in order is not answered. On disordered particles its divergence has a
// mean, and the pressure of water at rest would lack half of its weight.

#include "fluid/pressure/left_behind.hpp"

#include <algorithm>

#include "base/parallel.hpp"

namespace tern::fluid {

template <int D>
void assemble_left_behind(const Constants<D>& constants, double duration, const std::vector<ParticleClass>& particle_class,
                          const std::vector<double>& divergence, const std::vector<double>& target, std::vector<double>& left) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(divergence.size());
  const double scale = -constants.density / duration * constants.volume;
  parallel_for(n, [&](std::ptrdiff_t i) {
    if (particle_class[i].pressure_unknown()) left[i] = scale * (divergence[i] - target[i]);
  });
}

template <int D>
void add_correction(const PressureSystem<D>& system, State<D>& state) {
  const std::ptrdiff_t all = static_cast<std::ptrdiff_t>(state.pressure.size());
  parallel_for(all, [&](std::ptrdiff_t i) { state.pressure[i] += system.correction[i]; });
}

template <int D>
void find_best_share(const Ranks& ranks, PressureSystem<D>& system) {
  const std::vector<int>& part = system.multigrid.part_of_particle();
  auto &share = system.share, &left = system.left_behind, &square = system.squared_change;
  share.assign(system.multigrid.parts(), 0);
  if (share.empty()) return;                                                 // spray alone
  if (system.sealed.any()) system.sealed.subtract_means(system.still_left);  // as of left_behind: sealed fluid cannot answer them
  square.assign(system.multigrid.parts(), 0);
  for (std::size_t i = 0; i < left.size(); ++i) {
    const double change = left[i] - system.still_left[i];
    share[part[i]] += left[i] * change;
    square[part[i]] += change * change;
  }
  share.insert(share.end(), square.begin(), square.end());
  ranks.sum(std::span(share));
  square.assign(share.begin() + static_cast<std::ptrdiff_t>(square.size()), share.end());
  share.resize(square.size());
  for (std::size_t k = 0; k < share.size(); ++k) share[k] = square[k] > 0 ? std::clamp(share[k] / square[k], 0.0, 1.0) : 0;
}

template <int D>
void keep_share(const PressureSystem<D>& system, State<D>& state) {
  const std::ptrdiff_t all = static_cast<std::ptrdiff_t>(state.pressure.size());
  parallel_for(all, [&](std::ptrdiff_t i) { state.pressure[i] -= (1 - share_taken(system, i)) * system.correction[i]; });
  parallel_for(static_cast<std::ptrdiff_t>(state.size()),
               [&](std::ptrdiff_t i) { state.pressure_correction[i] = share_taken(system, i) * system.correction[i]; });
}

#define TERN_INSTANTIATE(D)                                                                                                         \
  template void assemble_left_behind<D>(const Constants<D>&, double, const std::vector<ParticleClass>&, const std::vector<double>&, \
                                        const std::vector<double>&, std::vector<double>&);                                          \
  template void add_correction<D>(const PressureSystem<D>&, State<D>&);                                                             \
  template void find_best_share<D>(const Ranks&, PressureSystem<D>&);                                                               \
  template void keep_share<D>(const PressureSystem<D>&, State<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
