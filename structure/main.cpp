// tern-structure: the elastic bodies of a scene, alone or as one of three processes.

#include <algorithm>

#include "particles/case_estimate.hpp"
#include "particles/command_line.hpp"
#include "particles/error.hpp"
#include "particles/interrupt.hpp"
#include "particles/progress.hpp"
#include "particles/recorder.hpp"
#include "particles/timing.hpp"
#include "proto/account.hpp"
#include "proto/channel.hpp"
#include "proto/convert.hpp"
#include "structure/coupled_structure.hpp"
#include "structure/output.hpp"

namespace {

using namespace tern;
using proto::Kind;

/// The whole run in this process, without surface load.
template <int D>
void run_alone(const CommandLine& command, const Case& scene, RunReport& report) {
  structure::Structure<D> structure(scene);
  const structure::StructureGauges<D> gauges(scene, structure);
  structure::Measures measures;
  FrameWriter frames(command.out, "structure");
  Recorder recorder(command.out, gauge_columns(scene, GaugeOwner::structure), structure_energy_columns(scene),
                    scene.output.gauge_interval);
  Progress progress(scene.end_time, command.quiet);
  const Ticks end = to_ticks(scene.end_time);
  const FrameSchedule frame_times(scene.output.frame_interval, end), gauge_times(scene.output.gauge_interval, end);
  double& compute_s = report.timing("compute");
  double& output_s = report.timing("output");

  const double window = sub_steps_per_window(scene);
  long step = 0;
  const auto write_output = [&](bool frame) {
    ScopedTimer timer(output_s);
    recorder.account(structure.time(), gauges.values(structure), structure::energy_values(scene, structure));
    if (frame) structure::write_frame(structure, frames, step);
    measures.report(structure, report);
    report.update();
  };
  write_output(true);
  for (Ticks now = 0; now < end;) {
    const Stopwatch watch;
    const Ticks frame_time = frame_times.next(now);
    const Ticks left = std::min(frame_time, gauge_times.next(now)) - now;
    const auto windows = static_cast<Ticks>(seconds(left) / (window * structure.largest_sub_step())) + 1;
    const Ticks duration = std::max<Ticks>(left / windows, 1);
    {
      ScopedTimer timer(compute_s);
      structure.trial(now, duration);
    }
    now += duration;
    ++step;
    measures.add(structure);
    report.set_time(seconds(now), step);
    recorder.step(now, duration, "output", -1, watch.seconds());
    progress.step(seconds(now), step, seconds(duration), "output", -1);
    const bool stopping = interrupted();
    write_output(now == frame_time || stopping);
    if (stopping) progress.finish("interrupted");
    throw_if_interrupted("between two windows");
  }
  progress.finish();
}

/// One of three processes: obeys the coupler's windows.
template <int D>
void run_coupled(const CommandLine& command, const Case& scene, RunReport& report) {
  proto::ParticipantChannel channel({command.endpoint, command.keys, command.insecure}, wire::STRUCTURE);
  double& compute_s = report.timing("compute");
  double& output_s = report.timing("output");
  try {
    structure::Structure<D> structure(scene);
    structure::CoupledStructure<D> coupled(structure, scene.coupling.algorithm);
    const structure::StructureGauges<D> gauges(scene, structure);
    structure::Measures measures;
    FrameWriter frames(command.out, "structure");
    const auto account = [&] {
      return proto::account(structure::energy_values(scene, structure), gauges.values(structure));
    };

    wire::Hello hello;
    hello.set_case_hash(scene.hash);
    hello.set_dimension(D);
    hello.set_particles(static_cast<std::uint32_t>(structure.particles()));
    *hello.mutable_surface() = proto::to_wire(structure.surface_properties());
    *hello.mutable_account() = account();
    structure::write_frame(structure, frames, 0);
    channel.handshake(hello);

    const auto report_now = [&] {
      measures.report(structure, report);
      report.timing("wait") = channel.wait_seconds();
      report.timing("exchange") = channel.exchange_seconds();
      report.set_count("bytes_sent", static_cast<long>(channel.bytes_sent()));
      report.set_count("bytes_received", static_cast<long>(channel.bytes_received()));
    };
    long step = 0, last_frame = 0;
    for (;;) {
      const wire::Message order = channel.receive({Kind::kBeginWindow, Kind::kFinish});
      wire::Message message;
      if (order.has_finish()) {
        if (last_frame != step) structure::write_frame(structure, frames, step);
        report_now();
        *message.mutable_finished()->mutable_account() = account();
        channel.send(std::move(message));
        if (order.finish().interrupted()) throw Interrupted("The run was interrupted; results up to here are kept.");
        return;
      }
      const Ticks begin = order.begin_window().begin_ticks(), duration = order.begin_window().duration_ticks();
      {
        ScopedTimer timer(compute_s);
        const wire::Account at_begin = account();
        *message.mutable_surface() = proto::to_wire<D>(coupled.predict_surface(begin, duration));
        *message.mutable_surface()->mutable_account() = at_begin;
      }
      channel.send(std::move(message));
      for (;;) {
        const wire::Message answer = channel.receive({Kind::kSurfaceLoad});
        const auto load = proto::from_wire<D>(answer.surface_load());
        ScopedTimer timer(compute_s);
        if (!answer.surface_load().trial()) {
          coupled.apply(load);
          break;
        }
        *message.mutable_surface_velocity() = proto::to_wire<D>(coupled.respond(load));
        channel.send(message);
      }
      ++step;
      measures.add(structure);
      ScopedTimer timer(output_s);
      if (order.begin_window().write_frame()) {
        structure::write_frame(structure, frames, step);
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
  return run_main(argc, argv, "structure", [](const CommandLine& command, const Case& scene, RunReport& report) {
    if (!scene.structure)
      throw BadInput(scene.path + " has no [[structure.body]], so there is nothing for tern-structure to do.");
    if (command.alone() && scene.fluid)
      throw BadInput(scene.path + " has a [fluid] table: start tern-structure with --endpoint, or use ./tern run.");
    scene.dimension == 2 ? run<2>(command, scene, report) : run<3>(command, scene, report);
  });
}
