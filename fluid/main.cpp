// tern-fluid: the fluid of a scene, alone or as one of three processes.

#include "fluid/output.hpp"
#include "particles/command_line.hpp"
#include "particles/error.hpp"
#include "particles/interrupt.hpp"
#include "particles/progress.hpp"
#include "particles/recorder.hpp"
#include "particles/timing.hpp"
#include "proto/account.hpp"
#include "proto/channel.hpp"
#include "proto/convert.hpp"

namespace {

using namespace tern;
using proto::Kind;

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

  long step = 0;
  const auto write_output = [&](bool frame) {
    ScopedTimer timer(output_s);
    if (const Ticks now = fluid.state().time; recorder.due(now))
      recorder.account(now, gauge_values(fluid, scene), energy_values(fluid));
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
      fluid.see_surface({});
      fluid.solve_pressure({});
      fluid.end_window({});
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

/// One of three processes: obeys the coupler's windows.
template <int D>
void run_coupled(const CommandLine& command, const Case& scene, RunReport& report) {
  proto::ParticipantChannel channel({command.endpoint, command.keys, command.insecure}, wire::FLUID);
  double& compute_s = report.timing("compute");
  double& output_s = report.timing("output");
  try {
    fluid::Fluid<D> fluid(scene);
    fluid::Measures<D> measures;
    FrameWriter frames(command.out, "fluid");
    // The coupler's recorder writes rows on the same schedule and ignores the gauges of other instants: there the last
    // values go with the message once more.
    RowSchedule rows(scene.output.gauge_interval);
    GaugeValues gauges;
    const auto account = [&] {
      if (const Ticks now = fluid.state().time; rows.due(now)) {
        gauges = gauge_values(fluid, scene);
        rows.written(now);
      }
      return proto::account(energy_values(fluid), gauges);
    };

    wire::Hello hello;
    hello.set_case_hash(scene.hash);
    hello.set_dimension(D);
    hello.set_particles(static_cast<std::uint32_t>(fluid.state().size()));
    hello.set_proposed_step_s(fluid.propose_step().seconds);
    hello.set_limit(fluid.propose_step().limit);
    *hello.mutable_account() = account();
    write_frame(fluid, frames, 0);
    channel.handshake(hello);

    const auto report_now = [&] {
      measures.report(fluid, report);
      report.timing("wait") = channel.wait_seconds();
      report.timing("exchange") = channel.exchange_seconds();
      report.set_count("bytes_sent", static_cast<long>(channel.bytes_sent()));
      report.set_count("bytes_received", static_cast<long>(channel.bytes_received()));
    };
    long step = 0, last_frame = 0;
    for (;;) {
      wire::Message order = channel.receive({Kind::kBeginWindow, Kind::kFinish});
      if (order.has_finish()) {
        if (last_frame != step) write_frame(fluid, frames, step);
        report_now();
        wire::Message answer;
        *answer.mutable_finished()->mutable_account() = account();
        channel.send(std::move(answer));
        if (order.finish().interrupted()) throw Interrupted("The run was interrupted; results up to here are kept.");
        return;
      }
      const Ticks begin = order.begin_window().begin_ticks(), duration = order.begin_window().duration_ticks();
      wire::Message message;
      {
        ScopedTimer timer(compute_s);
        fluid.begin_window(begin, duration);
      }
      const Surface<D> surface = proto::from_wire<D>(channel.receive({Kind::kSurface}).surface());
      {
        ScopedTimer timer(compute_s);
        *message.mutable_band() = proto::to_wire<D>(fluid.see_surface(surface));
      }
      channel.send(std::move(message));
      message = channel.receive({Kind::kDissipativeLoad});
      while (message.has_dissipative_load()) {
        const auto load = proto::from_wire<D>(message.dissipative_load());
        message.Clear();
        {
          ScopedTimer timer(compute_s);
          *message.mutable_band_pressure() = proto::to_wire<D>(fluid.solve_pressure(load));
        }
        channel.send(std::move(message));
        message = channel.receive({Kind::kDissipativeLoad, Kind::kBandForce});
      }
      const auto force = proto::from_wire<D>(message.band_force());
      message.Clear();
      {
        ScopedTimer timer(compute_s);
        fluid.end_window(force);
      }
      ++step;
      measures.add(fluid);
      const StepProposal proposal = fluid.propose_step();
      wire::WindowDone& done = *message.mutable_window_done();
      done.set_proposed_step_s(proposal.seconds);
      done.set_limit(proposal.limit);
      done.set_iterations(static_cast<std::uint32_t>(fluid.last_solve().iterations));
      *done.mutable_account() = account();
      channel.send(std::move(message));
      ScopedTimer timer(output_s);
      if (order.begin_window().write_frame()) {
        write_frame(fluid, frames, step);
        last_frame = step;
      }
      report.set_time(seconds(begin + duration), step);
      report_now();
      report.update();
    }
  } catch (const Error& error) {
    channel.abort(error);
    throw;
  }
}

template <int D>
void run(const CommandLine& command, const Case& scene, RunReport& report) {
  if (command.alone())
    run_alone<D>(command, scene, report);
  else
    run_coupled<D>(command, scene, report);
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
