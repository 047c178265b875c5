#pragma once
// Checkpoints of a run: DIR/checkpoint/ROLE.STEP.h5, the state of one process at the end of window STEP, and manifest.STEP.json, written
// last by the process that keeps time: the coupler, or the only one. It names the step and the hash of each file, so that a set is whole
// or does not count. The last two are kept.

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/timing.hpp"
#include "run/state_file.hpp"
#include "scene/case_file.hpp"

namespace tern {

/// One file of a process, found in its directory.
struct CheckpointFile {
  std::uint64_t step;
  std::string hash;  ///< of its bytes (base/hash.hpp)
};

/// A set of files that belong together.
struct Manifest {
  std::uint64_t step = 0;
  double time_s = 0;
  std::map<std::string, std::string> hash;     ///< by role
  std::string case_hash{};                     ///< Case::hash_of_rest
  std::string program{};                       ///< version and commit
  std::map<std::string, std::string> gauge{};  ///< Case::gauge_hashes
};

/// Version and commit of this program, as a manifest names them.
std::string program_name();

/// A state in memory.
struct Kept {
  std::uint64_t step = 0;  ///< 0: none
  double time_s = 0;
  StateWriter state{};

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("step", all.step...);
    visit("time_s", all.time_s...);
    visit("state", all.state...);
  }
};

class CheckpointStore {
 public:
  CheckpointStore(const std::string& out_dir, std::string role, const Case& scene);

  /// Removes what this role has left, and all manifests: a run begins anew.
  void clear() const;

  /// Writes the file of this step. Atomic; the files of older steps but the one before, and of later ones, are removed. Returns its hash.
  /// Throws InputOutputError.
  std::string save(std::uint64_t step, const StateWriter& state) const;
  /// The same after a failure, without removing any other: whether a new set becomes whole is not known yet.
  std::string save_kept(const Kept& kept) const { return write(kept.step, kept.state); }

  /// read(StateReader&) takes the members out of the file of this step. Throws BadInput, InputOutputError.
  template <class Read>
  void load(std::uint64_t step, Read&& read) const {
    StateReader file(path(step));
    read(file);
  }

  /// The files of this role that can be read, newest first.
  std::vector<CheckpointFile> files() const;

  /// Makes a set count. Throws InputOutputError.
  void write_manifest(Manifest manifest) const;
  /// The manifests that are as they were written, newest first.
  std::vector<Manifest> manifests() const;

  /// Newest set of which every role offers its file as it was written. Throws BadInput that says what is missing when there is none, and
  /// when the case or the program has changed.
  Manifest choose(const std::map<std::string, std::vector<CheckpointFile>>& offers) const;

 private:
  std::string path(std::uint64_t step) const;
  std::string temporary() const;
  std::string write(std::uint64_t step, const StateWriter& state) const;

  std::string directory_, role_, case_hash_;
  std::map<std::string, std::string> gauge_hashes_;
};

/// The state at the end of every tenth window, in memory, the last three: from what a checkpoint can still be made when a later window has
/// failed. Every tenth, because that costs less than a hundredth of a run of small windows. The one before the newest, because what fails
/// has begun up to ten windows before. One more, because a participant may be one window ahead of another.
class KeptStates {
 public:
  static bool due(std::uint64_t step) { return step % 10 == 0; }

  /// Takes the place of the older one: write(StateWriter&) puts the members in.
  template <class Write>
  void keep(std::uint64_t step, double time_s, Write&& write) {
    std::rotate(kept_.begin(), kept_.end() - 1, kept_.end());
    Kept& newest = kept_.front();
    newest.step = step;
    newest.time_s = time_s;
    newest.state.clear();
    write(newest.state);
  }
  /// The state of a checkpoint, and those that go with it: what fails soon after it has begun before it.
  template <class Write>
  StateWriter with_state(Write&& write) const {
    StateWriter all;
    write(all);
    all("kept", kept_);
    return all;
  }
  /// The run goes on from what with_state() has gathered, or from a state that was itself kept: the first one, then.
  void go_on_from(StateReader& file, std::uint64_t step, double time_s) {
    if (file.has("kept"))
      file("kept", kept_);
    else
      kept_[0] = {step, time_s, file.all("/")};
  }
  const Kept& newest() const { return kept_[0]; }
  /// The one to go on from after an error: what fails numerically has begun before, so that is one from ten to twenty windows before, if
  /// there is one; else the newest.
  const Kept& before(const Error& error) const { return kept_[error.code() == ExitCode::numerical_failure && kept_[1].step > 0 ? 1 : 0]; }
  /// Null when this step is not among them.
  const Kept* of(std::uint64_t step) const {
    const auto kept = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& one) { return step > 0 && one.step == step; });
    return kept == kept_.end() ? nullptr : &*kept;
  }

 private:
  std::array<Kept, 3> kept_;
};

/// Whether the state before such a failure is worth a checkpoint: not after a lost peer, without which no set is whole, nor where the
/// peer or the input cannot be trusted.
inline bool state_was_sound(const Error& error) {
  return error.code() == ExitCode::numerical_failure || error.code() == ExitCode::input_output;
}

/// Has a checkpoint of the state before a failure written; that this fails as well, for example on a full disk, changes nothing: the
/// older set stays.
template <class Save>
void keep_after_failure(Save&& save) noexcept {
  try {
    save();
  } catch (const std::exception& error) {
    log_info(fmt::format("no checkpoint of the state before the failure: {}", error.what()));
  }
}

/// When the next checkpoint is due, by the clock.
class CheckpointClock {
 public:
  explicit CheckpointClock(double interval_s) : interval_s_(interval_s) {}
  bool on() const { return interval_s_ > 0; }
  bool due() const { return on() && since_.seconds() >= interval_s_; }
  void saved() { since_.restart(); }

 private:
  double interval_s_;
  Stopwatch since_;
};

}  // namespace tern
