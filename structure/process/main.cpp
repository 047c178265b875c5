// tern-structure: the elastic bodies of a scene, alone or as one of three processes.

#include <algorithm>

#include "base/error.hpp"
#include "base/interrupt.hpp"
#include "base/timing.hpp"
#include "proto/participant/participant.hpp"
#include "proto/wire/account.hpp"
#include "run/command_line.hpp"
#include "run/progress.hpp"
#include "run/recorder.hpp"
#include "scene/estimate.hpp"
#include "structure/coupled_structure.hpp"
#include "structure/process/output.hpp"

namespace {

using namespace tern;

/// The whole run in this process, without surface load.
template <int D>
void run_alone(const CommandLine& command, const Case& scene, RunReport& report) {
  structure::Structure<D> structure(scene);
  const structure::StructureGauges<D> gauges(scene, structure);
  structure::Measures measures;
  FrameWriter frames(command.out, "structure");
  Recorder recorder(command.out, gauge_columns(scene, GaugeOwner::structure), structure_energy_columns(scene), scene.output.gauge_interval);
  Progress progress(scene.end_time, command.quiet);
  const Ticks end = to_ticks(scene.end_time);
  const FrameSchedule frame_times(scene.output.frame_interval, end), gauge_times(scene.output.gauge_interval, end);
  double& compute_s = report.timing("compute");
  double& output_s = report.timing("output");

  const double window = sub_steps_per_window(scene);
  long step = 0, evaluated_gauges = 0;
  const auto write_output = [&](bool frame) {
    ScopedTimer timer(output_s);
    const GaugeValues values = gauges.values(structure);
    report.set_evaluations("gauges", evaluated_gauges += static_cast<long>(values.size()));
    recorder.account(structure.time(), values, structure::energy_values(scene, structure));
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

/// The structure as one of three processes: what proto/participant/participant.hpp asks of a solver.
template <int D>
class Participant {
 public:
  Participant(const CommandLine& command, const Case& scene, RunReport& report, const proto::ParticipantChannel& channel)
      : scene_(scene),
        report_(report),
        channel_(channel),
        structure_(scene),
        coupled_(structure_, scene.coupling.algorithm),
        gauges_(scene, structure_),
        frames_(command.out, "structure") {}

  wire::Hello hello() {
    wire::Hello hello;
    hello.set_case_hash(scene_.hash);
    hello.set_dimension(D);
    hello.set_particles(static_cast<std::uint32_t>(structure_.particles()));
    *hello.mutable_surface() = proto::to_wire(structure_.surface_properties());
    *hello.mutable_account() = account();
    write_frame();
    return hello;
  }
  wire::Account account() {
    ScopedTimer timer(compute_s_);
    const GaugeValues values = gauges_.values(structure_);
    evaluated_gauges_ += static_cast<long>(values.size());
    return proto::account(structure::energy_values(scene_, structure_), values);
  }

  Surface<D> predict_surface(Ticks begin, Ticks duration) {
    ScopedTimer timer(compute_s_), of_it(trial_s_);
    return coupled_.predict_surface(begin, duration);
  }
  std::vector<Vector<D>> respond(const SurfaceLoad<D>& load) {
    ScopedTimer timer(compute_s_), of_it(trial_s_);
    return coupled_.respond(load);
  }
  void apply(const SurfaceLoad<D>& load) {
    ScopedTimer timer(compute_s_);
    coupled_.apply(load);
  }

  void end_window(const proto::Window& window) {
    ++step_;
    measures_.add(structure_);
    ScopedTimer timer(output_s_);
    if (window.write_frame) write_frame();
    report_.set_time(seconds(window.end()), step_);
    report_now();
    report_.update();
  }
  void finish() {
    if (last_frame_ != step_) write_frame();
    report_now();
  }

 private:
  void write_frame() {
    structure::write_frame(structure_, frames_, step_);
    last_frame_ = step_;
  }
  void report_now() {
    measures_.report(structure_, report_);
    report_.set_evaluations("gauges", evaluated_gauges_);
    proto::report_traffic(channel_, report_);
  }

  const Case& scene_;
  RunReport& report_;
  const proto::ParticipantChannel& channel_;
  double& compute_s_ = report_.timing("compute");
  double& trial_s_ = report_.timing("compute.trial");  ///< passes over a window but the last
  double& output_s_ = report_.timing("output");
  structure::Structure<D> structure_;
  structure::CoupledStructure<D> coupled_;
  structure::StructureGauges<D> gauges_;
  structure::Measures measures_;
  FrameWriter frames_;
  long step_ = 0, last_frame_ = 0, evaluated_gauges_ = 0;
};

template <int D>
void run(const CommandLine& command, const Case& scene, RunReport& report) {
  if (command.alone()) return run_alone<D>(command, scene, report);
  proto::ParticipantChannel channel({command.endpoint, command.keys, command.insecure}, wire::STRUCTURE, 300, 2 * command.deadline_s);
  proto::telling_the_coupler(channel, [&] {
    Participant<D> participant(command, scene, report, channel);
    proto::take_part_as_structure<D>(channel, participant);
  });
}

}  // namespace

int main(int argc, char** argv) {
  return run_main(argc, argv, "structure", [](const CommandLine& command, const Case& scene, RunReport& report) {
    if (!scene.structure) throw BadInput(scene.path + " has no [[structure.body]], so there is nothing for tern-structure to do.");
    if (command.alone() && scene.fluid)
      throw BadInput(scene.path + " has a [fluid] table: start tern-structure with --endpoint, or use ./tern run.");
    scene.dimension == 2 ? run<2>(command, scene, report) : run<3>(command, scene, report);
  });
}
