// What the fluid cannot be doing: particles a thousand times as fast as the scene makes them, and steps a hundredth of what it
// asks for, window after window: a run that crawls on like that never ends. Reference: the fall through the height of the fluid, its
// velocity at the start, the fastest wall so far, the body at the first window. And the volume of the fluid beside bodies, which
// nothing changes but a body whose surface moves otherwise than the fluid was told: light bodies under CM2 do, without a sound.

#include <cmath>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "fluid/fluid.hpp"

namespace tern::fluid {
namespace {

constexpr double impossible = 1000;   ///< speed over the reference
constexpr double collapsed = 100;     ///< the same, when it lasts; jets from impacts reach ten
constexpr int lasting = 10;           ///< windows
constexpr double lost_volume = 0.05;  ///< of the fluid, when it lasts; sound runs stay below 0.025

}  // namespace

template <int D>
void Fluid<D>::check_speed() {
  if (state_.time == 0)
    for (const auto& u : surface_.velocity) reference_speed_ = std::max(reference_speed_, u.norm());
  reference_speed_ = std::max(reference_speed_, walls_.largest_speed());
  const double reference = reference_speed_ > 0 ? reference_speed_ : 1.0;
  const double fastest = std::sqrt(ordered_max(static_cast<std::ptrdiff_t>(state_.size()), 0.0, [&](std::ptrdiff_t i) {
    const double squared = predicted_velocity_[i].squaredNorm();
    return std::isfinite(squared) ? squared : 1e300;
  }));
  windows_of_collapse_ = fastest < collapsed * reference ? 0 : windows_of_collapse_ + 1;
  const bool lasts = windows_of_collapse_ == lasting;
  if (fastest < impossible * reference && !lasts) return;
  for (std::size_t i = 0; i < state_.size(); ++i) {
    const double speed = predicted_velocity_[i].norm();
    if (speed < (1 - 1e-12) * fastest) continue;
    std::string where;
    for (int c = 0; c < D; ++c) where += fmt::format("{}{:.5g}", c ? ", " : "", predicted_position_[i][c]);
    throw NumericalFailure(fmt::format(
        "The speed of fluid particle {} at ({}) m is {:.4g} m/s at t = {:.6g} s, above the limit of {:.4g} m/s ({} the reference speed of "
        "the scene); pressure there {:.4g} Pa. The step has {}: use a smaller fluid.numerics.courant, or for a light structure the "
        "coupling "
        "algorithm CM3.",
        state_.id[i], where, speed, begin_s_ + duration_s_, (lasts ? collapsed : impossible) * reference,
        lasts ? "for ten windows a hundred times" : "a thousand times", state_.pressure[i],
        lasts ? fmt::format("collapsed to {:.3g} s, which this speed asks for", duration_s_) : "become unstable"));
  }
}

template <int D>
void Fluid<D>::check_volume() {
  const double drift = surface_.size() == 0 ? 0 : volume_drift();
  windows_of_lost_volume_ = std::abs(drift) < lost_volume ? 0 : windows_of_lost_volume_ + 1;
  if (windows_of_lost_volume_ < lasting) return;
  throw NumericalFailure(fmt::format(
      "The fluid has {} {:.1f} % of its volume by t = {:.6g} s, and more than {:g} % for ten windows. The surface of a body moves "
      "otherwise than the fluid was told, or is too coarse to hold it: use coupling.algorithm = \"CM3\", or a smaller "
      "fluid.numerics.gravity_courant and courant.",
      drift < 0 ? "lost" : "gained", 100 * std::abs(drift), begin_s_ + duration_s_, 100 * lost_volume));
}

template void Fluid<2>::check_volume();
template void Fluid<3>::check_volume();
template void Fluid<2>::check_speed();
template void Fluid<3>::check_speed();

}  // namespace tern::fluid
