#pragma once
// The run of one process alone: steps until the end of the case, tables, frames, progress and report.

#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/interrupt.hpp"
#include "base/log.hpp"
#include "run/checkpoint.hpp"
#include "run/process_output.hpp"
#include "run/progress.hpp"

namespace tern {

/// One completed step: its length, what limited it, and the iterations of its pressure solve (negative: none).
struct SoloStep {
  Ticks duration;
  std::string limit;
  int iterations;
};

/// `solver` makes the steps:
///
///   SoloStep advance(Ticks now, Ticks target);      one step from `now` on, at most to `target`, where the next frame is due
///   void save(StateWriter&) const;                  all from which it goes on
///   void restore(StateReader&);
///
/// Throws Interrupted, with all results written, and what the solver throws. After a failure the state before it is kept.
template <class Side, class Solver>
void run_alone(const CommandLine& command, const Case& scene, RunReport& report, Side side, std::vector<std::string> gauge_columns,
               std::vector<std::string> energy_columns, Solver& solver) {
  ProcessOutput<Side> output(command, scene, report, std::move(side));
  Recorder recorder(command.out, std::move(gauge_columns), std::move(energy_columns), scene.output.gauge_interval, !command.resume);
  Progress progress(scene.end_time, command.quiet);
  const Ticks end = to_ticks(scene.end_time);
  const FrameSchedule frames(scene.output.frame_interval, end);
  double& output_s = report.timing("output");
  const CheckpointStore checkpoints(command.out, Side::role, scene);
  CheckpointClock clock(scene.output.checkpoint_interval);

  const auto write = [&](bool frame) {
    ScopedTimer timer(output_s);
    if (recorder.due(output.time())) recorder.account(output.time(), output.gauges(), output.energies());
    if (frame) output.write_frame();
    output.report();
    report.update();
  };
  KeptStates kept;
  const auto step_now = [&] { return static_cast<std::uint64_t>(output.windows()); };
  const auto gather = [&](StateWriter& state) {
    solver.save(state);
    output.save(state);
    state("recorder", recorder.mark());
  };
  const auto complete_set = [&](std::uint64_t step, double time_s, const std::string& hash) {
    ScopedTimer timer(output_s);
    recorder.sync();
    checkpoints.write_manifest({step, time_s, {{Side::role, hash}}});
    clock.saved();
  };
  const auto save = [&] {
    ScopedTimer timer(output_s);
    complete_set(step_now(), seconds(output.time()), checkpoints.save(step_now(), kept.with_state(gather)));
  };
  const auto save_before_failure = [&](const Error& error) {
    if (const Kept& own = kept.before(error); own.step > 0) complete_set(own.step, own.time_s, checkpoints.save_kept(own));
  };
  if (command.resume) {
    const Manifest manifest = checkpoints.choose({{Side::role, checkpoints.files()}});
    checkpoints.load(manifest.step, [&](StateReader& file) {
      solver.restore(file);
      output.restore(file);
      Recorder::Mark mark;
      file("recorder", mark);
      recorder.go_back(mark);
      if (clock.on()) kept.go_on_from(file, manifest.step, manifest.time_s);
    });
    report.set_resumed(manifest.step, manifest.time_s);
    log_info(fmt::format("goes on from the checkpoint of step {}, t = {:.9g} s", manifest.step, manifest.time_s));
  } else {
    checkpoints.clear();
    write(true);
  }
  const auto advance = [&](Ticks now, Ticks target) {
    const Stopwatch watch;
    const SoloStep step = solver.advance(now, target);
    now += step.duration;
    output.count_window();
    recorder.step(now, step.duration, step.limit, step.iterations, watch.seconds());
    progress.step(seconds(now), output.windows(), seconds(step.duration), step.limit, step.iterations);
    write(now == target);
    if (clock.on() && KeptStates::due(step_now())) {
      ScopedTimer timer(output_s);
      kept.keep(step_now(), seconds(now), gather);
    }
    return now;
  };
  for (Ticks now = output.time(); now < end;) {
    try {
      now = advance(now, frames.next(now, solver.last_window()));
    } catch (const Error& error) {
      if (state_was_sound(error)) keep_after_failure([&] { save_before_failure(error); });
      throw;
    }
    const bool stopping = interrupted();
    if (clock.due() || (clock.on() && (stopping || now >= end))) save();
    if (stopping) write(true);
    if (stopping) progress.finish("interrupted");
    throw_if_interrupted("between two steps");
  }
  progress.finish();
}

}  // namespace tern
