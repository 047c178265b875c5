#pragma once
// The run of one process alone: steps until the end of the case, tables, frames, progress and report.

#include <string>
#include <vector>

#include "base/interrupt.hpp"
#include "run/process_output.hpp"
#include "run/progress.hpp"

namespace tern {

/// One completed step: its length, what limited it, and the iterations of its pressure solve (negative: none).
struct SoloStep {
  Ticks duration;
  std::string limit;
  int iterations;
};

/// advance(now, target) makes one step from `now` on, at most to `target`, where the next frame is due. Throws Interrupted, with
/// all results written, and what the solver throws.
template <class Side, class Advance>
void run_alone(const CommandLine& command, const Case& scene, RunReport& report, Side side, std::vector<std::string> gauge_columns,
               std::vector<std::string> energy_columns, Advance&& advance) {
  ProcessOutput<Side> output(command, scene, report, std::move(side));
  Recorder recorder(command.out, std::move(gauge_columns), std::move(energy_columns), scene.output.gauge_interval);
  Progress progress(scene.end_time, command.quiet);
  const Ticks end = to_ticks(scene.end_time);
  const FrameSchedule frames(scene.output.frame_interval, end);
  double& output_s = report.timing("output");

  const auto write = [&](bool frame) {
    ScopedTimer timer(output_s);
    if (recorder.due(output.time())) recorder.account(output.time(), output.gauges(), output.energies());
    if (frame) output.write_frame();
    output.report();
    report.update();
  };
  write(true);
  for (Ticks now = 0; now < end;) {
    const Stopwatch watch;
    const Ticks target = frames.next(now);
    const SoloStep step = advance(now, target);
    now += step.duration;
    output.count_window();
    recorder.step(now, step.duration, step.limit, step.iterations, watch.seconds());
    progress.step(seconds(now), output.windows(), seconds(step.duration), step.limit, step.iterations);
    const bool stopping = interrupted();
    write(now == target || stopping);
    if (stopping) progress.finish("interrupted");
    throw_if_interrupted("between two steps");
  }
  progress.finish();
}

}  // namespace tern
