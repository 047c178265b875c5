// From whatever a process meets to its exit code, its sentence and its report. Each run is a process of its own,
// because signals, the log and the number of threads belong to the whole process.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/interrupt.hpp"
#include "base/log.hpp"
#include "fixtures/scratch_directory.hpp"
#include "run/command_line.hpp"

namespace tern {
namespace {

const std::string case_path = std::string(TERN_SOURCE_DIR) + "/cases/hydrostatic_tank";

struct Outcome {
  int code = -1;
  std::string error;      ///< stderr
  nlohmann::json report;  ///< null if there is none
};

Outcome run(const ScratchDirectory& dir, std::vector<std::string> arguments, const Body& body) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (std::freopen((dir / "stderr").c_str(), "w", stderr) == nullptr) _exit(99);
    arguments.insert(arguments.begin(), "tern-fluid");
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    const int code = run_main(static_cast<int>(pointers.size()), pointers.data(), "fluid", body);
    std::fflush(nullptr);
    _exit(code);
  }
  int status = 0;
  waitpid(child, &status, 0);
  Outcome outcome;
  if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
  outcome.error = text_of(dir / "stderr");
  if (std::filesystem::exists(dir / "out/report.fluid.json"))
    outcome.report = nlohmann::json::parse(text_of(dir / "out/report.fluid.json"));
  return outcome;
}

// Seen to fail with set_done left out (status stays "running"), and with --until not handed on.
TEST(RunMain, RunsTheBodyAndReportsDone) {
  const ScratchDirectory dir;
  const Outcome outcome =
      run(dir, {case_path, "--out", dir / "out", "--until", "0.25"}, [](const auto& command, const Case& scene, RunReport& report) {
        if (scene.end_time != 0.25 || !command.alone()) throw std::logic_error("wrong input");
        log_info("half way");
        report.set_time(0.25, 3);
      });
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_EQ(outcome.error, "");
  EXPECT_EQ(outcome.report["status"], "done");
  EXPECT_EQ(outcome.report["steps"], 3);
  EXPECT_EQ(outcome.report["end_time_s"], 0.25);
  EXPECT_FALSE(std::string(outcome.report["case_hash"]).empty());
  EXPECT_NE(text_of(dir / "out/fluid.log").find("half way"), std::string::npos);
}

// Seen to fail with every Error ending in code 3, and with the code of bad_alloc changed.
TEST(RunMain, TurnsEveryExceptionIntoItsExitCodeAndOneSentence) {
  const auto expect = [](const std::function<void()>& fault, int code, const std::string& sentence) {
    const ScratchDirectory dir;
    const Outcome outcome = run(dir, {case_path, "--out", dir / "out"}, [&](auto&&...) { fault(); });
    EXPECT_EQ(outcome.code, code) << sentence;
    EXPECT_EQ(outcome.error, "tern-fluid: " + sentence + "\n");
    EXPECT_EQ(outcome.report["cause"], sentence);
    EXPECT_EQ(outcome.report["exit_code"], code);
  };
  expect([] { throw BadInput("No."); }, 2, "No.");
  expect([] { throw NumericalFailure("J is 0."); }, 3, "J is 0.");
  expect([] { throw PeerLost("Gone."); }, 4, "Gone.");
  expect([] { throw InputOutputError("Full."); }, 5, "Full.");
  expect([] { throw std::bad_alloc(); }, 3, "The fluid process ran out of memory; use a coarser spacing or a smaller domain.");
  expect([] { throw std::logic_error("odd"); }, 3, "The fluid process met an unexpected fault of its own: odd.");
  expect([] { throw 1; }, 3, "The fluid process met an unexpected fault of its own.");
}

// Seen to fail without the handler (the process dies of the signal and reports nothing), and with SIGPIPE not ignored.
TEST(RunMain, EndsWith130AndAReportWhenInterrupted) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const ScratchDirectory dir;
    const Outcome outcome = run(dir, {case_path, "--out", dir / "out"}, [signal](auto&&...) {
      if (interrupted()) throw std::logic_error("too early");
      raise(SIGPIPE);
      raise(signal);
      throw_if_interrupted("at step 7, t = 0.1 s");
    });
    EXPECT_EQ(outcome.code, 130);
    EXPECT_EQ(outcome.report["status"], "interrupted");
    EXPECT_NE(outcome.error.find("at step 7, t = 0.1 s"), std::string::npos) << outcome.error;
  }
}

// Seen to fail without prepare_out_dir: the earlier results are then gone.
TEST(RunMain, RefusesToReplaceAnEarlierRunUnlessForced) {
  const ScratchDirectory dir;
  const auto nothing = [](auto&&...) {};
  EXPECT_EQ(run(dir, {case_path, "--out", dir / "out"}, nothing).code, 0);
  const Outcome second = run(dir, {case_path, "--out", dir / "out"}, nothing);
  EXPECT_EQ(second.code, 2);
  EXPECT_NE(second.error.find("--force"), std::string::npos) << second.error;
  EXPECT_EQ(run(dir, {case_path, "--out", dir / "out", "--force"}, nothing).code, 0);
}

// Seen to fail with create_directories' error ignored: the sentence then speaks of the log.
TEST(RunMain, NamesTheDirectoryOrCaseItCannotUse) {
  const ScratchDirectory dir;
  const auto nothing = [](auto&&...) {};
  { std::ofstream(dir / "file") << "x"; }
  const Outcome blocked = run(dir, {case_path, "--out", dir / "file/out"}, nothing);
  EXPECT_EQ(blocked.code, 5);
  EXPECT_NE(blocked.error.find("output directory " + (dir / "file/out")), std::string::npos) << blocked.error;
  const Outcome missing = run(dir, {"no_such_case", "--out", dir / "out"}, nothing);
  EXPECT_EQ(missing.code, 2);
  EXPECT_NE(missing.error.find("no_such_case"), std::string::npos) << missing.error;
  EXPECT_FALSE(std::filesystem::exists(dir / "out")) << "a bad case leaves nothing behind";
}

}  // namespace
}  // namespace tern
