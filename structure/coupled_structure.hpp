#pragma once
// The structure as the coupling sees it: a predicted surface, then the load of the window.

#include <utility>
#include <vector>

#include "scene/case_file.hpp"
#include "structure/complete_state.hpp"
#include "structure/structure.hpp"

namespace tern::structure {

/// Velocity of a surface point for the fluid at the end of a window, from its mean velocity in it and that at the begin [m/s].
/// The motion at the end itself will not do: sub-steps resolve the oscillations of a body that is held by its stiffness, and at
/// that instant it may move against the load. From its mean velocity it never does, so that the coupling is stable for every
/// stiffness and mass (tests/coupler/interface_velocity_test.cpp). Twice the mean less the velocity at the begin gives the load
/// the same work on both sides; a part of it is forgotten, so that motions too fast for the windows die out.
template <class Velocity>
Velocity interface_velocity(const Velocity& mean, const Velocity& at_begin) {
  constexpr double kept = 0.8;
  return (1 + kept) * mean - kept * at_begin;
}

/// A CompleteState and the surface as the fluid knows it.
template <int D>
struct CoupledState {
  CompleteState<D> structure;
  Surface<D> surface;

  /// The list of the members: visit(name, member of each state) for every one.
  template <class Visit, class... States>
  static void for_each_field(Visit&& visit, States&... state) {
    CompleteState<D>::for_each_field(visit, state.structure...);
    visit("surface", state.surface...);
  }
};

template <int D>
class CoupledStructure {
 public:
  CoupledStructure(Structure<D>& structure, CouplingAlgorithm algorithm)
      : structure_(structure), algorithm_(algorithm), at_begin_(structure.surface()) {}

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
    if (algorithm_ != CouplingAlgorithm::explicit_staggering) end.velocity = velocity_at_end(end.position);
    at_begin_ = std::move(end);
  }

  /// Between two windows: everything from which another one goes on with the same bits.
  CoupledState<D> state() const { return {structure_.state(), at_begin_}; }
  void set_state(const CoupledState<D>& given) {
    CoupledState<D> state;
    CoupledState<D>::for_each_field([](const char*, const auto& source, auto& target) { target = source; }, given, state);
    structure_.set_state(state.structure);
    at_begin_ = std::move(state.surface);
  }

 private:
  std::vector<Vector<D>> velocity_at_end(const std::vector<Vector<D>>& position) const {
    std::vector<Vector<D>> velocity(position.size());
    for (std::size_t k = 0; k < position.size(); ++k) {
      const Vector<D> mean = (position[k] - at_begin_.position[k]) / seconds(duration_);
      velocity[k] = interface_velocity<Vector<D>>(mean, at_begin_.velocity[k]);
    }
    return velocity;
  }

  Structure<D>& structure_;
  CouplingAlgorithm algorithm_;
  Ticks begin_ = 0, duration_ = 0;
  Surface<D> at_begin_;  ///< of the window; velocity: as the fluid was given it
};

}  // namespace tern::structure
