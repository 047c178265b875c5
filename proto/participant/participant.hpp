#pragma once
// The part of a participant in a run (docs/PROTOCOL.md, section 3) as a loop around any solver. tern's own fluid and structure
// take part through these two functions, and another solver in C++ can: it brings what is named below, and nothing else.
//
// Both kinds of solver:
//   wire::Hello hello();                        everything but process id and version; account() at t = 0
//   wire::Account account();                    the state as it is now
//   void end_window(const Window&);             the window is over for good: count it, write what is due
//   void finish();                              the run is over: write what is missing
//   std::string save(std::uint64_t step);       optional: keep the state at the end of this window; tells it from any other
//   void resume(const wire::Welcome&);          the same: go back to what save(resume_step) has kept
//   void save_after_failure(const Error&, std::uint64_t wanted) noexcept;      optional: the state at the end of this window, or (0) of
//                                               one from which to go on after such an error, as save() does, if it is still there, and
//                                               channel.set_kept()
// A structure:
//   Surface<D> predict_surface(Ticks begin, Ticks duration);        the window under the load of the last one
//   std::vector<Vector<D>> respond(const SurfaceLoad<D>&);          the window once more, under this load: velocities at its end
//   void apply(const SurfaceLoad<D>&);                              the window for good
// A fluid:
//   void begin_window(Ticks begin, Ticks duration);
//   InterfaceParticles<D> see_surface(const Surface<D>&);
//   void prepare_pressure();                                        while the coupler computes the load; may do nothing
//   InterfacePressure<D> solve_pressure(const InterfaceCondition<D>&);      repeated where it has a surface_velocity
//   void complete_velocity();                                       while the coupler computes the force; may do nothing
//   wire::WindowDone end(const InterfaceForce<D>&);                      all but its account
//   wire::WindowDone pass();                                        the same of a window without surface, which comes only to a
//                                                                   fluid whose last WindowDone had an extent

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/time.hpp"
#include "proto/transport/channel.hpp"
#include "proto/wire/convert.hpp"
#include "run/checkpoint.hpp"
#include "run/run_report.hpp"

namespace tern::proto {

struct Window {
  Ticks begin, duration;
  bool write_frame;  ///< at its end
  Ticks end() const { return begin + duration; }
};

/// The window that the coupler begins; empty when it ends the run: then the solver has finished and the coupler knows. Saves the state
/// when asked to before that.
template <class Solver>
std::optional<Window> next_window(ParticipantChannel& channel, Solver& solver) {
  constexpr bool saves = requires { solver.save(std::uint64_t{}); };
  wire::Message order = channel.receive({Kind::kBeginWindow, Kind::kFinish, Kind::kSave});
  for (; order.has_save(); order = channel.receive({Kind::kBeginWindow, Kind::kFinish, Kind::kSave})) {
    if constexpr (saves) {
      wire::Message answer;
      answer.mutable_saved()->set_hash(solver.save(order.step()));
      channel.send(std::move(answer));
    } else {
      throw PeerLost("The coupler asks this participant to save its state, which it has not offered.");
    }
  }
  if (order.has_begin_window()) {
    const wire::BeginWindow& window = order.begin_window();
    return Window{window.begin_ticks(), window.duration_ticks(), window.write_frame()};
  }
  solver.finish();
  wire::Message answer;
  *answer.mutable_finished()->mutable_account() = solver.account();
  channel.send(std::move(answer));
  if (order.finish().interrupted()) throw Interrupted("The run was interrupted; results up to here are kept.");
  return std::nullopt;
}

/// `solver` keeps what it can before the coupler hears why this process ends.
template <class Solver, class Part>
void keeping_the_state(ParticipantChannel& channel, Solver& solver, Part&& part) {
  try {
    part();
  } catch (const Error& error) {
    if constexpr (requires { solver.save_after_failure(std::declval<const Error&>(), std::uint64_t{}); }) {
      const bool wanted = channel.wanted_step() > 0 || !channel.coupler_gone();
      if (wanted && state_was_sound(error)) solver.save_after_failure(error, channel.wanted_step());
    }
    throw;
  }
}

/// Does what a participant does, from making its solver to the end; the coupler is told when that fails.
template <class Part>
void telling_the_coupler(ParticipantChannel& channel, Part&& part) {
  try {
    part();
  } catch (const Error& error) {
    channel.abort(error);
    throw;
  }
}

/// Joins the run, and goes back to a checkpoint if the coupler says so.
template <class Solver>
void join(ParticipantChannel& channel, Solver& solver) {
  const wire::Welcome welcome = channel.handshake(solver.hello());
  if constexpr (requires { solver.resume(welcome); }) {
    solver.resume(welcome);
  } else if (welcome.resume_step() > 0) {
    throw BadInput("The coupler goes on from a checkpoint, and this participant keeps none: begin the run anew.");
  }
}

/// Takes part until the coupler ends the run. Throws Interrupted when it was interrupted there or here, and what channel and
/// solver throw.
template <int D, class Solver>
void take_part_as_structure(ParticipantChannel& channel, Solver& solver) {
  join(channel, solver);
  const auto take_part_in = [&](const Window& window) {
    wire::Message message;
    const wire::Account at_begin = solver.account();
    *message.mutable_surface() = to_wire<D>(solver.predict_surface(window.begin, window.duration));
    *message.mutable_surface()->mutable_account() = at_begin;
    channel.send(std::move(message));
    for (message = channel.receive({Kind::kSurfaceLoad}); message.surface_load().trial(); message = channel.receive({Kind::kSurfaceLoad})) {
      wire::Message answer;
      *answer.mutable_surface_velocity() = to_wire<D>(solver.respond(from_wire<D>(message.surface_load())));
      channel.send(std::move(answer));
    }
    solver.apply(from_wire<D>(message.surface_load()));
    solver.end_window(window);
  };
  keeping_the_state(channel, solver, [&] {
    while (const auto window = next_window(channel, solver)) take_part_in(*window);
  });
}

/// As take_part_as_structure.
template <int D, class Solver>
void take_part_as_fluid(ParticipantChannel& channel, Solver& solver) {
  join(channel, solver);
  const auto end_window = [&](const Window& window, wire::WindowDone done) {
    wire::Message message;
    *done.mutable_account() = solver.account();
    *message.mutable_window_done() = std::move(done);
    channel.send(std::move(message));
    solver.end_window(window);
  };
  const auto take_part_in = [&](const Window& window) {
    solver.begin_window(window.begin, window.duration);
    wire::Message message = channel.receive({Kind::kSurface});
    if (message.surface().area().empty()) {  // out of reach
      end_window(window, solver.pass());
      return;
    }
    wire::Message answer;
    *answer.mutable_interface_particles() = to_wire<D>(solver.see_surface(from_wire<D>(message.surface())));
    channel.send(std::move(answer));
    solver.prepare_pressure();
    for (message = channel.receive({Kind::kInterfaceCondition}); message.has_interface_condition();
         message = channel.receive({Kind::kInterfaceCondition, Kind::kInterfaceForce})) {
      answer.Clear();
      *answer.mutable_interface_pressure() = to_wire<D>(solver.solve_pressure(from_wire<D>(message.interface_condition())));
      channel.send(std::move(answer));
      if (!message.interface_condition().repeats()) solver.complete_velocity();  // of a trial that another may follow they may be in vain
    }
    end_window(window, solver.end(from_wire<D>(message.interface_force())));
  };
  keeping_the_state(channel, solver, [&] {
    while (const auto window = next_window(channel, solver)) take_part_in(*window);
  });
}

/// Time and traffic of a participant's or the coupler's channel, for the report.
template <class Channel>
void report_traffic(const Channel& channel, RunReport& report) {
  report.timing("wait") = channel.wait_seconds();
  report.timing("exchange") = channel.exchange_seconds();
  report.set_count("bytes_sent", static_cast<long>(channel.bytes_sent()));
  report.set_count("bytes_received", static_cast<long>(channel.bytes_received()));
}

}  // namespace tern::proto
