// The report of one process: keys, first cause, finite numbers, whole files.

#include "run/run_report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "fixtures/scratch_directory.hpp"
#include "run/atomic_file.hpp"

namespace tern {
namespace {

nlohmann::json report_in(const ScratchDirectory& dir) { return nlohmann::json::parse(text_of(dir / "report.fluid.json")); }

// Seen to fail with "git" left out of json().
TEST(RunReport, HasEveryKeyTheLauncherReads) {
  const ScratchDirectory dir;
  RunReport report(dir.path(), "fluid", 2);
  Case scene;
  scene.name = "tank";
  scene.hash = "abc";
  scene.settings = R"({"fluid": {"spacing": 0.004}})";
  scene.end_time = 1.5;
  report.set_case(scene, {{{"fluid.spacing", "0.004"}}, "draft"});
  report.set_time(0.25, 17);
  report.set_measure("volume_drift", 1e-3);
  report.set_count("particles", 5000);
  report.write();

  const auto json = report_in(dir);
  for (const char* key : {"role",  "status",  "exit_code", "cause", "cause_time", "case",   "case_hash",  "settings", "version",  "git",
                          "build", "threads", "wall_s",    "cpu_s", "steps",      "time_s", "end_time_s", "timing_s", "measures", "counts"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["status"], "running");
  EXPECT_EQ(json["settings"]["fluid"]["spacing"], 0.004);
  EXPECT_EQ(json["overrides"][0], "fluid.spacing=0.004");
  EXPECT_EQ(json["steps"], 17);
  EXPECT_EQ(json["end_time_s"], 1.5);
  EXPECT_EQ(json["measures"]["volume_drift"], 1e-3);
  EXPECT_EQ(json["counts"]["particles"], 5000);
  EXPECT_GT(json["cpu_s"], 0.0);
  for (const char* part : {"compute", "wait", "exchange", "output"}) EXPECT_TRUE(json["timing_s"].contains(part)) << part;
}

// Seen to fail with the key left out of json(), with it written in a run that has not gone on, and without writing the file.
TEST(RunReport, NamesTheCheckpointThatTheRunGoesOnFrom) {
  const ScratchDirectory dir;
  RunReport report(dir.path(), "fluid", 1);
  report.write();
  EXPECT_FALSE(report_in(dir).contains("resumed"));
  report.set_resumed(40, 0.125);
  EXPECT_EQ(report_in(dir)["resumed"], (nlohmann::json{{"step", 40}, {"time_s", 0.125}}));
}

// Seen to fail with set_failure overwriting: the later, derived cause then hides the first.
TEST(RunReport, KeepsTheFirstCause) {
  const ScratchDirectory dir;
  RunReport report(dir.path(), "fluid", 1);
  report.set_failure(ExitCode::numerical_failure, "The step became 0.");
  report.set_failure(ExitCode::input_output, "Cannot write.");
  report.set_done();
  report.write();
  const auto json = report_in(dir);
  EXPECT_EQ(json["status"], "failed");
  EXPECT_EQ(json["exit_code"], 3);
  EXPECT_EQ(json["cause"], "The step became 0.");
  EXPECT_GT(json["cause_time"], 1.7e9);

  RunReport stopped(dir.path(), "fluid", 1);
  stopped.set_failure(ExitCode::interrupted, "Ctrl-C.");
  stopped.write();
  EXPECT_EQ(report_in(dir)["status"], "interrupted");
}

// Seen to fail without the check: JSON then holds null.
TEST(RunReport, RefusesAMeasureThatIsNotFinite) {
  const ScratchDirectory dir;
  RunReport report(dir.path(), "fluid", 1);
  EXPECT_THROW(report.set_measure("volume_drift", std::nan("")), NumericalFailure);
}

// Seen to fail with the error handler left at strict: dump() then throws.
TEST(RunReport, SurvivesACauseThatIsNotUtf8) {
  const ScratchDirectory dir;
  RunReport report(dir.path(), "fluid", 1);
  report.set_failure(ExitCode::bad_input, "Cannot read caf\xe9.toml.");
  report.write();
  EXPECT_EQ(report_in(dir)["exit_code"], 2);
}

// Seen to fail with 1e3 in place of 1 s in ScopedTimer.
TEST(RunReport, AddsTimeThroughAReferenceThatStaysValid) {
  const ScratchDirectory dir;
  RunReport report(dir.path(), "fluid", 1);
  double& pressure_s = report.timing("pressure");
  for (int i = 0; i < 100; ++i) report.timing("part" + std::to_string(i));
  {
    const ScopedTimer timer(pressure_s);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  report.add_time("pressure", 1);
  report.write();
  const double seconds = report_in(dir)["timing_s"]["pressure"];
  EXPECT_GE(seconds, 1.02);
  EXPECT_LT(seconds, 1.5);
}

// Seen to fail with the temporary file left behind.
TEST(AtomicFile, KeepsTheOldContentWhenTheNewCannotBeWritten) {
  const ScratchDirectory dir;
  write_atomically(dir / "a", "old");
  std::filesystem::create_directory(dir / "a.tmp");  // in the way of the temporary file
  EXPECT_THROW(write_atomically(dir / "a", "new"), InputOutputError);
  EXPECT_EQ(text_of(dir / "a"), "old");
  std::filesystem::remove(dir / "a.tmp");
  write_atomically(dir / "a", "new");
  EXPECT_EQ(text_of(dir / "a"), "new");
  std::filesystem::create_directory(dir / "b");
  EXPECT_THROW(write_atomically(dir / "b", "text"), InputOutputError);
  EXPECT_FALSE(std::filesystem::exists(dir / "b.tmp"));
}

}  // namespace
}  // namespace tern
