// Where the parts of a run live must not change a bit of its result: one process or three, one thread or two, first run or
// second. Seen to fail: with this file compiled against another face kernel than the executables.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cstring>
#include <numeric>

#include "coupler/window.hpp"
#include "fixtures/scratch_directory.hpp"
#include "fluid/fluid.hpp"
#include "run/recorder.hpp"
#include "structure/coupled_structure.hpp"

extern char** environ;

namespace tern::coupler::testing {
namespace {

const std::string case_path = TERN_SOURCE_DIR "/tests/process/cases/splash_plate/case.toml";

/// Last frame of a run, each [N,3] row by row.
struct LastFrame {
  long step = 0;
  std::vector<double> fluid_position, structure_position, surface_position, surface_force;
};

/// Starts tern-coupler, tern-fluid and tern-structure on the case, waits for them; true if all ended with 0.
bool run_three(const std::string& out, const std::vector<std::string>& options) {
  setenv("GOMP_SPINCOUNT", "1000", 0);  // as ./tern does: waiting threads do not keep busy cores from those they wait for
  std::vector<pid_t> processes;
  for (const std::string role : {"coupler", "fluid", "structure"}) {
    std::vector<std::string> words{TERN_BUILD_DIR "/tern-" + role, case_path, "--out", out, "--endpoint",
                                   "ipc://" + out + "/tern.sock",  "--quiet"};
    words.insert(words.end(), options.begin(), options.end());
    std::vector<char*> arguments;
    for (auto& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, (out + "/" + role + ".err").c_str(), O_WRONLY | O_CREAT, 0644);
    pid_t process = 0;
    EXPECT_EQ(posix_spawn(&process, words[0].c_str(), &files, nullptr, arguments.data(), environ), 0) << words[0];
    posix_spawn_file_actions_destroy(&files);
    processes.push_back(process);
  }
  bool good = true;
  for (const pid_t process : processes) {
    int status = 0;
    waitpid(process, &status, 0);
    good = good && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }
  if (!good)
    for (const char* role : {"coupler", "fluid", "structure"}) std::fputs(text_of(out + "/" + role + ".err").c_str(), stderr);
  return good;
}

/// A dataset of the last frame in DIR/<role>.h5 and, if asked, the step of that frame.
std::vector<double> last_dataset(const std::string& out, const std::string& role, const std::string& field, long* step = nullptr) {
  const hid_t file = H5Fopen((out + "/" + role + ".h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file < 0) return {};
  std::string group;
  for (int n = 0;; ++n) {
    char name[32];
    std::snprintf(name, sizeof name, "/frame_%06d", n);
    if (H5Lexists(file, name, H5P_DEFAULT) <= 0) break;
    group = name;
  }
  const hid_t dataset = H5Dopen2(file, (group + "/" + field).c_str(), H5P_DEFAULT);
  const hid_t space = H5Dget_space(dataset);
  std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  if (step) {
    const hid_t attribute = H5Aopen_by_name(file, group.c_str(), "step", H5P_DEFAULT, H5P_DEFAULT);
    H5Aread(attribute, H5T_NATIVE_LONG, step);
    H5Aclose(attribute);
  }
  H5Sclose(space);
  H5Dclose(dataset);
  H5Fclose(file);
  return values;
}

LastFrame read_last_frame(const std::string& out) {
  LastFrame frame;
  frame.fluid_position = last_dataset(out, "fluid", "position", &frame.step);
  frame.structure_position = last_dataset(out, "structure", "position");
  frame.surface_position = last_dataset(out, "structure", "surface_position");
  frame.surface_force = last_dataset(out, "structure", "surface_force");
  return frame;
}

template <class Positions, class Index>
std::vector<double> rows(const Positions& x, std::size_t n, Index&& index) {
  std::vector<double> values;
  for (std::size_t k = 0; k < n; ++k) {
    const Vector<2>& row = x[index(k)];
    values.insert(values.end(), {row[0], row[1], 0.0});
  }
  return values;
}

/// The same run with everything in this process.
LastFrame run_here(const Case& scene) {
  fluid::Fluid<2> fluid(scene);
  structure::Structure<2> structure(scene);
  structure::CoupledStructure<2> coupled(structure, scene.coupling.algorithm);
  Coupler<2> coupler(scene, structure.surface_properties());
  StepControl control;
  const Ticks end = to_ticks(scene.end_time);
  const FrameSchedule schedule(scene.output.frame_interval, end);
  LastFrame frame;
  int wet = 0;
  for (Ticks now = 0; now < end; ++frame.step) {
    const Ticks duration = control.next(coupler.propose(fluid.propose_step().seconds, "").seconds, now, schedule.next(now));
    run_window<2>(fluid, coupled, coupler, now, duration);
    now += duration;
    wet += coupler.audit().pairs > 0;
    EXPECT_LT(coupler.audit().force_error, 1e-12);
  }
  EXPECT_EQ(wet, frame.step) << "fluid and structure must act on each other in every window";
  EXPECT_GT(coupler.total_load(0).norm(), 1) << "load at the end [N/m]";

  const auto& state = fluid.state();
  std::vector<std::size_t> order(state.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return state.id[a] < state.id[b]; });
  const auto same = [](std::size_t k) { return k; };
  frame.fluid_position = rows(state.position, state.size(), [&](std::size_t k) { return order[k]; });
  frame.structure_position = rows(structure.fields().position, structure.particles(), same);
  frame.surface_position = rows(structure.surface().position, structure.surface_points(), same);
  frame.surface_force = rows(structure.load().force, structure.surface_points(), same);
  return frame;
}

void expect_same_bits(const std::vector<double>& a, const std::vector<double>& b, const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  ASSERT_GT(a.size(), 0u) << what;
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]), 0) << what;
}

void expect_same_bits(const LastFrame& a, const LastFrame& b) {
  EXPECT_EQ(a.step, b.step);
  expect_same_bits(a.fluid_position, b.fluid_position, "fluid position");
  expect_same_bits(a.structure_position, b.structure_position, "structure position");
  expect_same_bits(a.surface_position, b.surface_position, "surface position");
  expect_same_bits(a.surface_force, b.surface_force, "surface force");
}

TEST(ProcessSplit, OneProcessAndThreeGiveTheSameBits) {
  const ScratchDirectory out;
  ASSERT_TRUE(run_three(out.path(), {}));
  const LastFrame three = read_last_frame(out.path());
  EXPECT_GE(three.step, 30);
  expect_same_bits(run_here(read_case(case_path)), three);
  std::printf("[ %ld windows, %zu fluid particles, %zu of the plate ]\n", three.step, three.fluid_position.size() / 3,
              three.structure_position.size() / 3);
}

TEST(ProcessSplit, AnExplicitRunInOneProcessAndInThreeGivesTheSameBits) {
  const ScratchDirectory out;
  CaseOptions options;
  options.overrides = {{"coupling.algorithm", "explicit"}, {"structure.body.plate.density", "60000"}, {"end_time", "0.06"}};
  std::vector<std::string> words;
  for (const auto& [key, value] : options.overrides) words.insert(words.end(), {"--set", key + "=" + value});
  ASSERT_TRUE(run_three(out.path(), words));
  expect_same_bits(run_here(read_case(case_path, options)), read_last_frame(out.path()));
}

// A light plate: every window is tried several times.
TEST(ProcessSplit, ARepeatedWindowInOneProcessAndInThreeGivesTheSameBits) {
  const ScratchDirectory out;
  CaseOptions options;
  options.overrides = {{"structure.body.plate.density", "100"}, {"end_time", "0.06"}, {"structure.numerics.integrator", "explicit"}};
  std::vector<std::string> words;
  for (const auto& [key, value] : options.overrides) words.insert(words.end(), {"--set", key + "=" + value});
  ASSERT_TRUE(run_three(out.path(), words));
  EXPECT_NE(text_of(out / "report.coupler.json").find("coupling_iterations_mean"), std::string::npos) << "windows are repeated";
  expect_same_bits(run_here(read_case(case_path, options)), read_last_frame(out.path()));
}

// 11 250 particles: enough for every parallel loop of the fluid to be one.
TEST(ProcessSplit, TwoRunsAndOneAndTwoThreadsGiveTheSameBits) {
  const ScratchDirectory first, second, threaded;
  const std::vector<std::string> fine = {"--set",   "fluid.spacing=0.002",
                                         "--set",   "structure.body.plate.spacing=0.002",
                                         "--set",   "fluid.body.0.shape.box.max=[0.2, 0.225]",
                                         "--until", "0.01"};
  const auto with_threads = [&](const char* threads) {
    auto words = fine;
    words.insert(words.end(), {"--threads", threads});
    return words;
  };
  ASSERT_TRUE(run_three(first.path(), with_threads("1")));
  ASSERT_TRUE(run_three(second.path(), with_threads("1")));
  ASSERT_TRUE(run_three(threaded.path(), with_threads("2")));
  const LastFrame reference = read_last_frame(first.path());
  EXPECT_GT(reference.fluid_position.size(), 3u * 8192);
  EXPECT_GE(reference.step, 10);
  for (const auto* other : {&second, &threaded}) {
    expect_same_bits(reference, read_last_frame(other->path()));
    for (const char* table : {"gauges.csv", "energy.csv"}) EXPECT_EQ(text_of(first / table), text_of(*other / table)) << table;
  }
  EXPECT_NE(text_of(first / "gauges.csv"), "");
}

}  // namespace
}  // namespace tern::coupler::testing
