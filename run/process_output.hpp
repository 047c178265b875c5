#pragma once
// What a process does beside its numerics: gauges when a row is due, frames, measures, its report. It asks a Side for them:
//
//   static constexpr const char* role;             "fluid" or "structure", the name of its frames
//   Ticks time() const;
//   GaugeValues gauges() const;                    of the present state
//   std::vector<double> energies() const;          the same
//   void write_frame(FrameWriter&, long step) const;
//   void add_window();                             a window is over: measure it
//   void report(RunReport&) const;
//   Side::for_each_field(visit, sides...);         the list of what add_window() has gathered

#include <utility>
#include <vector>

#include "base/timing.hpp"
#include "run/checkpoint.hpp"
#include "run/command_line.hpp"
#include "run/frame_writer.hpp"
#include "run/recorder.hpp"

namespace tern {

template <class Side>
class ProcessOutput {
 public:
  ProcessOutput(const CommandLine& command, const Case& scene, RunReport& report, Side side)
      : report_(report), side_(std::move(side)), frames_(command.out, Side::role, !command.resume), rows_(scene.output.gauge_interval) {}

  Ticks time() const { return side_.time(); }
  long windows() const { return windows_; }
  std::vector<double> energies() const { return side_.energies(); }

  /// Gauges of the present state where a row is due; at other instants the last ones once more, which nobody records.
  const GaugeValues& gauges() {
    if (const Ticks now = time(); rows_.due(now)) {
      gauges_ = side_.gauges();
      evaluated_gauges_ += static_cast<long>(gauges_.size());
      rows_.written(now);
    }
    return gauges_;
  }

  /// A window is over.
  void count_window() {
    ++windows_;
    side_.add_window();
    report_.set_time(seconds(time()), windows_);
  }

  /// The present state as a frame, unless it is already one.
  void write_frame() {
    if (last_frame_ == windows_) return;
    side_.write_frame(frames_, windows_);
    last_frame_ = windows_;
  }

  /// Measures of the run up to now into the report.
  void report() const {
    side_.report(report_);
    report_.set_evaluations("gauges", evaluated_gauges_);
  }

  /// All of it to a checkpoint, with the report so far.
  void save(StateWriter& file) const {
    for_each_field([&](const char* name, const auto& own) { file(name, own); }, *this);
    file("output/frames", frames_.mark());
    file("output/report", report_.gathered());
  }
  /// Goes back to what save() has written, tables and frames as well.
  void restore(StateReader& file) {
    for_each_field([&](const char* name, auto& own) { file(name, own); }, *this);
    FrameWriter::Mark mark;
    file("output/frames", mark);
    frames_.go_back(mark);
    RunReport::Gathered gathered;
    file("output/report", gathered);
    report_.go_on_from(gathered);
    report_.set_time(seconds(time()), windows_);
    if (GaugeValues present = side_.gauges(); present.size() != gauges_.size()) gauges_ = std::move(present);  // some were added
  }

 private:
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("output/measures", all.side_...);
    visit("output/rows", all.rows_...);
    visit("output/gauges", all.gauges_...);
    visit("output/evaluated_gauges", all.evaluated_gauges_...);
    visit("output/windows", all.windows_...);
    visit("output/last_frame", all.last_frame_...);
  }

  RunReport& report_;
  Side side_;
  FrameWriter frames_;
  RowSchedule rows_;
  GaugeValues gauges_;
  long evaluated_gauges_ = 0, windows_ = 0, last_frame_ = -1;
};

}  // namespace tern
