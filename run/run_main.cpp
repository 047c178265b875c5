// The frame around the work of one process: from main()'s arguments to the exit code.

#include <fmt/format.h>
#include <omp.h>

#include <cstdio>
#include <filesystem>
#include <new>
#include <system_error>

#include "base/interrupt.hpp"
#include "base/log.hpp"
#include "base/peer_stopped.hpp"
#include "base/threads.hpp"
#include "base/version.hpp"
#include "run/command_line.hpp"

namespace tern {

namespace {

struct Cause {
  ExitCode code;
  std::string sentence;
  bool shorter_windows_may_help = false;
  bool is_of_peer = false;  ///< who says it too
};

/// The exit code and sentence of the exception in flight.
Cause cause_of_current_exception(const std::string& role) {
  try {
    throw;
  } catch (const PeerStopped& stopped) {
    return {.code = stopped.code(), .sentence = stopped.what(), .is_of_peer = true};
  } catch (const Error& error) {
    return {error.code(), error.what(), error.shorter_windows_may_help()};
  } catch (const std::bad_alloc&) {
    return {ExitCode::numerical_failure, fmt::format("The {} process ran out of memory; use a coarser spacing or a smaller domain.", role)};
  } catch (const std::system_error& error) {
    return {ExitCode::input_output, fmt::format("The {} process was refused by the system: {}.", role, error.what())};
  } catch (const std::exception& error) {
    return {ExitCode::numerical_failure, fmt::format("The {} process met an unexpected fault of its own: {}.", role, error.what())};
  } catch (...) {
    return {ExitCode::numerical_failure, fmt::format("The {} process met an unexpected fault of its own.", role)};
  }
}

/// Creates the directory, or refuses one that holds the results of an earlier run of this role.
void prepare_out_dir(const std::string& out, const std::string& role, bool force) {
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error || !std::filesystem::is_directory(out))
    throw InputOutputError(fmt::format("Cannot create the output directory {}: {}; choose another --out.", out,
                                       error ? error.message() : "a file of this name is in the way"));
  if (force) return;
  for (const std::string& file : {fmt::format("report.{}.json", role), fmt::format("{}.h5", role)}) {
    if (std::filesystem::exists(out + "/" + file))
      throw BadInput(fmt::format("{} holds {} of an earlier run; choose another --out, or --force to replace it.", out, file));
  }
}

/// `has_launcher`: the first cause of all processes is said by the launcher.
int end(const Cause& cause, bool has_launcher) {
  if (cause.is_of_peer && has_launcher)
    log_unsaid(cause.sentence);
  else
    log_error(cause.sentence);
  return static_cast<int>(cause.code);
}

int run_in_directory(const CommandLine& command, const Case& scene, const std::string& role, bool has_launcher, const Body& body) {
  RunReport report(command.out, role, omp_get_max_threads());
  report.set_case(scene, command.options);
  int code = 0;
  try {
    report.write();
    body(command, scene, report);
    report.set_done();
  } catch (...) {
    const Cause cause = cause_of_current_exception(role);
    report.set_failure(cause.code, cause.sentence, cause.shorter_windows_may_help);
    code = end(cause, has_launcher);
  }
  try {
    report.write();
  } catch (const Error& error) {
    // The first cause stays the exit code; without one, the lost report is the cause.
    if (code == 0) code = static_cast<int>(error.code());
    log_error(error.what());
  }
  log_info(fmt::format("ends with exit code {} at step {}, t = {:.9g} s", code, report.steps(), report.time_s()));
  return code;
}

}  // namespace

void set_threads(const CommandLine& command, std::ptrdiff_t items, RunReport& report) {
  const int threads = command.threads > 0 ? command.threads : threads_worth(items, omp_get_max_threads());
  omp_set_num_threads(threads);
  report.set_threads(threads);
  log_info(fmt::format("works with {} thread{}", threads, threads == 1 ? "" : "s"));
}

int run_main(int argc, char** argv, const std::string& role, const Body& body) {
  set_log_program("tern-" + role);
  install_interrupt_handler();
  const bool has_launcher = end_with_launcher();
  int code = 0;
  try {
    const CommandLine command = parse_command_line(argc, argv, role);
    if (!command.answer.empty()) {
      std::fputs(command.answer.c_str(), stdout);
      return 0;
    }
    Case scene = read_case(command.case_path, command.options);
    if (command.until) scene.end_time = *command.until;
    prepare_out_dir(command.out, role, command.force || command.resume);
    open_log(command.out, role);
    // Until it is known what the work is worth; what there is to prepare may use all cores.
    const int threads = command.threads > 0 ? command.threads : cores_at_hand();
    omp_set_num_threads(threads);

    std::string arguments;
    for (int i = 0; i < argc; ++i) arguments.append(i ? " " : "").append(argv[i]);
    log_info(fmt::format("{} {} ({}), case {} with hash {}", role, program_version, git_hash, scene.name, scene.hash));
    log_info("started as: " + arguments);
    code = run_in_directory(command, scene, role, has_launcher, body);
  } catch (...) {
    code = end(cause_of_current_exception(role), has_launcher);
  }
  close_log();
  return code;
}

}  // namespace tern
