#pragma once
// The structure as the coupling sees it: a predicted surface, then the load of the window.

#include <utility>
#include <vector>

#include "scene/case_file.hpp"
#include "structure/complete_state.hpp"
#include "structure/structure.hpp"

namespace tern::structure {

/// What the fluid is given of the motion of a surface point: a velocity w at the end of a window, and what it is made from. The motion at
/// the end itself will not do: sub-steps resolve the oscillations of a body that is held by its stiffness, and at that instant it may move
/// against the load. From its mean velocity X in the window it never does, so that the coupling is stable for every stiffness and mass
/// (tests/coupler/interface_velocity_test.cpp). This is the generalised alpha method (Chung and Hulbert 1993) with rho_inf = 0.2: of
/// second order, and what alternates from window to window loses four fifths in each.
template <class Velocity>
struct InterfaceVelocity {
  Velocity at_end;  ///< w [m/s]
  Velocity rate;    ///< q, the rate of displacement at another instant of the window [m/s]

  /// After a window with the mean velocity `mean`.
  InterfaceVelocity after(const Velocity& mean) const { return {1.68 * mean - 0.48 * rate - 0.2 * at_end, 1.2 * mean - 0.2 * rate}; }
};

/// A CompleteState and the surface as the fluid knows it.
template <int D>
struct CoupledState {
  CompleteState<D> structure;
  Surface<D> surface;
  std::vector<Vector<D>> rate;  ///< InterfaceVelocity::rate of every point

  /// The list of the members: visit(name, member of each state) for every one.
  template <class Visit, class... States>
  static void for_each_field(Visit&& visit, States&... state) {
    CompleteState<D>::for_each_field(visit, state.structure...);
    visit("surface", state.surface...);
    visit("rate", state.rate...);
  }
};

template <int D>
class CoupledStructure {
 public:
  CoupledStructure(Structure<D>& structure, CouplingAlgorithm algorithm)
      : structure_(structure), algorithm_(algorithm), at_begin_(structure.surface()), rate_(at_begin_.velocity) {}

  /// Halfway to the state predicted under the old load, with that state's velocity. Explicit coupling: the present surface moved on for
  /// half a window at its velocity.
  Surface<D> predict_surface(Ticks begin, Ticks duration) {
    begin_ = begin;
    duration_ = duration;
    if (algorithm_ == CouplingAlgorithm::explicit_staggering) {
      Surface<D> surface = at_begin_;
      for (std::size_t k = 0; k < surface.position.size(); ++k) surface.position[k] += 0.5 * seconds(duration) * surface.velocity[k];
      return surface;
    }
    Surface<D> trial = structure_.trial(begin, duration);
    trial.velocity = velocity_at_end(trial.position);
    for (std::size_t k = 0; k < trial.position.size(); ++k) {
      trial.position[k] = 0.5 * (at_begin_.position[k] + trial.position[k]);
      trial.normal[k] = (at_begin_.normal[k] + trial.normal[k]).normalized();
      trial.area[k] = 0.5 * (at_begin_.area[k] + trial.area[k]);
    }
    return trial;
  }

  /// Implicit coupling: velocities of the surface at the end of the window under this load.
  std::vector<Vector<D>> respond(const SurfaceLoad<D>& load) {
    structure_.advance(load);
    return velocity_at_end(structure_.surface().position);
  }

  /// Brings the structure to the end of the window under this load.
  void apply(const SurfaceLoad<D>& load) {
    if (algorithm_ == CouplingAlgorithm::explicit_staggering) structure_.trial(begin_, duration_);
    structure_.advance(load);
    Surface<D> end = structure_.surface();
    if (algorithm_ != CouplingAlgorithm::explicit_staggering) {
      end.velocity = velocity_at_end(end.position);
      for (std::size_t k = 0; k < rate_.size(); ++k) rate_[k] = next(end.position, k).rate;
    }
    at_begin_ = std::move(end);
  }

  /// Between two windows: everything from which another one goes on with the same bits.
  CoupledState<D> state() const { return {structure_.state(), at_begin_, rate_}; }
  void set_state(const CoupledState<D>& given) {
    CoupledState<D> state;
    CoupledState<D>::for_each_field([](const char*, const auto& source, auto& target) { target = source; }, given, state);
    structure_.set_state(state.structure);
    at_begin_ = std::move(state.surface);
    rate_ = std::move(state.rate);
  }

 private:
  InterfaceVelocity<Vector<D>> next(const std::vector<Vector<D>>& position, std::size_t k) const {
    const Vector<D> mean = (position[k] - at_begin_.position[k]) / seconds(duration_);
    return InterfaceVelocity<Vector<D>>{at_begin_.velocity[k], rate_[k]}.after(mean);
  }
  std::vector<Vector<D>> velocity_at_end(const std::vector<Vector<D>>& position) const {
    std::vector<Vector<D>> velocity(position.size());
    for (std::size_t k = 0; k < position.size(); ++k) velocity[k] = next(position, k).at_end;
    return velocity;
  }

  Structure<D>& structure_;
  CouplingAlgorithm algorithm_;
  Ticks begin_ = 0, duration_ = 0;
  Surface<D> at_begin_;          ///< of the window; velocity: as the fluid was given it
  std::vector<Vector<D>> rate_;  ///< of the same instant
};

}  // namespace tern::structure
