#pragma once
// Everything from which the structure of a scene goes on with the same bits after a window.

#include "structure/implicit/implicit_memory.hpp"
#include "structure/implicit/integrator_choice.hpp"
#include "structure/state.hpp"

namespace tern::structure {

template <int D>
struct CompleteState {
  State<D> motion;
  ImplicitMemory<D> implicit;
  IntegratorChoice choice;
  bool implicit_window = false;  ///< the last window was one of implicit steps
  Evaluations evaluations;

  /// The list of the members: visit(name, member of each state) for every one.
  template <class Visit, class... States>
  static void for_each_field(Visit&& visit, States&... state) {
    State<D>::for_each_field(visit, state.motion...);
    ImplicitMemory<D>::for_each_field(visit, state.implicit...);
    IntegratorChoice::for_each_field(visit, state.choice...);
    visit("implicit_window", state.implicit_window...);
    visit("evaluations", state.evaluations...);
  }
};

/// Copies `from` to `to` by the list of the members.
template <int D>
void copy_state(const CompleteState<D>& from, CompleteState<D>& to) {
  CompleteState<D>::for_each_field([](const char*, const auto& source, auto& target) { target = source; }, from, to);
}

}  // namespace tern::structure
