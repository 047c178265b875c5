#include "fluid/step_proposal.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fluid/gauges/totals.hpp"

namespace tern::fluid {

template <int D>
StepProposal propose_step(const Reference<D>& reference, double fastest, const std::optional<double>& fastest_in_frame,
                          const State<D>& state) {
  const Constants<D>& constants = reference.constants;
  double speed = std::max({fastest, state.wall_speed, state.body_speed});
  if (fastest_in_frame) {
    const double in_frame = std::max({*fastest_in_frame, state.wall_speed_in_frame, state.body_speed_in_frame});
    speed = in_frame > 1e-12 * speed ? std::min(speed, in_frame) : 0;  // round-off of a scene that moves evenly
  }
  speed = std::max(speed, reference.speed_floor);
  StepProposal proposal{1e300, "none"};
  if (speed > 0) proposal = {constants.numerics.courant * constants.spacing / speed, "velocity"};
  for (const auto& [acceleration, limit] : {std::pair(reference.gravity_size, "gravity"), std::pair(state.wall_acceleration, "walls")}) {
    if (!(acceleration > 0)) continue;
    const double by_acceleration = constants.numerics.gravity_courant * std::sqrt(constants.spacing / acceleration);
    if (by_acceleration < proposal.seconds) proposal = {by_acceleration, limit};
  }
  if (constants.viscosity > 0) {
    const double h = constants.kernel.smoothing_length();
    const double by_viscosity = constants.numerics.viscous_courant * h * h / constants.viscosity;
    if (by_viscosity < proposal.seconds) proposal = {by_viscosity, "viscosity"};
  }
  if (proposal.seconds >= 1e300) proposal = {fastest > 0 ? reference.window_at_rest_in_frame : reference.window_at_rest, "rest"};
  return proposal;
}

template <int D>
std::optional<FluidExtent<D>> fluid_extent(const Reference<D>& reference, const State<D>& state) {
  if (reference.period.any()) return std::nullopt;
  FluidExtent<D> extent{Vector<D>::Constant(1e300), Vector<D>::Constant(-1e300)};
  for (const Vector<D>& x : state.position) {
    extent.low = extent.low.cwiseMin(x);
    extent.high = extent.high.cwiseMax(x);
  }
  extent.largest_speed = largest_speed(state.velocity);
  // A particle sees what is nearer than its support; a patch of a wall that it sees, and a gauge, sees as far again from there.
  extent.reach = 2 * reference.constants.faces.support() + reference.constants.spacing;
  return extent;
}

template StepProposal propose_step<2>(const Reference<2>&, double, const std::optional<double>&, const State<2>&);
template StepProposal propose_step<3>(const Reference<3>&, double, const std::optional<double>&, const State<3>&);
template std::optional<FluidExtent<2>> fluid_extent<2>(const Reference<2>&, const State<2>&);
template std::optional<FluidExtent<3>> fluid_extent<3>(const Reference<3>&, const State<3>&);

}  // namespace tern::fluid
