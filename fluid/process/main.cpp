// tern-fluid: the fluid of a scene, alone or as one of three processes.

#include "base/error.hpp"
#include "base/interrupt.hpp"
#include "base/timing.hpp"
#include "fluid/process/output.hpp"
#include "proto/participant/participant.hpp"
#include "proto/wire/account.hpp"
#include "run/command_line.hpp"
#include "run/progress.hpp"
#include "run/recorder.hpp"

namespace {

using namespace tern;

/// The whole run in this process.
template <int D>
void run_alone(const CommandLine& command, const Case& scene, RunReport& report) {
  fluid::Fluid<D> fluid(scene);
  fluid::Measures<D> measures;
  FrameWriter frames(command.out, "fluid");
  Recorder recorder(command.out, gauge_columns(scene, GaugeOwner::fluid), fluid_energy_columns(), scene.output.gauge_interval);
  Progress progress(scene.end_time, command.quiet);
  StepControl control;
  const Ticks end = to_ticks(scene.end_time);
  const FrameSchedule schedule(scene.output.frame_interval, end);
  double& compute_s = report.timing("compute");
  double& output_s = report.timing("output");

  long step = 0, evaluated_gauges = 0;
  const auto write_output = [&](bool frame) {
    ScopedTimer timer(output_s);
    if (const Ticks now = fluid.state().time; recorder.due(now)) {
      const GaugeValues values = gauge_values(fluid, scene);
      report.set_evaluations("gauges", evaluated_gauges += static_cast<long>(values.size()));
      recorder.account(now, values, energy_values(fluid));
    }
    if (frame) write_frame(fluid, frames, step);
    measures.report(fluid, report);
    report.update();
  };
  write_output(true);
  for (Ticks now = 0; now < end;) {
    const Stopwatch watch;
    const Ticks target = schedule.next(now);
    const StepProposal proposal = fluid.propose_step();
    const Ticks duration = control.next(proposal.seconds, now, target);
    {
      ScopedTimer timer(compute_s);
      fluid.begin_window(now, duration);
      fluid.pass_window();
    }
    now += duration;
    ++step;
    measures.add(fluid);
    report.set_time(seconds(now), step);
    recorder.step(now, duration, proposal.limit, fluid.last_solve().iterations, watch.seconds());
    progress.step(seconds(now), step, seconds(duration), proposal.limit, fluid.last_solve().iterations);
    const bool stopping = interrupted();
    write_output(now == target || stopping);
    if (stopping) progress.finish("interrupted");
    throw_if_interrupted("between two steps");
  }
  progress.finish();
}

/// The fluid as one of three processes: what proto/participant/participant.hpp asks of a solver.
template <int D>
class Participant {
 public:
  Participant(const CommandLine& command, const Case& scene, RunReport& report, const proto::ParticipantChannel& channel)
      : scene_(scene),
        report_(report),
        channel_(channel),
        fluid_(scene),
        frames_(command.out, "fluid"),
        rows_(scene.output.gauge_interval) {}

  wire::Hello hello() {
    wire::Hello hello;
    hello.set_case_hash(scene_.hash);
    hello.set_dimension(D);
    hello.set_particles(static_cast<std::uint32_t>(fluid_.state().size()));
    hello.set_proposed_step_s(fluid_.propose_step().seconds);
    hello.set_limit(fluid_.propose_step().limit);
    *hello.mutable_account() = account();
    write_output_frame();
    return hello;
  }
  wire::Account account() {
    // The coupler's recorder writes rows on the same schedule and ignores the gauges of other instants: there the last values
    // go with the message once more.
    if (const Ticks now = fluid_.state().time; rows_.due(now)) {
      gauges_ = gauge_values(fluid_, scene_);
      evaluated_gauges_ += static_cast<long>(gauges_.size());
      rows_.written(now);
    }
    return proto::account(energy_values(fluid_), gauges_);
  }

  void begin_window(Ticks begin, Ticks duration) {
    ScopedTimer timer(compute_s_);
    fluid_.begin_window(begin, duration);
  }
  InterfaceParticles<D> see_surface(const Surface<D>& surface) {
    ScopedTimer timer(compute_s_);
    return fluid_.see_surface(surface);
  }
  void prepare_pressure() {
    ScopedTimer timer(compute_s_);
    fluid_.prepare_pressure();
  }
  InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& load) {
    ScopedTimer timer(compute_s_);
    return fluid_.solve_pressure(load);
  }
  void complete_velocity() {
    ScopedTimer timer(compute_s_);
    fluid_.complete_velocity();
  }
  wire::WindowDone end(const InterfaceForce<D>& force) {
    ScopedTimer timer(compute_s_);
    fluid_.end_window(force);
    return done();
  }
  wire::WindowDone pass() {
    ScopedTimer timer(compute_s_);
    fluid_.pass_window();
    return done();
  }

  void end_window(const proto::Window& window) {
    ++step_;
    measures_.add(fluid_);
    ScopedTimer timer(output_s_);
    if (window.write_frame) write_output_frame();
    report_.set_time(seconds(window.end()), step_);
    report_now();
    report_.update();
  }
  void finish() {
    if (last_frame_ != step_) write_output_frame();
    report_now();
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
  void write_output_frame() {
    write_frame(fluid_, frames_, step_);
    last_frame_ = step_;
  }
  void report_now() {
    measures_.report(fluid_, report_);
    report_.set_evaluations("gauges", evaluated_gauges_);
    proto::report_traffic(channel_, report_);
  }

  const Case& scene_;
  RunReport& report_;
  const proto::ParticipantChannel& channel_;
  double& compute_s_ = report_.timing("compute");
  double& output_s_ = report_.timing("output");
  fluid::Fluid<D> fluid_;
  fluid::Measures<D> measures_;
  FrameWriter frames_;
  RowSchedule rows_;
  GaugeValues gauges_;
  long evaluated_gauges_ = 0;
  long step_ = 0, last_frame_ = 0;
};

template <int D>
void run(const CommandLine& command, const Case& scene, RunReport& report) {
  if (command.alone()) return run_alone<D>(command, scene, report);
  proto::ParticipantChannel channel({command.endpoint, command.keys, command.insecure}, wire::FLUID, 300, 2 * command.deadline_s);
  proto::telling_the_coupler(channel, [&] {
    Participant<D> participant(command, scene, report, channel);
    proto::take_part_as_fluid<D>(channel, participant);
  });
}

}  // namespace

int main(int argc, char** argv) {
  return run_main(argc, argv, "fluid", [](const CommandLine& command, const Case& scene, RunReport& report) {
    if (!scene.fluid) throw BadInput(scene.path + " has no [fluid] table, so there is nothing for tern-fluid to do.");
    if (command.alone() && scene.structure)
      throw BadInput(scene.path + " has a [structure] table: start tern-fluid with --endpoint, or use ./tern run.");
    scene.dimension == 2 ? run<2>(command, scene, report) : run<3>(command, scene, report);
  });
}
