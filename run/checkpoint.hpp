#pragma once
// Checkpoints of a run: DIR/checkpoint/ROLE.STEP.h5, the state of one process at the end of window STEP, and manifest.STEP.json, written
// last by the process that keeps time: the coupler, or the only one. It names the step and the hash of each file, so that a set is whole
// or does not count. The last two are kept.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

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
  std::string case_hash;                    ///< Case::hash_of_rest
  std::string program;                      ///< version and commit
  std::map<std::string, std::string> hash;  ///< by role
};

/// Version and commit of this program, as a manifest names them.
std::string program_name();

class CheckpointStore {
 public:
  CheckpointStore(const std::string& out_dir, std::string role, const Case& scene);

  /// Removes what this role has left, and all manifests: a run begins anew.
  void clear() const;

  /// Writes the file of this step: write(StateWriter&) puts the members in. Atomic; the files of older steps but the one before are
  /// removed. Returns its hash. Throws InputOutputError.
  template <class Write>
  std::string save(std::uint64_t step, Write&& write) const {
    begin();
    {
      StateWriter file(temporary());
      write(file);
      file.close();
    }
    return finish(step);
  }

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
  void begin() const;
  std::string finish(std::uint64_t step) const;

  std::string directory_, role_, case_hash_;
};

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
