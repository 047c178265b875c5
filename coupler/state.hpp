#pragma once
// Everything from which the coupler goes on: with the State of another coupler at a window's end it goes on with the same bits.

#include <vector>

#include "coupler/acceleration/fixed_point.hpp"
#include "coupler/acceleration/learnt_response.hpp"
#include "coupler/motion_error.hpp"
#include "coupler/setup.hpp"
#include "coupler/stability/observations.hpp"
#include "coupler/totals.hpp"
#include "meeting/meeting.hpp"
#include "proto/interface.hpp"

namespace tern::coupler {

/// How often each term was evaluated since the start, in pairs of a particle and a surface point (iterations). What a case
/// leaves out counts nothing.
struct Evaluations {
  long pressure = 0, riemann_dissipation = 0, vem = 0, coupling_iterations = 0, windows_without_exchange = 0;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("pressure", all.pressure...);
    visit("riemann_dissipation", all.riemann_dissipation...);
    visit("vem", all.vem...);
    visit("coupling_iterations", all.coupling_iterations...);
    visit("windows_without_exchange", all.windows_without_exchange...);
  }
};

template <int D>
struct State {
  explicit State(const Setup<D>& setup)
      : fixed_point(setup.coupling.tolerance.value_or(tolerance_by_default), setup.coupling.max_iterations),
        observations(setup.body_name.size()) {}

  SurfaceLoad<D> load;                      ///< on the structure in the last window; empty before the first
  SurfaceLoad<D> contact;                   ///< the contacts in it; empty where windows are not repeated
  std::vector<Vector<D>> surface_velocity;  ///< at the end of the last window [m/s]; empty before the first
  std::vector<Vector<D>> answered_change;   ///< InterfaceCondition::answered_change; empty where the structure was not asked
  MotionError<D> motion;                    ///< how that has changed
  LearntResponse<D> response;               ///< how the surface has answered
  SurfaceAtStart<D> start;                  ///< of the run; empty before
  FixedPoint fixed_point;                   ///< what the iterations of the last windows have shown of the answer to a load
  Observations observations;                ///< what has been seen by those who watch for divergence
  MeetingState<D> meeting;                  ///< of bodies with each other and with walls
  Evaluations evaluations;
  Totals totals;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("load", all.load.force...);
    visit("contact", all.contact.force...);
    visit("surface_velocity", all.surface_velocity...);
    visit("answered_change", all.answered_change...);
    visit("motion", all.motion...);
    visit("response", all.response...);
    visit("start", all.start...);
    visit("fixed_point", all.fixed_point...);
    visit("observations", all.observations...);
    visit("meeting", all.meeting...);
    visit("evaluations", all.evaluations...);
    visit("totals", all.totals...);
  }
};

}  // namespace tern::coupler
