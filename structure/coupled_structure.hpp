#pragma once
// The structure as the coupling sees it: a predicted surface, then the load of the window.

#include <utility>
#include <vector>

#include "base/followed_velocity.hpp"
#include "scene/case_file.hpp"
#include "structure/complete_state.hpp"
#include "structure/free_motion.hpp"
#include "structure/structure.hpp"

namespace tern::structure {

/// A CompleteState and the surface as the fluid knows it.
template <int D>
struct CoupledState {
  CompleteState<D> structure;
  Surface<D> surface;
  std::vector<Vector<D>> own_velocity;
  double last_duration = 0;  ///< of a window [s]; 0: there was none

  /// The list of the members: visit(name, member of each state) for every one.
  template <class Visit, class... States>
  static void for_each_field(Visit&& visit, States&... state) {
    CompleteState<D>::for_each_field(visit, state.structure...);
    visit("surface", state.surface...);
    visit("own_velocity", state.own_velocity...);
    visit("last_duration", state.last_duration...);
  }
};

template <int D>
class CoupledStructure {
 public:
  CoupledStructure(Structure<D>& structure, CouplingAlgorithm algorithm)
      : structure_(structure), algorithm_(algorithm), at_begin_(structure.surface()), own_velocity_(at_begin_.velocity) {
    note_begin();
  }

  /// Halfway to the state predicted under the old load, with that state's velocity. Explicit coupling: the present surface moved on for
  /// half a window at its velocity.
  Surface<D> predict_surface(Ticks begin, Ticks duration) {
    begin_ = begin;
    duration_ = duration;
    begun_ = false;
    if (algorithm_ == CouplingAlgorithm::explicit_staggering) {
      Surface<D> surface = at_begin_;
      for (std::size_t k = 0; k < surface.position.size(); ++k) surface.position[k] += 0.5 * seconds(duration) * surface.velocity[k];
      return surface;
    }
    Surface<D> trial = this->trial();
    trial.velocity = velocity_at_end(trial.position);
    for (std::size_t k = 0; k < trial.position.size(); ++k) {
      trial.position[k] = 0.5 * (at_begin_.position[k] + trial.position[k]);
      trial.normal[k] = (at_begin_.normal[k] + trial.normal[k]).normalized();
      trial.area[k] = 0.5 * (at_begin_.area[k] + trial.area[k]);
    }
    return trial;
  }

  /// Velocities of the surface at the end of the window under this load, which is tried. The explicit coupling tries none; who asks all the
  /// same gets those of the points.
  std::vector<Vector<D>> respond(const SurfaceLoad<D>& load) {
    if (!begun_) trial();
    structure_.advance(load);
    if (algorithm_ == CouplingAlgorithm::explicit_staggering) return structure_.surface().velocity;
    return velocity_at_end(structure_.surface().position);
  }

  /// Brings the structure to the end of the window under this load.
  void apply(const SurfaceLoad<D>& load) {
    if (!begun_) trial();
    structure_.advance(load);
    Surface<D> end = structure_.surface();
    if (algorithm_ != CouplingAlgorithm::explicit_staggering)
      free_at_begin_ = for_each_followed(end.position, [&](std::size_t k, const FollowedVelocity<Vector<D>>& followed) {
        end.velocity[k] = followed.given;
        own_velocity_[k] = followed.own;
      });
    at_begin_ = std::move(end);
    last_duration_ = seconds(duration_);
  }

  /// Between two windows: everything from which another one goes on with the same bits.
  CoupledState<D> state() const { return {structure_.state(), at_begin_, own_velocity_, last_duration_}; }
  void set_state(const CoupledState<D>& given) {
    CoupledState<D> state;
    CoupledState<D>::for_each_field([](const char*, const auto& source, auto& target) { target = source; }, given, state);
    structure_.set_state(state.structure);
    at_begin_ = std::move(state.surface);
    own_velocity_ = std::move(state.own_velocity);
    last_duration_ = state.last_duration;
    note_begin();
  }

 private:
  /// Once in a window.
  Surface<D> trial() {
    begun_ = true;
    return structure_.trial(begin_, duration_);
  }

  void note_begin() {
    if (algorithm_ != CouplingAlgorithm::explicit_staggering) free_at_begin_ = structure_.free_motions();
  }

  std::vector<Vector<D>> velocity_at_end(const std::vector<Vector<D>>& position) const {
    std::vector<Vector<D>> velocity(position.size());
    for_each_followed(position, [&](std::size_t k, const FollowedVelocity<Vector<D>>& followed) { velocity[k] = followed.given; });
    return velocity;
  }

  /// visit(k, what is followed of the point at the end of the window), from its `position` there and the present state of the structure.
  /// Returns the free motion of each body at the end.
  template <class Visit>
  std::vector<FreeMotion<D>> for_each_followed(const std::vector<Vector<D>>& position, const Visit& visit) const {
    const double dt = seconds(duration_), ratio = last_duration_ > 0 ? dt / last_duration_ : 1;
    std::vector<FreeMotion<D>> free_at_end = structure_.free_motions();
    const std::vector<std::uint32_t>& body = structure_.surface_properties().body;
    for (std::size_t k = 0; k < position.size(); ++k) {
      // A rigid motion of a body that nothing holds is given as it is at the end. The rest of the motion is followed.
      const FreeMotion<D>&before = free_at_begin_[body[k]], &after = free_at_end[body[k]];
      const Vector<D> arm = 0.5 * (at_begin_.position[k] - before.centre + position[k] - after.centre);
      const Vector<D> free_mean = (after.centre - before.centre) / dt + 0.5 * (before.spin + after.spin) * arm;
      const Vector<D> begin = before.at(at_begin_.position[k]), end = after.at(position[k]);
      const Vector<D> mean = (position[k] - at_begin_.position[k]) / dt - free_mean;
      FollowedVelocity<Vector<D>> followed =
          followed_velocity<Vector<D>>(mean, {at_begin_.velocity[k] - begin, own_velocity_[k] - begin}, ratio);
      followed.given += end;
      followed.own += end;
      visit(k, followed);
    }
    return free_at_end;
  }

  Structure<D>& structure_;
  CouplingAlgorithm algorithm_;
  Ticks begin_ = 0, duration_ = 0;
  bool begun_ = false;                        ///< trial() has been called in this window
  Surface<D> at_begin_;                       ///< of the window; velocity: as the fluid was given it
  std::vector<Vector<D>> own_velocity_;       ///< FollowedVelocity::own of each point, at the begin of the window
  std::vector<FreeMotion<D>> free_at_begin_;  ///< of each body, at the begin of the window
  double last_duration_ = 0;                  ///< of the last window [s]; 0: there was none
};

}  // namespace tern::structure
