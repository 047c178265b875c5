// The coupling of one window (seed paper section II.C; docs/THEORY.md, section 3), read from top to bottom.

#include "coupler/window.hpp"

#include <algorithm>
#include <utility>

#include "base/step_control.hpp"
#include "coupler/acceleration/agreement.hpp"
#include "coupler/acceleration/coupling_iteration.hpp"
#include "coupler/acceleration/flat.hpp"
#include "coupler/interface_condition.hpp"
#include "coupler/interface_force.hpp"
#include "coupler/schemes/scheme.hpp"
#include "coupler/schemes/velocity_divergence_mitigation.hpp"

namespace tern::coupler {

template <int D>
WindowProposal Coupler<D>::propose(double of_fluid, const std::string& limit) const {
  const double shared = setup_.window_share * of_fluid, last = state_.observations.duration;
  const double of_surface = last > 0 ? std::max(longest_window(setup_.spacing, state_.motion, last), StepControl::fastest_shortening * last)
                                     : setup_.first_window;
  if (setup_.window_of_loads < std::min(of_surface, shared)) return {setup_.window_of_loads, "loads"};
  return of_surface < shared ? WindowProposal{of_surface, "interface"} : WindowProposal{shared, limit};
}

template <int D>
void Coupler<D>::run_window(Participants<D>& participants, Ticks begin, Ticks duration) {
  // Opening: the fluid finds its neighbours while the structure predicts where its surface will be.
  participants.begin_window(begin, duration);
  const Surface<D> surface = participants.predict_surface(begin, duration);
  watch_meetings(setup_.meetable, seconds(begin) + 0.5 * seconds(duration), surface, state_.meeting);
  if (const auto energies = participants.energies()) watch_energy(setup_, seconds(begin), *energies, state_.observations);
  if (const auto extent = participants.extent(); extent && out_of_reach(*extent, surface, duration)) {
    pass_window(seconds(begin), seconds(duration), surface);
    participants.pass_window();
    participants.apply(surface_load());
    return;
  }

  // First exchange: the fluid solves its pressure beside the predicted surface.
  InterfacePressure<D> pressure =
      participants.solve_pressure(first_exchange(seconds(begin), seconds(duration), surface, participants.see_surface(surface)));

  // Coupling iterations: both sides again, until the load that the fluid answers is the load that the structure has moved under.
  while (const SurfaceLoad<D>* load = next_load(pressure)) {
    std::vector<Vector<D>> velocity = participants.respond(*load);
    if (accepts(velocity)) break;
    if (const SurfaceLoad<D>* better = accelerated_load()) velocity = participants.respond(*better);
    pressure = participants.solve_pressure(repeat_exchange(std::move(velocity)));
  }

  // Last exchange: the forces of both sides. The fluid is told first, for it computes longer.
  participants.end_window(last_exchange(pressure));
  participants.apply(surface_load());
}

template <int D>
bool out_of_reach(const FluidExtent<D>& fluid, const Surface<D>& surface, Ticks duration) {
  const double reach = fluid.reach + 0.5 * seconds(duration) * fluid.largest_speed;  // the pressure is solved halfway
  return std::none_of(surface.position.begin(), surface.position.end(),
                      [&](const Vector<D>& x) { return (x - x.cwiseMax(fluid.low).cwiseMin(fluid.high)).squaredNorm() <= reach * reach; });
}

template <int D>
void Coupler<D>::pass_window(double begin, double duration, const Surface<D>& surface) {
  window_.begin = begin;
  window_.duration = duration;
  window_.audit = {};
  find_answer(setup_, surface, state_, window_);
  begin_iterations(setup_, window_, state_);
  window_.load.force.assign(surface.position.size(), Vector<D>::Zero());
  state_.load = window_.load;
  state_.contact.force.clear();
  state_.answered_change.clear();
  state_.motion = {};
  state_.observations.duration = duration;
  state_.surface_velocity = surface.velocity;
  for (LoadAlternation& alternation : state_.observations.alternation) alternation = {};
  ++state_.evaluations.windows_without_exchange;
  state_.totals.add(window_.audit, window_.iterations, window_.agreed, window_.duration);
}

namespace {

/// What is known before the pressure solve: explicit forces on both sides, and how the surface yields.
template <int D>
void set_condition(const Setup<D>& setup, Workspace<D>& window, Evaluations& evaluations) {
  window.load.force.assign(window.surface.position.size(), Vector<D>::Zero());
  window.condition.force.assign(window.particles.id.size(), Vector<D>::Zero());
  window.audit = {};
  if (setup.scheme.add_explicit_forces) setup.scheme.add_explicit_forces(setup, window, evaluations);
  add_velocity_divergence_mitigation(setup, window, evaluations);
  set_robin_condition(setup, window);
  window.audit.particles = static_cast<int>(window.particles.id.size());
  window.audit.pairs = static_cast<int>(window.pairs.all_pairs().size());
}

/// What the fluid answers the present iteration with, on top of the explicit forces: pressure and contacts.
template <int D>
void answer(const Setup<D>& setup, const InterfacePressure<D>& pressure, Workspace<D>& window, Evaluations& evaluations) {
  window.particle_force.force.assign(window.particles.id.size(), Vector<D>::Zero());
  add_pressure(setup, pressure, window, evaluations);
  settle_contacts(setup, pressure, window);
}

}  // namespace

template <int D>
const InterfaceCondition<D>& Coupler<D>::first_exchange(double begin, double duration, const Surface<D>& surface,
                                                        InterfaceParticles<D> particles) {
  window_.begin = begin;
  window_.duration = duration;
  window_.surface = surface;
  window_.particles = std::move(particles);
  window_.pairs.find(window_.particles, surface);
  window_.share = uniform_load<D>(setup_.scheme, window_.pairs);
  window_.seen_share = window_.pairs.seen_share();

  // The structure makes its first iteration under the load of the last window.
  window_.assumed_load = state_.load;
  window_.assumed_load.force.resize(surface.position.size(), Vector<D>::Zero());
  window_.assumed_contact = state_.contact;
  window_.assumed_contact.force.resize(surface.position.size(), Vector<D>::Zero());
  find_answer(setup_, surface, state_, window_);
  begin_iterations(setup_, window_, state_);
  window_.velocity_at_end = surface.velocity;

  window_.condition.surface_velocity.clear();
  window_.condition.answered_change.clear();
  if (window_.particles.is_enclosed) window_.condition.answered_change.swap(state_.answered_change);
  state_.answered_change.clear();
  window_.condition.repeats = setup_.iterates && setup_.coupling.max_iterations > 1;
  window_.condition.answer_tolerance = setup_.learns && window_.condition.repeats ? answer_tolerance : 0;
  set_condition(setup_, window_, state_.evaluations);
  return window_.condition;
}

template <int D>
const SurfaceLoad<D>* Coupler<D>::next_load(const InterfacePressure<D>& pressure) {
  if (!setup_.iterates) return nullptr;
  ++window_.iterations;
  const SurfaceLoad<D> explicit_part = window_.load;
  const WindowAudit audit = window_.audit;
  answer(setup_, pressure, window_, state_.evaluations);
  const SurfaceLoad<D>& load = window_.answered_load = std::exchange(window_.load, explicit_part);
  window_.answered_audit = std::exchange(window_.audit, audit);
  if (setup_.learns) {
    if (window_.iterations == 1) return &window_.answered_load;  // accepts() tests it
    window_.agreed = disagreement(setup_, state_, window_, load, window_.surface.velocity).agrees();
    if (window_.agreed) return nullptr;
  }
  const bool is_last = note_iteration(state_, window_);
  window_.agreed = state_.fixed_point.converged();
  if (is_last) return nullptr;
  if (setup_.learns) return &window_.answered_load;
  assume_next_load(state_, window_);
  return &window_.assumed_load;
}

template <int D>
bool Coupler<D>::accepts(const std::vector<Vector<D>>& velocity) {
  window_.velocity_at_end = velocity;
  if (!setup_.learns) return false;
  const bool is_first = window_.iterations == 1;
  if (is_first) {
    state_.response.learn(setup_, window_, velocity);
    if (window_.particles.is_enclosed) {
      state_.answered_change = velocity;
      for (std::size_t k = 0; k < velocity.size(); ++k) state_.answered_change[k] -= window_.surface.velocity[k];
    }
  }
  window_.agreed = disagreement(setup_, state_, window_, window_.answered_load, velocity).agrees();
  if (window_.agreed || setup_.coupling.max_iterations == 1) return true;
  if (is_first) note_iteration(state_, window_);
  return false;
}

template <int D>
const SurfaceLoad<D>* Coupler<D>::accelerated_load() {
  if (!setup_.learns) return nullptr;  // next_load() has been it
  if (window_.iterations > 1) {
    assume_next_load(state_, window_);
    return &window_.assumed_load;
  }
  ++state_.evaluations.coupling_iterations;
  window_.assumed_load = window_.answered_load;
  window_.assumed_contact = window_.contact;
  return nullptr;
}

template <int D>
const InterfaceCondition<D>& Coupler<D>::repeat_exchange(std::vector<Vector<D>> surface_velocity) {
  window_.velocity_at_end = window_.surface.velocity = window_.condition.surface_velocity = std::move(surface_velocity);
  window_.condition.answered_change.clear();
  set_condition(setup_, window_, state_.evaluations);
  return window_.condition;
}

template <int D>
const InterfaceForce<D>& Coupler<D>::last_exchange(const InterfacePressure<D>& pressure) {
  if (window_.iterations == 0) {
    answer(setup_, pressure, window_, state_.evaluations);
  } else {  // next_load() has asked for it
    window_.load = window_.answered_load;
    window_.audit = window_.answered_audit;
  }
  audit_balance(window_);
  watch_load(setup_, window_, state_.observations);
  state_.totals.add(window_.audit, window_.iterations, window_.agreed && !window_.contacts_are_given, window_.duration);

  state_.load = window_.load;
  state_.contact = window_.contact;
  if (window_.audit.pairs > 0)
    follow_motion(setup_.properties.body, state_.surface_velocity, window_.velocity_at_end, window_.surface.area,
                  state_.observations.duration, window_.duration, state_.motion);
  else
    state_.motion = {};  // nobody sees it
  state_.surface_velocity = window_.velocity_at_end;
  state_.observations.duration = window_.duration;
  state_.observations.surface_area = 0;
  for (double area : window_.surface.area) state_.observations.surface_area += area;
  return window_.particle_force;
}

template <int D>
Vector<D> Coupler<D>::total_load(std::uint32_t body) const {
  Vector<D> sum = Vector<D>::Zero();
  for (std::size_t k = 0; k < state_.load.force.size(); ++k)
    if (setup_.properties.body[k] == body) sum += state_.load.force[k];
  return sum;
}

template class Coupler<2>;
template class Coupler<3>;
template bool out_of_reach<2>(const FluidExtent<2>&, const Surface<2>&, Ticks);
template bool out_of_reach<3>(const FluidExtent<3>&, const Surface<3>&, Ticks);

}  // namespace tern::coupler
