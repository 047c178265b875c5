// One step of incompressible SPH by projection (seed paper section II.A; Cummins & Rudman 1999), read from top to bottom:
//
//   begin_window     r* = r^n + dt/2 u^n,  u* = u^n + dt g;  neighbours at r*
//   see_surface      faces of walls and structure;  M, C, n;  free surface;  u* += dt nu lap u^n, noise damped;  div u*
//   solve_pressure   u* += dt a_dissipative;  pressure Poisson equation;  u** = u* - dt grad p / rho
//   end_window       u^{n+1} = u** + dt a_interface;  contacts;  r^{n+1} = r* + dt/2 u^{n+1};  shifting
//
// Drift, kick, drift: forces and incompressibility belong to the middle of the window, which makes the step time-symmetric
// for conservative forces. With the pressure solved at r^n + dt u^n instead, a wave of frequency omega loses
// omega^2 dt / 2 of its amplitude per unit of time.

#include <cmath>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/timing.hpp"
#include "fluid/boundary/mirror_images.hpp"
#include "fluid/fluid.hpp"
#include "sph/convex_corner.hpp"

namespace tern::fluid {

template <int D>
void Fluid<D>::begin_window(Ticks begin, Ticks duration) {
  begin_s_ = seconds(begin);
  duration_s_ = seconds(duration);
  state_.time = begin;
  ScopedTimer timer(timing_.neighbours);
  bulk_speed_ = largest_bulk_speed();
  predict();
  if (period_.any()) wrap_into_period();
  sort_by_cell();
  find_neighbours<D>(constants_, period_, grid_, contents_, predicted_position_, neighbours_);
}

template <int D>
InterfaceParticles<D> Fluid<D>::see_surface(const Surface<D>& surface) {
  ScopedTimer timer(timing_.boundary);
  if (walls_.moving()) {
    evaluations_.moving_walls += static_cast<long>(walls_.faces().size());
    walls_.move_over(begin_s_, duration_s_);
    wall_finder_.fill(walls_.faces(), constants_.faces.support());
    space_before_walls_.assign(walls_.faces().size(), -1);
    seen_walls_.reset(walls_.faces());
  }
  surface_.position = surface.position;
  surface_.velocity = surface.velocity;
  surface_.normal = surface.normal;
  surface_.area = surface.area;
  surface_.normal_acceleration.assign(surface.position.size(), 0);
  surface_.two_sided.assign(surface.position.size(), 1);
  surface_finder_.fill(surface_, constants_.faces.support());
  evaluations_.structure_surface += static_cast<long>(surface.position.size());
  seen_walls_.clip(walls_.faces(), wall_finder_, surface_);

  see_faces<D>(predicted_position_, seen_walls_.faces(), wall_finder_, wall_rows_);
  see_faces<D>(predicted_position_, surface_, surface_finder_, surface_rows_);
  if (!surface_rows_.face.empty()) {
    hide_walls_behind_structure();
    cut_pairs_through_faces<D>(constants_, period_, predicted_position_, surface_, surface_rows_, true, neighbours_);
    find_covered_faces<D>(surface_, walls_.faces(), wall_finder_, 0.5 * constants_.spacing, covered_faces_);
  }
  if (walls_.any_two_sided())
    cut_pairs_through_faces<D>(constants_, period_, predicted_position_, seen_walls_.faces(), wall_rows_, false, neighbours_);
  leave_out_dry_walls<D>(constants_, predicted_position_, seen_walls_.faces(), walls_.faces(), wall_finder_, space_before_walls_, surface_,
                         surface_finder_, wall_rows_);
  set_wall_sums<D>(constants_, predicted_position_, gravity_, seen_walls_.faces(), wall_rows_, boundary_);
  add_surface_sums<D>(constants_, predicted_position_, gravity_, surface_, surface_finder_, covered_faces_, surface_rows_, boundary_);
  correct_moments();
  mark_free_surface();
  if (constants_.viscosity > 0) apply_viscosity();
  damp_velocity_noise();
  compute_divergence();

  pressure_prepared_ = false;
  unprojected_velocity_.clear();
  band_.clear();
  InterfaceParticles<D> band;
  for (std::size_t i = 0; i < state_.size(); ++i) {
    if (surface_rows_.count[i] == 0) continue;
    band_.push_back(static_cast<int>(i));
    band.id.push_back(state_.id[i]);
    band.position.push_back(predicted_position_[i]);
    band.velocity.push_back(predicted_velocity_[i]);
    band.mass.push_back(constants_.mass);
    band.volume.push_back(constants_.volume);
    if (reports_divergence_) band.divergence.push_back(divergence_[i]);
    if (wall_rows_.count[i] > 0) add_images(band);
  }
  if (!band_.empty())
    for (std::size_t k = 0; k < covered_faces_.size(); ++k)
      if (covered_faces_[k]) band.covered.push_back(static_cast<std::uint32_t>(k));
  return band;
}

template <int D>
void Fluid<D>::add_images(InterfaceParticles<D>& band) {
  const int i = band_.back();
  mirror_in_walls<D>(seen_walls_.faces(), wall_rows_, i, predicted_position_[i], 0.25 * constants_.spacing, images_);
  const double support = constants_.faces.support();
  for (const Vector<D>& image : images_) {
    bool near = false;
    for (int entry = surface_rows_.begin[i]; !near && entry < surface_rows_.begin[i] + surface_rows_.count[i]; ++entry)
      near = (image - surface_.position[surface_rows_.face[entry]]).squaredNorm() < support * support;
    if (!near) continue;
    band.image_of.push_back(static_cast<std::uint32_t>(band.id.size() - 1));
    band.image_position.push_back(image);
  }
}

template <int D>
void Fluid<D>::prepare_pressure() {
  ScopedTimer timer(timing_.assembly);
  if (constants_.numerics.density_relaxation > 0) compute_density_source();
  assemble_pressure_matrix();
  pressure_prepared_ = true;
}

template <int D>
InterfacePressure<D> Fluid<D>::solve_pressure(const InterfaceCondition<D>& load) {
  const bool first = load.surface_velocity.empty();
  if (!pressure_prepared_) prepare_pressure();
  {
    ScopedTimer timer(timing_.assembly);
    bool changed = false;
    if (first) {
      if (load.repeats) unprojected_velocity_ = predicted_velocity_;
    } else {
      if (unprojected_velocity_.size() != state_.size())
        throw NumericalFailure("The coupler asks for the pressure of a window once more without having said so (DissipativeLoad.repeats).");
      predicted_velocity_ = unprojected_velocity_;  // what the last trial has done to the fluid is undone
      move_surface_at(load.surface_velocity);
      changed = true;
    }
    for (std::size_t m = 0; m < load.force.size(); ++m) {
      predicted_velocity_[band_[m]] += (duration_s_ / constants_.mass) * load.force[m];
      changed = changed || load.force[m].squaredNorm() > 0;
    }
    if (changed) compute_divergence();
    if (first) assemble_pressure_matrix_at_structure(load);
    assemble_pressure_source(load);
  }
  {
    ScopedTimer timer(timing_.pressure_solve);
    if (first) prepare_pressure_solve();
    solve_pressure_poisson();
  }
  ScopedTimer timer(timing_.correction);
  apply_pressure_gradient(Where::at_structure);
  velocity_complete_ = false;
  InterfacePressure<D> band;
  for (int i : band_) {
    band.pressure.push_back(state_.pressure[i]);
    band.velocity.push_back(predicted_velocity_[i]);
  }
  return band;
}

template <int D>
void Fluid<D>::complete_velocity() {
  ScopedTimer timer(timing_.correction);
  apply_pressure_gradient(Where::elsewhere);
  velocity_complete_ = true;
}

template <int D>
void Fluid<D>::end_window(const InterfaceForce<D>& force) {
  if (!velocity_complete_) complete_velocity();
  ScopedTimer timer(timing_.correction);
  for (std::size_t m = 0; m < force.force.size(); ++m) predicted_velocity_[band_[m]] += (duration_s_ / constants_.mass) * force.force[m];
  settle_wall_contacts();
  check_speed();
  check_volume();
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  potential_ -= ordered_reduce(n, 0.0, [&](std::ptrdiff_t i) {
    return 0.5 * constants_.mass * duration_s_ * gravity_[i].dot(state_.velocity[i] + predicted_velocity_[i]);
  });
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    state_.velocity[i] = predicted_velocity_[i];
    state_.position[i] = predicted_position_[i] + 0.5 * duration_s_ * predicted_velocity_[i];
  }
  shift_particles();
  count_leaks(seen_walls_.faces(), wall_rows_);
  count_leaks(surface_, surface_rows_);
  remove_escaped();
  state_.time += to_ticks(duration_s_);
}

template <int D>
void Fluid<D>::pass_window() {
  see_surface({});
  solve_pressure({});
  end_window({});
}

template <int D>
std::optional<FluidExtent<D>> Fluid<D>::extent() const {
  if (period_.any()) return std::nullopt;
  FluidExtent<D> extent{state_.position[0], state_.position[0]};
  for (const Vector<D>& x : state_.position) {
    extent.low = extent.low.cwiseMin(x);
    extent.high = extent.high.cwiseMax(x);
  }
  extent.largest_speed = largest_speed();
  // A particle sees what is nearer than its support; a patch of a wall that it sees, and a gauge, sees as far again from there.
  extent.reach = 2 * constants_.faces.support() + constants_.spacing;
  return extent;
}

template <int D>
void Fluid<D>::predict() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  gravity_.resize(n);
  predicted_velocity_.resize(n);
  predicted_position_.resize(n);
  const double middle = begin_s_ + 0.5 * duration_s_;
  const Vector<D> everywhere = gravity_at(middle, Vector<D>::Zero());
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    predicted_position_[i] = state_.position[i] + 0.5 * duration_s_ * state_.velocity[i];
    gravity_[i] = everywhere;
  }
  // One expression cannot be evaluated by two threads.
  if (!uniform_gravity_)
    for (std::ptrdiff_t i = 0; i < n; ++i) gravity_[i] = gravity_at(middle, predicted_position_[i]);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) predicted_velocity_[i] = state_.velocity[i] + duration_s_ * gravity_[i];
}

template <int D>
void Fluid<D>::wrap_into_period() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const Vector<D> shift = period_.into(predicted_position_[i]);
    predicted_position_[i] += shift;
    state_.position[i] += shift;
  }
}

template <int D>
void Fluid<D>::sort_by_cell() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  struct Box {
    Vector<D> low, high;
  };
  const Box box = ordered_fold(
      n, Box{predicted_position_[0], predicted_position_[0]},
      [&](std::ptrdiff_t i) {
        return Box{predicted_position_[i], predicted_position_[i]};
      },
      [](const Box& a, const Box& b) {
        return Box{a.low.cwiseMin(b.low), a.high.cwiseMax(b.high)};
      });
  grid_.reset(box.low, box.high, constants_.kernel.support());
  contents_.template fill<D>(grid_, predicted_position_);
  const auto reorder = [&](auto& values, auto& scratch) {
    scratch.resize(n);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
    for (std::ptrdiff_t i = 0; i < n; ++i) scratch[i] = values[contents_.order[i]];
    values.swap(scratch);
  };
  for (auto* values : {&state_.position, &state_.velocity, &predicted_position_, &predicted_velocity_, &gravity_})
    reorder(*values, sorted_vectors_);
  reorder(state_.pressure, sorted_numbers_);
  reorder(state_.id, sorted_labels_);
  reorder(state_.free_surface, sorted_marks_);
  // Particles now lie in cell order, so the cell lists are the identity.
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) contents_.order[i] = static_cast<int>(i);
}

template <int D>
void Fluid<D>::hide_walls_behind_structure() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (surface_rows_.count[i] == 0 || wall_rows_.count[i] == 0) continue;
    int kept = 0;
    for (int entry = wall_rows_.begin[i]; entry < wall_rows_.begin[i] + wall_rows_.count[i]; ++entry) {
      const Vector<D>& wall = seen_walls_.faces().position[wall_rows_.face[entry]];
      bool hidden = false;
      for (int s = surface_rows_.begin[i]; !hidden && s < surface_rows_.begin[i] + surface_rows_.count[i]; ++s)
        hidden = patch_separates(surface_, surface_rows_.face[s], predicted_position_[i], wall);
      if (hidden) continue;
      wall_rows_.face[wall_rows_.begin[i] + kept++] = wall_rows_.face[entry];
    }
    wall_rows_.count[i] = kept;
  }
}

template <int D>
void Fluid<D>::move_surface_at(const std::vector<Vector<D>>& velocity) {
  for (int i : band_)
    for (int entry = surface_rows_.begin[i]; entry < surface_rows_.begin[i] + surface_rows_.count[i]; ++entry) {
      const int k = surface_rows_.face[entry];
      boundary_.flux[i] += surface_rows_.weight[entry] * surface_.normal[k].dot(velocity[k] - surface_.velocity[k]);
    }
  surface_.velocity = velocity;
}

template <int D>
void Fluid<D>::count_leaks(const Faces<D>& faces, const FaceRows& rows) {
  // A particle that saw the front of a patch and now stands a quarter spacing behind it has gone through.
  const double depth = 0.25 * constants_.spacing;
  leaked_ += ordered_reduce(static_cast<std::ptrdiff_t>(state_.size()), std::size_t{0}, [&](std::ptrdiff_t i) -> std::size_t {
    if ((state_.position[i] - predicted_position_[i]).squaredNorm() < depth * depth) return 0;
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry)
      if (patch_separates(faces, rows.face[entry], predicted_position_[i], state_.position[i], depth)) return 1;
    return 0;
  });
}

template <int D>
void Fluid<D>::remove_escaped() {
  const auto outside = [&](const Vector<D>& x) {
    return (x.array() < domain_min_.array()).any() || (x.array() > domain_max_.array()).any();
  };
  const std::size_t escaped =
      ordered_reduce(static_cast<std::ptrdiff_t>(state_.size()), std::size_t{0}, [&](std::ptrdiff_t i) -> std::size_t {
        Vector<D>& x = state_.position[i];
        if (period_.any()) x += period_.into(x);
        return outside(x);
      });
  if (escaped == 0) return;
  removed_ += escaped;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < state_.size(); ++i) {
    if (outside(state_.position[i])) continue;
    if (kept != i) {
      state_.position[kept] = state_.position[i];
      state_.velocity[kept] = state_.velocity[i];
      state_.pressure[kept] = state_.pressure[i];
      state_.id[kept] = state_.id[i];
      state_.free_surface[kept] = state_.free_surface[i];
      flag_[kept] = flag_[i];
    }
    ++kept;
  }
  if (kept == 0)
    throw NumericalFailure(
        fmt::format("All fluid has left the domain by t = {:.6g} s; enlarge [domain] or close the walls.", begin_s_ + duration_s_));
  for (auto* values : {&state_.position, &state_.velocity}) values->resize(kept);
  state_.pressure.resize(kept);
  state_.id.resize(kept);
  state_.free_surface.resize(kept);
  flag_.resize(kept);
}

template <int D>
StepProposal Fluid<D>::propose_step() const {
  const double speed = std::max({largest_speed(), walls_.largest_speed(), speed_floor_});
  StepProposal proposal{1e300, "none"};
  if (speed > 0) proposal = {constants_.numerics.courant * constants_.spacing / speed, "velocity"};
  if (gravity_size_ > 0) {
    const double by_gravity = constants_.numerics.gravity_courant * std::sqrt(constants_.spacing / gravity_size_);
    if (by_gravity < proposal.seconds) proposal = {by_gravity, "gravity"};
  }
  if (constants_.viscosity > 0) {
    const double h = constants_.kernel.smoothing_length();
    const double by_viscosity = constants_.numerics.viscous_courant * h * h / constants_.viscosity;
    if (by_viscosity < proposal.seconds) proposal = {by_viscosity, "viscosity"};
  }
  if (proposal.seconds >= 1e300) proposal = {1e-3, "rest"};
  return proposal;
}

#define TERN_INSTANTIATE(D)                                                             \
  template void Fluid<D>::begin_window(Ticks, Ticks);                                   \
  template InterfaceParticles<D> Fluid<D>::see_surface(const Surface<D>&);              \
  template void Fluid<D>::prepare_pressure();                                           \
  template InterfacePressure<D> Fluid<D>::solve_pressure(const InterfaceCondition<D>&); \
  template void Fluid<D>::complete_velocity();                                          \
  template void Fluid<D>::end_window(const InterfaceForce<D>&);                         \
  template void Fluid<D>::pass_window();                                                \
  template StepProposal Fluid<D>::propose_step() const;                                 \
  template std::optional<FluidExtent<D>> Fluid<D>::extent() const;                      \
  template void Fluid<D>::add_images(InterfaceParticles<D>&);                           \
  template void Fluid<D>::predict();                                                    \
  template void Fluid<D>::wrap_into_period();                                           \
  template void Fluid<D>::sort_by_cell();                                               \
  template void Fluid<D>::hide_walls_behind_structure();                                \
  template void Fluid<D>::move_surface_at(const std::vector<Vector<D>>&);               \
  template void Fluid<D>::count_leaks(const Faces<D>&, const FaceRows&);                \
  template void Fluid<D>::remove_escaped();
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
