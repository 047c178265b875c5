#pragma once
// One wait for one message: notices interruption, tells the log after 5 s who waits for whom, gives up at the deadline. Only the time
// counts in which this process was there: a machine that stood still, or a process that was stopped, does not blame the peer for it.

#include <chrono>
#include <cstdint>
#include <string>

namespace tern::proto {

/// Ctrl-C and SIGTERM end a run within 2 s. For so long of these a process goes on with what is under way, so that the coupler can
/// complete the window, have a checkpoint made and end the others, also where all are signalled at once [s].
inline constexpr double patience_after_interrupt_s = 1;

class Waiting {
 public:
  /// `who` and `whom` are role names for sentences; `deadline_s` counts from now.
  Waiting(std::string who, std::string whom, std::uint64_t step, double time_s, double deadline_s);

  /// Call at least every longest_turn_s. Throws Interrupted after a signal, PeerLost after the deadline.
  void check();
  /// Since the begin, at the last check [s]. A turn that took longer than it asked for counts as long as that.
  double present_s() const { return present_s_; }
  void set_deadline(double deadline_s) { deadline_s_ = deadline_s; }

  /// After a signal the wait goes on for patience_after_interrupt_s, counted from when the first wait has noticed it.
  void be_patient() { patience_s_ = patience_after_interrupt_s; }

  /// Tells the log earlier than after 5 s.
  void speak_after(double seconds);

  /// Who is waited for, when it is not simply `whom` any more.
  void set_whom(std::string whom) { whom_ = std::move(whom); }

 private:
  std::string who_, whom_;
  std::uint64_t step_;
  double time_s_;
  double deadline_s_, patience_s_ = 0;
  double next_log_s_ = 5;
  bool spoken_ = false;
  double present_s_ = 0;
  std::chrono::steady_clock::time_point checked_ = std::chrono::steady_clock::now();
};

}  // namespace tern::proto
