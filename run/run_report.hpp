#pragma once
// What one process reports about its run: DIR/report.<role>.json, rewritten while it runs and at the end.
// The launcher merges the reports of all processes into run.json.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/timing.hpp"
#include "scene/case_file.hpp"

namespace tern {

class RunReport {
 public:
  /// `role` is "fluid", "structure" or "coupler". Writes nothing yet.
  RunReport(std::string out_dir, std::string role, int threads);

  /// Threads of the process, if they are not those of the constructor.
  void set_threads(int threads) { threads_ = threads; }

  /// Records name, hash, settings and end time of the case and the overrides that led to them.
  void set_case(const Case& scene, const CaseOptions& options);

  /// Where the run is: simulated time [s] and number of completed steps.
  void set_time(double time_s, long steps);
  long steps() const { return steps_; }
  double time_s() const { return time_s_; }

  /// The checkpoint that the run goes on from; without one the report has no key "resumed". Writes the file: the launcher has to know
  /// also of a process that is killed next. Throws InputOutputError.
  void set_resumed(std::uint64_t step, double time_s);

  /// Results by name, replaced on every call. Throws NumericalFailure naming the measure if not finite.
  void set_measure(const std::string& name, double value);
  void set_count(const std::string& name, long value);
  /// How often a term of the model was evaluated since the begin (docs/ARCHITECTURE.md); 0 where the case leaves it out.
  void set_evaluations(const std::string& term, long count);

  /// Of a process that is many: what each of them has to do and has spent, since it began. An empty list says nothing.
  struct Rank {
    std::string machine;
    long particles, ghosts;   ///< own ones, and copies of those of others
    double cpu_s, waiting_s;  ///< waiting: wall seconds in calls to the others
    long peak_memory_bytes;
  };
  void set_ranks(std::vector<Rank> ranks);
  /// update() will write now.
  bool due() const;

  /// Accumulated wall seconds of a part of the run. The reference stays valid for the life of the report: look it up
  /// once, add with ScopedTimer. Names compute, wait, exchange and output exist from the start.
  double& timing(const std::string& name);
  void add_time(const std::string& name, double seconds) { timing(name) += seconds; }

  /// First cause of the end; later calls change nothing. `shorter_windows_may_help`: for the launcher, which then has them repeated.
  void set_failure(ExitCode code, const std::string& cause, bool shorter_windows_may_help = false);
  /// Status "done", unless a failure was set.
  void set_done();

  /// Writes the file atomically. Throws InputOutputError.
  void write();
  /// Writes if the last write is 2 s old; cheap enough for every step.
  void update();

  /// What it has gathered, by the parts of a run before this one as well. Wall and CPU time are of this part: the launcher adds them up,
  /// with what was computed in vain.
  struct Gathered {
    std::map<std::string, double> timing, measures;
    std::map<std::string, long> counts, evaluations;

    /// The list of the members: visit(name, member of each) for every one.
    template <class Visit, class... Same>
    static void for_each_field(Visit&& visit, Same&... all) {
      visit("timing", all.timing...);
      visit("measures", all.measures...);
      visit("counts", all.counts...);
      visit("evaluations", all.evaluations...);
    }
  };
  Gathered gathered() const;
  /// Goes on from what the earlier parts of a run have gathered.
  void go_on_from(const Gathered& earlier);

  /// The report as JSON text, as written.
  std::string json() const;

 private:
  std::string path_, role_;
  int threads_;
  std::string status_ = "running", cause_;
  int exit_code_ = 0;
  double cause_time_ = 0;
  bool shorter_windows_may_help_ = false;
  std::string case_name_, case_path_, case_hash_, settings_ = "{}", preset_;
  std::vector<std::string> overrides_;
  double time_s_ = 0, end_time_s_ = 0;
  long steps_ = 0;
  std::optional<std::pair<std::uint64_t, double>> resumed_;  ///< step and time [s] of the checkpoint
  std::map<std::string, double> timing_, measures_;
  std::map<std::string, long> counts_, evaluations_;
  std::vector<Rank> ranks_;
  Gathered earlier_;
  Stopwatch wall_, since_write_;
};

}  // namespace tern
