#pragma once
// Wall-clock time of named parts of a run. The name is looked up once (RunReport::timing), the loop only adds to a
// double:
//
//   double& pressure_s = report.timing("pressure");
//   for (...) { ScopedTimer timer(pressure_s); solve(); }

#include <chrono>

namespace tern {

/// Wall seconds since construction or the last restart.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  void restart() { start_ = Clock::now(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

/// Adds the wall seconds of its own life to `total_s`, about 50 ns per use.
class ScopedTimer {
 public:
  explicit ScopedTimer(double& total_s) : total_s_(total_s) {}
  ~ScopedTimer() { total_s_ += watch_.seconds(); }
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;

 private:
  double& total_s_;
  Stopwatch watch_;
};

/// User and system time of this process, all threads [s].
double cpu_seconds();

}  // namespace tern
