// What the fluid cannot be doing: particles a thousand times as fast as the scene makes them, and steps a hundredth of what it
// asks for, window after window: a run that crawls on like that never ends. Reference: the fall through the height of the fluid, its
// velocity at the start, the fastest wall so far, the fastest clamp of the run, the bodies at the first window, and so far the root mean
// square over their surfaces: a body that loads set moving takes the fluid along. And the volume of the fluid beside bodies, which
// nothing changes but a body whose surface moves otherwise than the fluid was told.

#include "fluid/motion/speed_limit.hpp"

#include <cmath>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "fluid/gauges/totals.hpp"

namespace tern::fluid {
namespace {

constexpr double impossible = 1000;   ///< speed over the reference
constexpr double collapsed = 100;     ///< the same, when it lasts; jets from impacts reach ten
constexpr int lasting = 10;           ///< windows
constexpr double lost_volume = 0.05;  ///< of the fluid, when it lasts; sound runs stay below 0.025

}  // namespace

template <int D>
void check_speed(const Ranks& ranks, const Window& window, const Prediction<D>& prediction, const std::vector<Vector<D>>& surface_velocity,
                 State<D>& state) {
  double squares = 0;
  for (const auto& u : surface_velocity) {
    squares += u.squaredNorm();
    if (state.time == 0) state.reference_speed = std::max(state.reference_speed, u.norm());
  }
  if (squares > 0)
    state.reference_speed = std::max(state.reference_speed, std::sqrt(squares / static_cast<double>(surface_velocity.size())));
  state.reference_speed = std::max(state.reference_speed, state.wall_speed);
  const double reference = state.reference_speed > 0 ? state.reference_speed : 1.0;
  const double fastest = std::sqrt(ranks.most(ordered_max(static_cast<std::ptrdiff_t>(state.size()), 0.0, [&](std::ptrdiff_t i) {
    const double squared = prediction.velocity[i].squaredNorm();
    return std::isfinite(squared) ? squared : 1e300;
  })));
  state.windows_of_collapse = fastest < collapsed * reference ? 0 : state.windows_of_collapse + 1;
  const bool lasts = state.windows_of_collapse == lasting;
  if (fastest < impossible * reference && !lasts) return;
  std::string sentence;
  for (std::size_t i = 0; i < state.size() && sentence.empty(); ++i) {
    const double speed = prediction.velocity[i].norm();
    if (speed < (1 - 1e-12) * fastest) continue;
    std::string where;
    for (int c = 0; c < D; ++c) where += fmt::format("{}{:.5g}", c ? ", " : "", prediction.position[i][c]);
    sentence = fmt::format(
        "The speed of fluid particle {} at ({}) m is {:.4g} m/s at t = {:.6g} s, above the limit of {:.4g} m/s ({} the reference speed of "
        "the scene); pressure there {:.4g} Pa. The step has {}: use a smaller fluid.numerics.courant.",
        state.id[i], where, speed, window.begin + window.duration, (lasts ? collapsed : impossible) * reference,
        lasts ? "for ten windows a hundred times" : "a thousand times", state.pressure[i],
        lasts ? fmt::format("collapsed to {:.3g} s, which this speed asks for", window.duration) : "become unstable");
  }
  throw NumericalFailure(ranks.first_word(sentence));
}

template <int D>
void check_volume(const Window& window, double drift, State<D>& state) {
  state.windows_of_lost_volume = std::abs(drift) < lost_volume ? 0 : state.windows_of_lost_volume + 1;
  if (state.windows_of_lost_volume < lasting) return;
  throw NumericalFailure(fmt::format(
      "The fluid has {} {:.1f} % of its volume by t = {:.6g} s, and more than {:g} % for ten windows. The surface of a body moves "
      "otherwise than the fluid was told, or is too coarse to hold it: use a smaller spacing of the body, or a smaller "
      "fluid.numerics.gravity_courant and courant.",
      drift < 0 ? "lost" : "gained", 100 * std::abs(drift), window.begin + window.duration, 100 * lost_volume));
}

template void check_speed<2>(const Ranks&, const Window&, const Prediction<2>&, const std::vector<Vector<2>>&, State<2>&);
template void check_speed<3>(const Ranks&, const Window&, const Prediction<3>&, const std::vector<Vector<3>>&, State<3>&);
template void check_volume<2>(const Window&, double, State<2>&);
template void check_volume<3>(const Window&, double, State<3>&);

}  // namespace tern::fluid
