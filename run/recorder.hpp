#pragma once
// The tables of a run (gauges.csv, energy.csv, steps.csv), written by the process that sees all accounts: the coupler, or
// the only process there is.

#include <string>
#include <vector>

#include "base/step_control.hpp"
#include "base/time.hpp"
#include "run/table_writer.hpp"
#include "scene/gauges.hpp"

namespace tern {

/// Instants at which rows are due: the first at or after every multiple of the interval [s], to the nearest tick; 0 = every instant.
class RowSchedule {
 public:
  explicit RowSchedule(double interval) : interval_(interval) {}
  bool due(Ticks now) const { return now >= next_; }
  /// A row has been written at `now`.
  void written(Ticks now);

  /// The list of what changes: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("next", all.next_...);
  }

 private:
  double interval_;
  Ticks next_ = 0;
};

class Recorder {
 public:
  /// Creates the three files in `directory`; gauge_interval [s], 0 = every step. Not `anew`: they are there, and go_back() follows.
  Recorder(const std::string& directory, std::vector<std::string> gauge_columns, std::vector<std::string> energy_columns,
           double gauge_interval, bool anew = true);

  /// True when account() would write a row at `now`; no need to evaluate gauges otherwise.
  bool due(Ticks now) const { return rows_.due(now); }

  /// Values at time `now`, written when a row is due.
  void account(Ticks now, const GaugeValues& gauges, const std::vector<double>& energies);

  /// One step that has just been completed. `iterations` < 0: no pressure solve.
  void step(Ticks now, Ticks duration, const std::string& limit, int iterations, double wall_seconds);

  void flush();

  /// Where the tables are, to come back to.
  struct Mark {
    std::uint64_t gauge_lines = 0;        ///< for columns may be added
    std::uint64_t energy = 0, steps = 0;  ///< [bytes]
    RowSchedule rows{0};

    /// The list of the members: visit(name, member of each) for every one.
    template <class Visit, class... Same>
    static void for_each_field(Visit&& visit, Same&... all) {
      visit("gauge_lines", all.gauge_lines...);
      visit("energy", all.energy...);
      visit("steps", all.steps...);
      visit("rows", all.rows...);
    }
  };
  Mark mark() const { return {gauges_.lines(), energy_.length(), steps_.length(), rows_}; }
  /// Brings everything up to here to the disk. Throws InputOutputError, as go_back() does.
  void sync();
  void go_back(const Mark& mark);

 private:
  TableWriter gauges_, energy_, steps_;
  RowSchedule rows_;
};

/// The first tick after `now` that is a multiple of the interval [s], as nearly as ticks can be.
Ticks next_multiple(double interval, Ticks now);

/// Times at which frames are due: every interval from 0 and the end. One that would be due less than half an interval before the end is
/// left out: the last window would be cut short between the two.
class FrameSchedule {
 public:
  FrameSchedule(double interval, Ticks end) : interval_(interval), end_(end) {}
  /// The next instant after `now` that a window must end at. `last_window`: the window before is much longer than what is left to the next
  /// frame where a run goes on from an end between frames, which has one of its own. That frame is left out.
  Ticks next(Ticks now, Ticks last_window = 0) const;

 private:
  double interval_;
  Ticks end_;
};

}  // namespace tern
