#pragma once
// Whether a peer still reads and speaks, seen from this side of its connection. ZeroMQ's threads ask each other for a sign of life every
// second, whatever their process computes. Whether it came is not left to ZeroMQ: its clock also runs while this process is stopped, and
// then it drops a peer that was there all the time. Here the kernel's account of the connection is compared with the time in which this
// process was there to look.

#include <cstdint>

namespace tern::proto {

/// A wait for messages looks at least so often [s].
inline constexpr double longest_turn_s = 0.1;
/// A peer of which nothing is heard for longer is lost [s].
inline constexpr double longest_silence_s = 5;

class Silence {
 public:
  /// Whether nothing has been heard for too long. `present_s` is how long the wait that asks has been there so far (Waiting::present_s);
  /// a new wait begins at 0, and with it the peer's time.
  bool too_long(int connection, double present_s);

 private:
  bool heard(int connection);

  double heard_s_ = 0, looked_s_ = 0;
  std::uint64_t received_ = 0, taken_ = 0;  ///< network: bytes that have come from the peer, and that its machine has taken
  int unread_ = 0;                          ///< within this machine: what the peer has not read yet, in the kernel's bytes
};

}  // namespace tern::proto
