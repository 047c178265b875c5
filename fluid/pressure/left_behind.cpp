// The pressure equation is not exactly the divergence of the pressure gradient: of a divergence a solve leaves the part eps. What it is
// to leave in a window is foretold from the windows before, and is a second right-hand side of the same matrix: one step of the method of
// minimal residuals, with the matrix as its preconditioner. Where water breaks, the moments of some particles are far from whole, eps is
// below -1 for a few windows, and the answer would grow with them. The share that is taken is a number for each part of the fluid, so
// that waters which a wall keeps apart do not feel each other through it.
//
// What is foretold is the trend of the last windows, by double exponential smoothing (R. G. Brown, Smoothing, Forecasting and Prediction,
// 1963). What particles that change their places leave is new in every window, and the trend has little of it: were it answered at once,
// the loads of bodies would have that noise twice, from the equation and from its correction. A plain mean would lag behind a motion, and
// what it lags is a loss. And the trend is known before a window begins: what is tried in a window leaves no trace in its correction.
//
// The part of the pressure gradient that keeps the particles in order is not answered. On disordered particles its divergence has a
// mean, and the pressure of water at rest would lack half of its weight.

#include "fluid/pressure/left_behind.hpp"

#include <algorithm>

#include "base/parallel.hpp"

namespace tern::fluid {
namespace {

/// Of the means, per window. What is white noise in every window is half of it in what the means foretell.
constexpr double kept = 0.8;

}  // namespace

template <int D>
void assemble_left_behind(const Constants<D>& constants, double duration, const std::vector<ParticleClass>& particle_class,
                          const std::vector<double>& divergence, const std::vector<double>& target, std::vector<double>& left) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(divergence.size());
  const double scale = -constants.density / duration * constants.volume;
  parallel_for(n, [&](std::ptrdiff_t i) {
    if (particle_class[i].pressure_unknown()) left[i] = scale * (divergence[i] - target[i]);
  });
}

double expected_left_behind(double mean, double mean_of_mean) {
  return 2 * mean - mean_of_mean + (1 - kept) / kept * (mean - mean_of_mean);
}

template <int D>
void add_correction(const PressureSystem<D>& system, State<D>& state) {
  const std::ptrdiff_t all = static_cast<std::ptrdiff_t>(state.pressure.size());
  parallel_for(all, [&](std::ptrdiff_t i) { state.pressure[i] += system.correction[i]; });
}

template <int D>
void find_best_share(const Ranks& ranks, PressureSystem<D>& system) {
  const std::vector<int>& part = system.multigrid.part_of_particle();
  auto &share = system.share, &square = system.squared_change;
  parallel_for(static_cast<std::ptrdiff_t>(system.answered.size()),
               [&](std::ptrdiff_t i) { system.answered[i] = system.left_behind[i] - system.answered[i]; });
  share.assign(system.multigrid.parts(), 0);
  if (share.empty()) return;                                               // spray alone
  if (system.sealed.any()) system.sealed.subtract_means(system.answered);  // as of what is expected: sealed fluid cannot answer them
  square.assign(system.multigrid.parts(), 0);
  for (std::size_t i = 0; i < system.answered.size(); ++i) {
    share[part[i]] += system.expected[i] * system.answered[i];
    square[part[i]] += system.answered[i] * system.answered[i];
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

template <int D>
void add_share(const PressureSystem<D>& system, State<D>& state) {
  const std::ptrdiff_t all = static_cast<std::ptrdiff_t>(state.pressure.size());
  parallel_for(all, [&](std::ptrdiff_t i) { state.pressure[i] += share_taken(system, i) * system.correction[i]; });
}

template <int D>
void remember_left_behind(const PressureSystem<D>& system, State<D>& state) {
  parallel_for(static_cast<std::ptrdiff_t>(state.size()), [&](std::ptrdiff_t i) {
    const bool unknown = state.particle_class[i].pressure_unknown();
    state.left_behind[i] = unknown ? kept * state.left_behind[i] + (1 - kept) * system.left_behind[i] : 0;
    state.left_behind_twice[i] = unknown ? kept * state.left_behind_twice[i] + (1 - kept) * state.left_behind[i] : 0;
  });
}

#define TERN_INSTANTIATE(D)                                                                                                         \
  template void assemble_left_behind<D>(const Constants<D>&, double, const std::vector<ParticleClass>&, const std::vector<double>&, \
                                        const std::vector<double>&, std::vector<double>&);                                          \
  template void add_correction<D>(const PressureSystem<D>&, State<D>&);                                                             \
  template void find_best_share<D>(const Ranks&, PressureSystem<D>&);                                                               \
  template void keep_share<D>(const PressureSystem<D>&, State<D>&);                                                                 \
  template void add_share<D>(const PressureSystem<D>&, State<D>&);                                                                  \
  template void remember_left_behind<D>(const PressureSystem<D>&, State<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
