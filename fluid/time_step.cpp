// One step of incompressible SPH by projection (seed paper section II.A; Cummins & Rudman 1999), read from top to bottom. Each call
// is one equation, in the file of its name; its last arguments are what it writes.
//
//   begin_window     r* = r^n + dt/2 u^n,  u* = u^n + dt g;  neighbours at r*
//   see_surface      faces of walls and structure;  M, C, n;  free surface;  u* += dt nu lap u^n, noise damped;  div u*
//   solve_pressure   u* += dt a_dissipative;  pressure Poisson equation, and once more for what is left;  u** = u* - dt grad p / rho
//   end_window       u^{n+1} = u** + dt a_interface;  contacts;  r^{n+1} = r* + dt/2 u^{n+1};  shifting
//
// Drift, kick, drift: forces and incompressibility belong to the middle of the window, which makes the step time-symmetric
// for conservative forces. With the pressure solved at r^n + dt u^n instead, a wave of frequency omega loses
// omega^2 dt / 2 of its amplitude per unit of time.

#include <algorithm>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/timing.hpp"
#include "fluid/boundary/interface_of_ranks.hpp"
#include "fluid/boundary/interface_particles.hpp"
#include "fluid/boundary/interface_reaction.hpp"
#include "fluid/boundary/patches_of_ranks.hpp"
#include "fluid/boundary/wall_contact.hpp"
#include "fluid/correction_matrix.hpp"
#include "fluid/fluid.hpp"
#include "fluid/free_surface.hpp"
#include "fluid/gauges/totals.hpp"
#include "fluid/motion/advance.hpp"
#include "fluid/motion/escape.hpp"
#include "fluid/motion/prediction.hpp"
#include "fluid/motion/shifting.hpp"
#include "fluid/motion/speed_limit.hpp"
#include "fluid/motion/velocity_gradient.hpp"
#include "fluid/motion/velocity_noise.hpp"
#include "fluid/motion/viscosity.hpp"
#include "fluid/pressure/density_source.hpp"
#include "fluid/pressure/divergence.hpp"
#include "fluid/pressure/divergence_target.hpp"
#include "fluid/pressure/left_behind.hpp"
#include "fluid/pressure/pressure_gradient.hpp"
#include "fluid/pressure/pressure_poisson.hpp"
#include "fluid/pressure/pressure_solve.hpp"

namespace tern::fluid {

template <int D>
void Fluid<D>::begin_window(Ticks begin, Ticks duration) {
  ScopedTimer timer(timing_.neighbours);
  traffic_at_begin_ = Ranks::traffic();
  window_ = {seconds(begin), seconds(duration)};
  state_.time = begin;
  predict(reference_.gravity, window_, state_, prediction_);
  wrap_into_period(reference_.period, state_, prediction_);
  domain_.migrate(state_, prediction_);
  sort_in_rows(domain_.ranks(), reference_.constants.spacing, reference_.constants.kernel.support(), state_, prediction_, rows_);
  domain_.find_ghosts(state_, prediction_, rows_);
  find_neighbours<D>(reference_.constants, reference_.period, rows_, prediction_.position, neighbours_);
}

template <int D>
InterfaceParticles<D> Fluid<D>::see_surface(const Surface<D>& surface) {
  ScopedTimer timer(timing_.boundary);
  const Constants<D>& constants = reference_.constants;
  if (boundary_.walls.moving()) {
    state_.evaluations.moving_walls += static_cast<long>(boundary_.walls.faces().size());
    move_walls(constants, domain_.ranks(), window_, boundary_, state_);
  }
  state_.evaluations.structure_surface += static_cast<long>(surface.position.size());
  hold_walls<D>(domain_, constants, reference_.period, prediction_.position, surface.position, boundary_);
  set_surface(constants, surface, boundary_);
  see_boundary(constants, reference_.period, prediction_.position, boundary_, neighbours_);
  share_patches(domain_, constants, reference_.period, boundary_);
  sum_over_hidden_side(constants, domain_.ranks(), prediction_.position, prediction_.gravity, boundary_);

  correct_moments(neighbours_, boundary_, state_.particle_class, correction_);  // M, C, C^F
  classify_particles(constants, neighbours_, boundary_, correction_, state_);   // free surface, spray
  domain_.exchange_marks(state_.particle_class);
  by_axis<D>(state_.velocity, packed_.velocity);
  if (constants.viscosity > 0) {  // u* += dt nu lap u^n
    state_.evaluations.viscosity += static_cast<long>(state_.size());
    add_viscosity<D>(constants, window_.duration, neighbours_, boundary_, prediction_.position, packed_.velocity, prediction_.velocity);
  }
  compute_velocity_gradient(reference_.period, neighbours_, correction_, state_.particle_class, packed_);  // L
  if (constants.numerics.noise_damping > 0) {
    state_.evaluations.noise_damping += static_cast<long>(state_.size());
    packed_.with_gradient([&](auto&... values) { domain_.particles().update(values...); });
    damp_velocity_noise(reference_, window_.duration, neighbours_, state_.particle_class, packed_, prediction_.velocity);
  }
  compute_divergence(nullptr);  // div u*

  pressure_prepared_ = false;
  prediction_.unprojected_velocity.clear();
  InterfaceParticles<D> own =
      interface_particles(constants, state_, prediction_, boundary_, reports_divergence_ ? &divergence_ : nullptr, images_, at_structure_);
  own.is_enclosed = !state_.enclosed_past.size.empty();
  beside_structure_.list.clear();
  any_at_structure_ = false;
  if (boundary_.surface.size() == 0) return {};
  list_beside_structure(domain_, prediction_.position.size(), neighbours_, at_structure_, beside_structure_);
  find_interface_reaction(constants, domain_.ranks(), own, prediction_.position, prediction_.gravity, at_structure_, boundary_);
  balance_weight(constants, neighbours_, correction_, state_.particle_class, prediction_.gravity, at_structure_, boundary_);
  if (domain_.alone()) {
    any_at_structure_ = !at_structure_.empty();
    return own;
  }
  const std::vector<std::int64_t> counts = interface_counts(domain_.ranks(), at_structure_.size());
  first_at_structure_ = first_interface_particle(domain_.ranks(), counts);
  any_at_structure_ = std::any_of(counts.begin(), counts.end(), [](std::int64_t count) { return count > 0; });
  return gather(domain_.ranks(), counts, std::move(own));
}

template <int D>
void Fluid<D>::prepare_pressure() {
  ScopedTimer timer(timing_.assembly);
  if (reference_.constants.numerics.density_relaxation > 0) {
    state_.evaluations.density_source += static_cast<long>(state_.size());
    compute_density_source(reference_, window_.duration, packed_, neighbours_, boundary_, correction_, state_.particle_class,
                           density_source_);
  }
  find_enclosed_fluid(domain_, neighbours_, correction_, state_, system_);
  set_divergence_target(window_.duration, neighbours_, beside_structure_, packed_, density_source_, divergence_target_);
  assemble_pressure_matrix(reference_.constants, state_, neighbours_, boundary_, correction_, system_.matrix);
  pressure_prepared_ = true;
}

template <int D>
InterfacePressure<D> Fluid<D>::solve_pressure(const InterfaceCondition<D>& load) {
  const Constants<D>& constants = reference_.constants;
  const bool first = load.surface_velocity.empty();  // coupling iteration of this window
  if (!pressure_prepared_) prepare_pressure();
  system_.answer_tolerance = load.answer_tolerance;
  {
    ScopedTimer timer(timing_.assembly);
    if (first && load.repeats) prediction_.unprojected_velocity = prediction_.velocity;
    if (!first) return_to_unprojected_velocity(load.surface_velocity);
    const bool pushed = push(load.force);  // u* += dt a_dissipative
    if (pushed || !first) {
      // Elsewhere nothing has changed since see_surface().
      compute_divergence(&beside_structure_.list);
    }
    if (first)
      complete_pressure_matrix(constants, domain_.ranks(), load, neighbours_, boundary_, correction_, prediction_, at_structure_, state_,
                               system_);
    assemble_pressure_source(constants, window_.duration, load, state_, prediction_, boundary_, at_structure_, divergence_,
                             divergence_target_, system_);
  }
  {
    ScopedTimer timer(timing_.pressure_solve);
    if (first) {
      prepare_pressure_solve(constants, domain_, neighbours_, state_.particle_class, prediction_.position, at_structure_, system_);
      if (system_.sealed.any())
        account_for_enclosed_fluid(reference_, window_, boundary_, system_.source, system_.beside_bodies, system_.swept, system_.sealed,
                                   state_);
    }
    solve_pressure_poisson(constants, domain_, window_, prediction_.position, at_structure_, any_at_structure_, state_, system_);
  }
  drive_out_what_is_left(load.reference_pressure, first);
  ScopedTimer timer(timing_.correction);
  apply_pressure_gradient(reference_, window_.duration, neighbours_, boundary_, correction_, state_, &at_structure_, prediction_.velocity,
                          &prediction_.velocity);  // u** at the structure
  velocity_complete_ = false;
  InterfacePressure<D> pressure;
  for (int i : at_structure_) {
    pressure.pressure.push_back(state_.pressure[i]);
    pressure.velocity.push_back(prediction_.velocity[i]);
  }
  if (boundary_.surface.size() == 0) return pressure;
  return gather(domain_.ranks(), std::move(pressure));
}

template <int D>
void Fluid<D>::drive_out_what_is_left(const std::vector<double>& reference_pressure, bool first) {
  const auto find_left = [&](std::vector<Vector<D>>& projected, std::vector<Vector<D>>* order, std::vector<double>& left) {
    ScopedTimer timer(timing_.correction);
    projected = prediction_.velocity;
    apply_pressure_gradient(reference_, window_.duration, neighbours_, boundary_, correction_, state_, nullptr, projected, order);
    if (foretells_interface_ && !at_structure_.empty()) {  // as it will be with the force of the interface
      std::vector<Vector<D>>* const unordered = nullptr;
      apply_pressure_gradient(reference_, window_.duration, neighbours_, boundary_, correction_, state_, &at_structure_, projected,
                              unordered);
      add_interface_reaction(reference_.constants, window_.duration, boundary_, state_, at_structure_, projected);
    }
    domain_.particles().update(projected);
    fluid::compute_divergence<D>(reference_.period, neighbours_, boundary_, correction_, state_.particle_class, projected, nullptr,
                                 packed_.velocity, projected_divergence_);
    left.assign(system_.matrix.rows(), 0);
    assemble_left_behind(reference_.constants, window_.duration, state_.particle_class, projected_divergence_, divergence_target_, left);
    if (foretells_interface_) {
      system_.yielding.subtract_motion(reference_pressure, boundary_, at_structure_, state_.pressure, left);
    } else {
      for (const int i : beside_structure_.list) left[i] = 0;
    }
    if (system_.beside_bodies.any()) system_.beside_bodies.subtract_means(left);  // the first solve has closed the sum over them
  };
  find_left(projected_velocity_, nullptr, system_.left_behind);
  {
    ScopedTimer timer(timing_.pressure_solve);
    solve_for_correction(reference_.constants, domain_, window_, prediction_.position, at_structure_, any_at_structure_, state_, system_);
    add_correction(system_, state_);
  }
  if (first) {  // The share is that of the window, so that its answers are linear.
    ordering_velocity_.assign(state_.size(), Vector<D>::Zero());
    find_left(corrected_velocity_, &ordering_velocity_, system_.still_left);
    find_best_share(domain_.ranks(), system_);
  }
  keep_share(system_, state_);
  velocity_known_ = first;
}

template <int D>
void Fluid<D>::complete_velocity() {
  ScopedTimer timer(timing_.correction);
  velocity_complete_ = true;
  if (!velocity_known_)
    return apply_pressure_gradient(reference_, window_.duration, neighbours_, boundary_, correction_, state_, nullptr, prediction_.velocity,
                                   &prediction_.velocity);  // u** elsewhere
  // The same, for the gradient without its ordering part is linear: what the share of the correction makes of the two that are known.
  // Order is kept by the pressure with the correction in full.
  parallel_for(static_cast<std::ptrdiff_t>(state_.size()), [&](std::ptrdiff_t i) {
    if (boundary_.sees_structure(i)) return;
    const Vector<D> change = corrected_velocity_[i] - projected_velocity_[i];
    prediction_.velocity[i] = projected_velocity_[i] + share_taken(system_, i) * change + ordering_velocity_[i];
  });
}

template <int D>
void Fluid<D>::end_window(const InterfaceForce<D>& force) {
  if (!velocity_complete_) complete_velocity();
  ScopedTimer timer(timing_.correction);
  const Constants<D>& constants = reference_.constants;
  push(force.force);  // u^{n+1} = u** + dt a_interface
  system_.swept.remember(window_.duration, boundary_.surface, system_.beside_bodies, state_);
  system_.swept.watch_lag(constants, window_, system_.beside_bodies, state_);
  settle_wall_contacts(constants, window_.duration, boundary_, prediction_.position, prediction_.velocity, state_.stopped);
  domain_.forget_ghosts(state_);
  const Vector<D> of_frame = frame_velocity().value_or(Vector<D>::Zero());
  state_.body_speed = 0;
  state_.body_speed_in_frame = 0;
  // Out of reach are bodies two supports off, of which nothing more is known: they may be at rest, and come nearer by that in a window.
  if (reference_.has_bodies && boundary_.surface.size() == 0)
    state_.body_speed_in_frame = constants.numerics.courant * constants.spacing / (2 * constants.faces.support()) * of_frame.norm();
  for (std::size_t k = 0; k < boundary_.surface.size(); ++k) {
    const Vector<D>& velocity = boundary_.surface.velocity[k];
    if (boundary_.surface_rows.wet[k] > 0) state_.body_speed = std::max(state_.body_speed, velocity.norm());
    state_.body_speed_in_frame = std::max(state_.body_speed_in_frame, (velocity - of_frame).norm());
  }
  check_speed(domain_.ranks(), window_, prediction_, boundary_.surface.velocity, state_);
  check_volume(window_, boundary_.surface.size() == 0 ? 0 : filling().volume_drift().known(), state_);
  state_.potential -= work_of_gravity(constants.mass, window_.duration, state_, prediction_);
  advance(window_.duration, prediction_, state_);  // r^{n+1} = r* + dt/2 u^{n+1}
  move_off_faces(constants, boundary_, prediction_.position, state_.position);
  if (constants.numerics.shifting > 0) {
    state_.evaluations.shifting += static_cast<long>(state_.size());
    shift_particles(constants, window_.duration, neighbours_, boundary_, correction_, state_.particle_class, packed_, state_.id,
                    prediction_.position, state_.position, state_.velocity);
  }
  state_.leaked +=
      count_leaks(constants.spacing, window_.duration, boundary_.seen_walls(), boundary_.wall_rows, prediction_.position, state_.position);
  state_.leaked +=
      count_leaks(constants.spacing, window_.duration, boundary_.surface, boundary_.surface_rows, prediction_.position, state_.position);
  remove_escaped(reference_, state_);
  state_.time += to_ticks(window_.duration);
  Traffic::for_each_field([](const char*, auto& sum, auto now, auto begin) { sum += now - begin; }, traffic_, Ranks::traffic(),
                          traffic_at_begin_);
  ++windows_;
  if (!domain_.alone()) set_totals();
  check_that_some_are_left(window_, particles());
}

template <int D>
void Fluid<D>::pass_window() {
  see_surface({});
  solve_pressure({});
  end_window({});
}

template <int D>
void Fluid<D>::compute_divergence(const std::vector<int>* only) {
  domain_.particles().update(prediction_.velocity);
  fluid::compute_divergence<D>(reference_.period, neighbours_, boundary_, correction_, state_.particle_class, prediction_.velocity, only,
                               packed_.velocity, divergence_);
}

template <int D>
bool Fluid<D>::push(const std::vector<Vector<D>>& force) {
  bool any = false;
  for (std::size_t m = 0; m < force.size(); ++m) {
    any = any || force[m].squaredNorm() > 0;
    const std::size_t own = m - static_cast<std::size_t>(first_at_structure_);  // too large before the first
    if (own >= at_structure_.size()) continue;
    prediction_.velocity[at_structure_[own]] += (window_.duration / reference_.constants.mass) * force[m];
  }
  return any;
}

template <int D>
void Fluid<D>::return_to_unprojected_velocity(const std::vector<Vector<D>>& surface_velocity) {
  if (domain_.ranks().any(prediction_.unprojected_velocity.size() != prediction_.velocity.size()))
    throw EndOfModel("The coupler asks for the pressure of a window once more without having said so (InterfaceCondition.repeats).");
  prediction_.velocity = prediction_.unprojected_velocity;
  set_surface_velocity(surface_velocity, at_structure_, boundary_);
}

#define TERN_INSTANTIATE(D)                                                             \
  template void Fluid<D>::begin_window(Ticks, Ticks);                                   \
  template InterfaceParticles<D> Fluid<D>::see_surface(const Surface<D>&);              \
  template void Fluid<D>::prepare_pressure();                                           \
  template InterfacePressure<D> Fluid<D>::solve_pressure(const InterfaceCondition<D>&); \
  template void Fluid<D>::drive_out_what_is_left(const std::vector<double>&, bool);     \
  template void Fluid<D>::complete_velocity();                                          \
  template void Fluid<D>::end_window(const InterfaceForce<D>&);                         \
  template void Fluid<D>::pass_window();                                                \
  template void Fluid<D>::compute_divergence(const std::vector<int>*);                  \
  template bool Fluid<D>::push(const std::vector<Vector<D>>&);                          \
  template void Fluid<D>::return_to_unprojected_velocity(const std::vector<Vector<D>>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
