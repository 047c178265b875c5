// The JSON report of one process.

#include "run/run_report.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/version.hpp"
#include "run/atomic_file.hpp"

namespace tern {

namespace {

constexpr double write_interval_s = 2.0;

std::string build_description() {
#ifdef __OPTIMIZE__
  const char* optimisation = "optimised";
#else
  const char* optimisation = "not optimised";
#endif
#ifdef NDEBUG
  const char* assertions = "assertions off";
#else
  const char* assertions = "assertions on";
#endif
  return fmt::format("g++ {}, {}, {}", __VERSION__, optimisation, assertions);
}

double unix_seconds() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

}  // namespace

RunReport::RunReport(std::string out_dir, std::string role, int threads)
    : path_(std::move(out_dir) + "/report." + role + ".json"), role_(std::move(role)), threads_(threads) {
  for (const char* name : {"compute", "wait", "exchange", "output"}) timing_[name] = 0;
}

void RunReport::set_case(const Case& scene, const CaseOptions& options) {
  case_name_ = scene.name;
  case_path_ = scene.path;
  case_hash_ = scene.hash;
  settings_ = scene.settings;
  end_time_s_ = scene.end_time;
  preset_ = options.preset;
  overrides_.clear();
  for (const auto& [key, value] : options.overrides) overrides_.push_back(key + "=" + value);
}

void RunReport::set_time(double time_s, long steps) {
  time_s_ = time_s;
  steps_ = steps;
}

void RunReport::set_resumed(std::uint64_t step, double time_s) {
  resumed_ = {step, time_s};
  set_time(time_s, static_cast<long>(step));
  write();
}

void RunReport::set_measure(const std::string& name, double value) {
  if (!std::isfinite(value))
    throw NumericalFailure(fmt::format("The measure {} of the {} process is {} at step {}, t = {:.9g} s; the computation has diverged.",
                                       name, role_, value, steps_, time_s_));
  measures_[name] = value;
}

void RunReport::set_count(const std::string& name, long value) { counts_[name] = value; }
void RunReport::set_evaluations(const std::string& term, long count) { evaluations_[term] = count; }

void RunReport::set_ranks(std::vector<Rank> ranks) { ranks_ = std::move(ranks); }
bool RunReport::due() const { return since_write_.seconds() >= write_interval_s; }

double& RunReport::timing(const std::string& name) { return timing_[name]; }

void RunReport::set_failure(ExitCode code, const std::string& cause, bool shorter_windows_may_help) {
  if (exit_code_ != 0) return;
  status_ = code == ExitCode::interrupted ? "interrupted" : "failed";
  exit_code_ = static_cast<int>(code);
  cause_ = cause;
  cause_time_ = unix_seconds();
  shorter_windows_may_help_ = shorter_windows_may_help;
}

void RunReport::set_done() {
  if (exit_code_ == 0) status_ = "done";
}

void RunReport::write() {
  write_with_room(path_, json());
  since_write_.restart();
}

void RunReport::update() {
  if (due()) write();
}

RunReport::Gathered RunReport::gathered() const {
  Gathered all{timing_, measures_, counts_, evaluations_};
  for (const auto& [part, seconds] : earlier_.timing) all.timing[part] += seconds;
  return all;
}

void RunReport::go_on_from(const Gathered& earlier) {
  earlier_ = earlier;
  measures_ = earlier.measures;
  counts_ = earlier.counts;
  evaluations_ = earlier.evaluations;
}

std::string RunReport::json() const {
  using Json = nlohmann::ordered_json;
  Json settings = Json::parse(settings_, nullptr, false);
  if (settings.is_discarded()) settings = settings_;
  Json report = {{"role", role_},
                 {"status", status_},
                 {"exit_code", exit_code_},
                 {"process_id", ::getpid()},
                 {"cause", cause_},
                 {"cause_time", cause_time_},
                 {"shorter_windows_may_help", shorter_windows_may_help_},
                 {"case", case_name_},
                 {"case_path", case_path_},
                 {"case_hash", case_hash_},
                 {"preset", preset_},
                 {"overrides", overrides_},
                 {"settings", std::move(settings)},
                 {"version", program_version},
                 {"git", git_hash},
                 {"build", build_description()},
                 {"threads", threads_},
                 {"wall_s", wall_.seconds()},
                 {"cpu_s", cpu_seconds()},
                 {"steps", steps_},
                 {"time_s", time_s_},
                 {"end_time_s", end_time_s_},
                 {"timing_s", gathered().timing},
                 {"measures", measures_},
                 {"counts", counts_},
                 {"evaluations", evaluations_}};
  if (!ranks_.empty()) {
    report["ranks"] = Json::array();
    for (const Rank& rank : ranks_)
      report["ranks"].push_back({{"machine", rank.machine},
                                 {"particles", rank.particles},
                                 {"ghosts", rank.ghosts},
                                 {"cpu_s", rank.cpu_s},
                                 {"waiting_s", rank.waiting_s},
                                 {"peak_memory_bytes", rank.peak_memory_bytes}});
  }
  if (resumed_) report["resumed"] = {{"step", resumed_->first}, {"time_s", resumed_->second}};
  // A path or a cause may hold bytes that are not UTF-8; a report with a replaced letter is better than none.
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tern
