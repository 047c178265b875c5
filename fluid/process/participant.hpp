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
  Participant(const CommandLine& command, const Case& scene, RunReport& report, proto::ParticipantChannel& channel, Leader<D>& leader)
      : Frame(command, scene, report, channel, FluidSide<D>(scene, leader)), leader_(leader) {}

  wire::Hello hello() {
    wire::Hello hello = Frame::hello(D, fluid().particles());
    hello.set_proposed_step_s(fluid().propose_step().seconds);
    hello.set_limit(fluid().propose_step().limit);
    return hello;
  }

  void begin_window(Ticks begin, Ticks duration) {
    timed([&] { leader_.begin_window(begin, duration); });
  }
  InterfaceParticles<D> see_surface(const Surface<D>& surface) {
    return timed([&] { return leader_.see_surface(surface); });
  }
  void prepare_pressure() {
    timed([&] { leader_.prepare_pressure(); });
  }
  InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& load) {
    return timed([&] { return leader_.solve_pressure(load); });
  }
  void complete_velocity() {
    timed([&] { leader_.complete_velocity(); });
  }
  wire::WindowDone end(const InterfaceForce<D>& force) {
    return timed([&] {
      leader_.end_window(force);
      return done();
    });
  }
  wire::WindowDone pass() {
    return timed([&] {
      leader_.pass_window();
      return done();
    });
  }

  void save_solver(StateWriter& file) const { leader_.save(file); }
  void restore_solver(StateReader& file) { leader_.restore(file); }

 private:
  const Fluid<D>& fluid() const { return leader_.fluid(); }
  wire::WindowDone done() const {
    const StepProposal proposal = fluid().propose_step();
    wire::WindowDone done;
    done.set_proposed_step_s(proposal.seconds);
    done.set_limit(proposal.limit);
    done.set_iterations(static_cast<std::uint32_t>(fluid().last_solve().iterations));
    if (const auto extent = fluid().extent()) *done.mutable_extent() = proto::to_wire<D>(*extent);
    return done;
  }

  Leader<D>& leader_;
};

}  // namespace tern::fluid
