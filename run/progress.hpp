#pragma once
// Progress of a run on stdout: on a terminal one line rewritten in place, elsewhere a plain line every 10 s and at the
// end.
//   t = 0.1234 s  12.3 %  step 617  dt 2.0e-04 s (gravity)  CG 7  14.2 ms/step  ETA 1:03
// The rates are smoothed over the last few prints, and of the steps that this process has made: a run that was continued, or taken back,
// has had others before.

#include <cstdio>
#include <string>

#include "base/timing.hpp"

namespace tern {

class Progress {
 public:
  /// quiet: prints nothing at all.
  Progress(double end_time_s, bool quiet);
  /// As above on a given stream; for tests.
  Progress(double end_time_s, bool quiet, std::FILE* stream, bool terminal, double interval_s);
  /// Ends a line left open on a terminal, so that an error sentence starts on its own line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// After each completed step: time reached, number of steps, step size, what limited it, pressure iterations
  /// (negative: no pressure solve in this process). Prints at most five times a second.
  void step(double t_s, long step, double dt_s, const std::string& limit, int iterations);

  /// Last line: time reached, steps, wall time. `ending` says how: "done", "interrupted", "failed".
  void finish(const std::string& ending = "done");

 private:
  std::string line(const std::string& limit) const;
  void print(const std::string& text);

  double end_time_s_;
  bool quiet_, terminal_;
  std::FILE* stream_;
  double interval_s_;
  Stopwatch wall_, since_print_;
  bool open_line_ = false, printed_ = false, finished_ = false;
  double t_s_ = 0, dt_s_ = 0;
  long step_ = 0, steps_before_ = -1;  ///< before this process took the run up; -1: no step yet
  int iterations_ = -1;
  double printed_t_s_ = 0;  ///< at the last print, for the rates
  long printed_step_ = 0;
  double ms_per_step_ = 0, wall_per_time_ = 0;
};

}  // namespace tern
