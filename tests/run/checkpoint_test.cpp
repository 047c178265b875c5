// Checkpoints: two are kept, a set counts when it is whole, and any changed byte is found.

#include "run/checkpoint.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/error.hpp"
#include "fixtures/scratch_directory.hpp"

namespace tern {
namespace {

Case scene_of(const std::string& hash = "1234") {
  Case scene;
  scene.hash_of_rest = hash;
  return scene;
}

/// A run of two processes, of which "coupler" keeps time.
struct TwoProcesses {
  explicit TwoProcesses(const std::string& out, const Case& scene = scene_of())
      : coupler(out, "coupler", scene), fluid(out, "fluid", scene) {}

  static std::string save(const CheckpointStore& store, std::uint64_t step, double value) {
    StateWriter state;
    state("value", value);
    return store.save(step, state);
  }
  void save(std::uint64_t step, double value) const {
    const std::string of_fluid = save(fluid, step, value);
    coupler.write_manifest({step, 0.5, {{"fluid", of_fluid}, {"coupler", save(coupler, step, -value)}}});
  }
  std::uint64_t chosen() const { return coupler.choose({{"fluid", fluid.files()}, {"coupler", coupler.files()}}).step; }

  CheckpointStore coupler, fluid;
};

std::vector<std::string> names_in(const std::string& directory) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

void flip_byte(const std::string& path, std::size_t at) {
  std::string bytes = text_of(path);
  bytes.at(at) = static_cast<char>(bytes.at(at) ^ 1);
  std::ofstream(path, std::ios::binary) << bytes;
}

TEST(Checkpoint, TheLastTwoAreKeptAndTheNewestIsTaken) {
  const ScratchDirectory dir;
  const TwoProcesses run(dir.path());
  for (const std::uint64_t step : {7u, 20u, 31u}) run.save(step, static_cast<double>(step));
  EXPECT_EQ(names_in(dir / "checkpoint"),
            (std::vector<std::string>{"coupler.000000020.h5", "coupler.000000031.h5", "fluid.000000020.h5", "fluid.000000031.h5",
                                      "manifest.000000020.json", "manifest.000000031.json"}));
  ASSERT_EQ(run.chosen(), 31u);
  double value = 0;
  run.fluid.load(31, [&](StateReader& file) { file("value", value); });
  EXPECT_EQ(value, 31);
}

// Seen to fail when a manifest is believed without the hashes of the files.
TEST(Checkpoint, AnyChangedByteIsFoundAndTheOlderSetTaken) {
  const ScratchDirectory dir;
  const TwoProcesses run(dir.path());
  run.save(5, 1);
  run.save(9, 2);
  for (const std::string name : {"fluid.000000009.h5", "coupler.000000009.h5", "manifest.000000009.json"}) {
    const std::string path = dir / ("checkpoint/" + name), sound = text_of(path);
    for (std::size_t at = 0; at < sound.size(); at += name.starts_with("manifest") ? 1 : 97) {
      flip_byte(path, at);
      EXPECT_EQ(run.chosen(), 5u) << name << " byte " << at;
      flip_byte(path, at);
    }
    EXPECT_EQ(run.chosen(), 9u);
    std::ofstream(path, std::ios::binary) << sound.substr(0, sound.size() / 2);
    EXPECT_EQ(run.chosen(), 5u) << name << " cut";
    std::ofstream(path, std::ios::binary) << sound;
  }
}

TEST(Checkpoint, ASetThatIsNotWholeDoesNotCount) {
  const ScratchDirectory dir;
  const TwoProcesses run(dir.path());
  run.save(5, 1);
  TwoProcesses::save(run.fluid, 9, 2);  // the coupler was killed before it could
  EXPECT_EQ(run.chosen(), 5u);
  std::filesystem::remove(dir / "checkpoint/fluid.000000005.h5");
  try {
    run.chosen();
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("step 5 lacks the file of the fluid"), std::string::npos) << error.what();
  }
}

TEST(Checkpoint, OfAnotherCaseIsRefused) {
  const ScratchDirectory dir;
  TwoProcesses(dir.path()).save(5, 1);
  EXPECT_THROW(TwoProcesses(dir.path(), scene_of("5678")).chosen(), BadInput);
}

TEST(Checkpoint, ARunThatBeginsAnewLeavesNoneOfTheOldOnes) {
  const ScratchDirectory dir;
  const TwoProcesses run(dir.path());
  run.save(5, 1);
  run.coupler.clear();
  run.fluid.clear();
  EXPECT_TRUE(names_in(dir / "checkpoint").empty());
}

// A run that has gone back to step 5 and comes to another step 8 must not find that of before.
TEST(Checkpoint, LaterOnesOfARunThatWentBackAreRemoved) {
  const ScratchDirectory dir;
  const TwoProcesses run(dir.path());
  run.save(5, 1);
  run.save(9, 2);
  run.save(7, 3);
  EXPECT_EQ(run.chosen(), 7u);
  EXPECT_EQ(run.fluid.files().size(), 2u);
}

// A numerical failure has begun before it shows; a full disk has not. Seen to fail: with the newest for both.
TEST(KeptStates, AfterANumericalFailureTheOneBeforeTheNewestIsTaken) {
  KeptStates kept;
  const NumericalFailure diverged("It diverged.");
  const InputOutputError full("The disk is full.");
  EXPECT_EQ(kept.before(diverged).step, 0u);
  for (const std::uint64_t step : {10u, 20u, 30u, 40u}) {
    kept.keep(step, 0.1, [&](StateWriter& state) { state("value", static_cast<double>(step)); });
    EXPECT_EQ(kept.newest().step, step);
    EXPECT_EQ(kept.before(full).step, step);
    EXPECT_EQ(kept.before(diverged).step, step == 10 ? 10 : step - 10);
  }
  EXPECT_NE(kept.of(20), nullptr);  // for a participant that is one window behind
  EXPECT_EQ(kept.of(10), nullptr);
  EXPECT_EQ(kept.of(0), nullptr);
}

// Seen to fail: with a checkpoint that is itself the only state after it (before() names step 23).
TEST(KeptStates, GoWithACheckpoint) {
  const ScratchDirectory dir;
  const CheckpointStore store(dir.path(), "fluid", scene_of());
  const std::vector<double> values{1.5, 2.5};
  const auto write = [&](StateWriter& state) {
    state("time", 0.25);
    state("fluid/values", values);
    state("fluid/name", std::string("water"));
    state("fluid/none", std::vector<double>());
  };
  KeptStates before, after, once_more;
  for (const std::uint64_t step : {10u, 20u}) before.keep(step, 0.1 * static_cast<double>(step), write);
  store.save(23, before.with_state(write));
  store.load(23, [&](StateReader& file) { after.go_on_from(file, 23, 2.3); });
  const Kept& kept = after.before(NumericalFailure("It diverged."));
  EXPECT_EQ(kept.step, 10u);
  EXPECT_EQ(kept.time_s, 1.0);
  EXPECT_EQ(after.newest().step, 20u);

  // Written after a failure it is a checkpoint as any other, and what the run then goes on from.
  store.save_kept(kept);
  store.load(10, [&](StateReader& file) {
    once_more.go_on_from(file, 10, 1.0);
    std::vector<double> read, none{1};
    std::string name;
    file("fluid/values", read);
    file("fluid/name", name);
    file("fluid/none", none);
    EXPECT_EQ(read, values);
    EXPECT_EQ(name, "water");
    EXPECT_TRUE(none.empty());
  });
  EXPECT_EQ(once_more.newest().step, 10u);
  EXPECT_EQ(once_more.before(NumericalFailure("It diverged.")).step, 10u);
}

}  // namespace
}  // namespace tern
