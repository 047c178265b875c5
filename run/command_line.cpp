// Options of the three executables, parsed by CLI11.

#include "run/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <tuple>

#include "base/error.hpp"
#include "base/version.hpp"

namespace tern {

namespace {

constexpr int most_threads = 256;
constexpr int most_halvings = 10;

std::string description(const std::string& role) {
  if (role == "fluid") return "The incompressible-SPH fluid process of tern. Without --endpoint it runs alone.";
  if (role == "structure") return "The total-Lagrangian-SPH structure process of tern. Without --endpoint it runs alone.";
  return "The coupler process of tern: owns time and everything between fluid and structure.";
}

std::string examples(const std::string& program) {
  return fmt::format(
      "Examples:\n"
      "  {0} cases/dam_break_plate --out runs/a --endpoint ipc:///tmp/tern.sock\n"
      "  {0} cases/dam_break_plate --out runs/b --endpoint tcp://127.0.0.1:5555 --until 0.1 --set fluid.spacing=0.008\n"
      "Exit codes: 0 done, 2 bad input, 3 numerical failure, 4 peer lost or timed out, 5 input/output, 130 "
      "interrupted.\n"
      "All quantities are in SI units. ./tern run CASE starts all processes of a case; ./tern check CASE validates it.",
      program);
}

std::pair<std::string, std::string> key_and_value(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw BadInput(fmt::format("--set {} is not of the form table.key=value; write for example --set fluid.spacing=0.008.", text));
  return {text.substr(0, equals), text.substr(equals + 1)};
}

}  // namespace

CommandLine parse_command_line(int argc, const char* const* argv, const std::string& role) {
  const std::string program = "tern-" + role;
  CommandLine result;
  std::vector<std::string> overrides;
  double until = 0;
  std::tuple<int, double, double> repeat{0, 0.0, 0.0};

  CLI::App app(description(role), program);
  app.footer(examples(program));
  app.set_version_flag("--version", fmt::format("{} {} ({})", program, program_version, git_hash));
  app.get_formatter()->column_width(34);
  app.add_option("CASE", result.case_path, "case.toml, its folder, or the name of a folder under cases/")->required()->type_name("");
  app.add_option("--out", result.out, "directory of the results, created if missing")->required()->type_name("DIR");
  auto* endpoint =
      app.add_option("--endpoint", result.endpoint, "ZeroMQ address of the coupler, ipc://PATH or tcp://HOST:PORT")->type_name("ADDRESS");
  if (role == "coupler") endpoint->required();
  app.add_option("--keys", result.keys, "directory of this role's keys, made by ./tern keys: encrypts and authenticates")->type_name("DIR");
  app.add_flag("--insecure", result.insecure, "use a network address without keys");
  app.add_option("--set", overrides, "override a key of the case; may be repeated")->type_name("KEY=VALUE")->allow_extra_args(false);
  app.add_option("--preset", result.options.preset, "numerical settings as a group")->type_name("NAME");
  auto* end = app.add_option("--until", until, "end at this simulated time [s] instead of the case's end_time")->type_name("T");
  auto* threads =
      app.add_option("--threads", result.threads, "threads of this process; results do not depend on it (default: what its work is worth)")
          ->type_name("N");
  app.add_option("--deadline", result.deadline_s,
                 role == "coupler" ? "give a participant up that leaves a message out for S seconds (default 300)"
                                   : "give the coupler up that leaves a message out for 2 S seconds (default S = 300): it waits itself")
      ->type_name("S");
  app.add_flag("--force", result.force, "replace the results of an earlier run in DIR");
  app.add_flag("--resume", result.resume, "go on from the newest checkpoint in DIR; all processes of the run have to");
  if (role != "structure")
    app.add_option("--repeat", repeat,
                   "up to the time T [s] windows of at most L [s], where others 2^N as long have failed (./tern run asks)")
        ->type_name("N T L");
  app.add_flag("--allow-unstable", result.allow_unstable, "run the explicit coupling although the added mass predicts that it is unstable");
  app.add_flag("--quiet", result.quiet, "no progress lines");
  if (role == "coupler") app.add_flag("--record", result.record, "write every message of the participants to DIR/interface.record");

  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    result.answer = app.help();
    return result;
  } catch (const CLI::CallForVersion&) {
    result.answer = app.version() + "\n";
    return result;
  } catch (const CLI::ParseError& error) {
    throw BadInput(fmt::format("Command line: {}; see {} --help.", error.what(), program));
  }

  for (const std::string& text : overrides) result.options.overrides.push_back(key_and_value(text));
  if (end->count() > 0) {
    if (!(until > 0 && until < 1e6))
      throw BadInput(fmt::format("--until {} is not a time between 0 and 1e6 s; give the simulated time at which to end.", until));
    result.until = until;
  }
  if (threads->count() > 0 && (result.threads < 1 || result.threads > most_threads))
    throw BadInput(
        fmt::format("--threads {} is not between 1 and {}; give the number of cores for this process.", result.threads, most_threads));
  result.repeat = {std::get<0>(repeat), std::get<1>(repeat), std::get<2>(repeat)};
  if (const auto& [halvings, until_s, longest_s] = result.repeat;
      halvings < 0 || halvings > most_halvings || !(until_s >= 0 && until_s < 1e6) || !(longest_s >= 0) || (halvings > 0 && longest_s == 0))
    throw BadInput(fmt::format("--repeat {} {} {} is not a number of halvings up to {}, a time up to 1e6 s, and a length of windows in s.",
                               halvings, until_s, longest_s, most_halvings));
  if (result.endpoint.empty() && (!result.keys.empty() || result.insecure))
    throw BadInput(fmt::format("--keys and --insecure are about the connection to a coupler; add --endpoint to {}.", program));
  if (!(result.deadline_s >= 1 && result.deadline_s <= 1e6))
    throw BadInput(
        fmt::format("--deadline {} is not a time between 1 and 1e6 s; give the longest that one answer may take.", result.deadline_s));
  if (role == "coupler" && result.endpoint.empty())
    throw BadInput("--endpoint is empty; give the address the coupler shall bind, for example ipc:///tmp/tern.sock.");
  return result;
}

}  // namespace tern
