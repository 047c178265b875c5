#pragma once
// How much a peer has sent that is no message yet. ZeroMQ keeps the parts of a message until the last of them is there, however many they
// are, and lets a stranger fill a frame of the largest size before anybody knows who it is. So the kernel's count of the bytes that have
// come in on each network connection is compared with what has been delivered; a connection that exceeds its limit is shut down.

#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <stop_token>
#include <thread>

namespace tern::proto {

/// Before they have joined, all together: a Hello is 28 bytes per surface point, and two participants say one [bytes].
inline constexpr std::uint64_t max_bytes_of_strangers = std::uint64_t{8} << 20;

/// Watches connections by their file descriptors, in a thread of its own while there are any. Those that are no TCP connections are
/// passed over: only the user's own processes reach an ipc endpoint.
class Inflow {
 public:
  Inflow();

  void accepted(int connection);
  void closed(int connection);
  /// A whole message of this connection has arrived.
  void delivered(int connection);
  /// It is one of the run: one message of the largest size may be on its way. To be said again now and then, for a descriptor that a
  /// stranger gave up may be its own now, and the end of that stranger is told late.
  void joined(int connection);

 private:
  struct Peer {
    std::uint64_t before = 0;  ///< count of the kernel when the last message was delivered [bytes]
    bool joined = false;
  };

  void watch(const std::stop_token& stop);
  void look();

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<int, Peer> peers_;
  std::jthread thread_;  ///< last: it ends before what it uses
};

}  // namespace tern::proto
