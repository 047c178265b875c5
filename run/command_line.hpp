#pragma once
// Command line of tern-fluid, tern-structure and tern-coupler, and the frame around their work.

#include <functional>
#include <optional>
#include <string>

#include "run/run_report.hpp"
#include "scene/case_file.hpp"

namespace tern {

struct CommandLine {
  std::string case_path;        ///< a case.toml, its folder, or a name under cases/
  std::string out;              ///< output directory
  std::string endpoint;         ///< ZeroMQ address of the coupler; empty: this process runs alone (never for the coupler)
  std::string keys;             ///< directory of the keys for a network; empty: none
  bool insecure = false;        ///< on a network without keys
  CaseOptions options;          ///< --set and --preset
  std::optional<double> until;  ///< end time instead of the case's [s]
  int threads = 0;              ///< 0: as many as the work is worth (set_threads())
  double deadline_s = 300;      ///< a peer that leaves a message out for so long is given up
  bool force = false;           ///< replace the results of an earlier run in `out`
  bool allow_unstable = false;  ///< run a coupling that is predicted to be unstable
  bool resume = false;          ///< go on from the newest checkpoint in `out`
  /// Windows have failed; StepControl::shorten(). Not of the structure.
  struct Repeat {
    int halvings = 0;
    double until_s = 0, longest_s = 0;
  } repeat;
  bool quiet = false;   ///< no progress lines
  bool record = false;  ///< coupler only: keep what the participants send in `out`/interface.record

  bool alone() const { return endpoint.empty(); }

  /// Not empty for --help and --version: the text to print instead of running.
  std::string answer;
};

/// `role` is "fluid", "structure" or "coupler". Throws BadInput with a sentence for anything it does not understand.
CommandLine parse_command_line(int argc, const char* const* argv, const std::string& role);

using Body = std::function<void(const CommandLine&, const Case&, RunReport&)>;

/// The whole of main(): reads command line and case, prepares the output directory, log, report, signals and threads,
/// runs `body` and turns whatever it throws into an exit code (error.hpp), one sentence on stderr and the report's
/// cause.
/// --until has replaced end_time in the Case that body receives. `body` should call report.set_time and report.update.
int run_main(int argc, char** argv, const std::string& role, const Body& body);

/// To be called by `body` when it knows how many `items` (particles, points of the surface) its loops go over: unless the command line
/// says how many threads, takes as many as they are worth (base/threads.hpp). Results do not depend on it.
void set_threads(const CommandLine& command, std::ptrdiff_t items, RunReport& report);

}  // namespace tern
