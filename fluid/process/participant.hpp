#pragma once
// The fluid as one of three processes: what proto/participant/participant.hpp asks of a solver.

#include "fluid/process/fluid_side.hpp"
#include "proto/participant/participant_frame.hpp"

namespace tern::fluid {

template <int D>
class Participant : public proto::ParticipantFrame<Participant<D>, FluidSide<D>> {
  using Frame = proto::ParticipantFrame<Participant<D>, FluidSide<D>>;
  using Frame::timed;

 public:
  Participant(const CommandLine& command, const Case& scene, RunReport& report, proto::ParticipantChannel& channel, Fluid<D>& fluid)
      : Frame(command, scene, report, channel, FluidSide<D>(scene, fluid)), fluid_(fluid) {}

  wire::Hello hello() {
    wire::Hello hello = Frame::hello(D, fluid_.state().size());
    hello.set_proposed_step_s(fluid_.propose_step().seconds);
    hello.set_limit(fluid_.propose_step().limit);
    return hello;
  }

  void begin_window(Ticks begin, Ticks duration) {
    timed([&] { fluid_.begin_window(begin, duration); });
  }
  InterfaceParticles<D> see_surface(const Surface<D>& surface) {
    return timed([&] { return fluid_.see_surface(surface); });
  }
  void prepare_pressure() {
    timed([&] { fluid_.prepare_pressure(); });
  }
  InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& load) {
    return timed([&] { return fluid_.solve_pressure(load); });
  }
  void complete_velocity() {
    timed([&] { fluid_.complete_velocity(); });
  }
  wire::WindowDone end(const InterfaceForce<D>& force) {
    return timed([&] {
      fluid_.end_window(force);
      return done();
    });
  }
  wire::WindowDone pass() {
    return timed([&] {
      fluid_.pass_window();
      return done();
    });
  }

  void save_solver(StateWriter& file) const { file("fluid", fluid_.state()); }
  void restore_solver(StateReader& file) {
    State<D> state;
    file("fluid", state);
    fluid_.set_state(std::move(state));
  }

 private:
  wire::WindowDone done() const {
    const StepProposal proposal = fluid_.propose_step();
    wire::WindowDone done;
    done.set_proposed_step_s(proposal.seconds);
    done.set_limit(proposal.limit);
    done.set_iterations(static_cast<std::uint32_t>(fluid_.last_solve().iterations));
    if (const auto extent = fluid_.extent()) *done.mutable_extent() = proto::to_wire<D>(*extent);
    return done;
  }

  Fluid<D>& fluid_;
};

}  // namespace tern::fluid
