// Whose turns are short. Seen to fail: without set_turns before the first socket (ZeroMQ's threads), without the one after it (the
// thread that computes), and with the latter for the router as well (the coupler).

#include "proto/transport/socket.hpp"

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

namespace tern::proto {
namespace {

/// Length of the turns of a thread of this process as the kernel tells it [ns]; 0: it does not.
std::uint64_t turns_of(long thread) {
  std::array<std::uint64_t, 6> attributes{};  // sched_attr: the fourth is sched_runtime
  if (::syscall(SYS_sched_getattr, thread, attributes.data(), sizeof(attributes), 0) != 0) return 0;
  return attributes[3];
}

/// Whether this kernel lets a thread ask for the length of its turns.
bool turns_can_be_set() {
  bool can = false;
  std::thread([&] {
    std::array<std::uint64_t, 6> attributes{};
    can = ::syscall(SYS_sched_getattr, 0, attributes.data(), sizeof(attributes), 0) == 0;
    attributes[3] = 200'000;
    can = can && ::syscall(SYS_sched_setattr, 0, attributes.data(), 0) == 0 && turns_of(0) == 200'000;
  }).join();
  return can;
}

struct Turns {
  std::uint64_t own_before, own, longest_of_zeromq = 0;
};

/// Of the threads of ZeroMQ, which name themselves once they run.
std::vector<std::uint64_t> turns_of_zeromq() {
  std::vector<std::uint64_t> turns;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::string name;
    std::getline(std::ifstream(task.path() / "comm"), name);
    if (name.starts_with("ZMQ")) turns.push_back(turns_of(std::stol(task.path().filename())));
  }
  return turns;
}

/// Of a thread that opens a socket, and of those that ZeroMQ has started for it: one that passes messages on and one that closes sockets.
Turns open_socket(SocketKind kind) {
  Turns turns{};
  std::thread([&] {
    turns.own_before = turns_of(0);
    const Socket socket(kind);
    turns.own = turns_of(0);
    std::vector<std::uint64_t> zeromq = turns_of_zeromq();
    for (int attempt = 0; attempt < 1000 && zeromq.size() < 2; ++attempt) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      zeromq = turns_of_zeromq();
    }
    EXPECT_EQ(zeromq.size(), 2U);
    for (const std::uint64_t each : zeromq) turns.longest_of_zeromq = std::max(turns.longest_of_zeromq, each);
  }).join();
  return turns;
}

TEST(Socket, TheThreadsThatPassMessagesOnHaveShortTurns) {
  const Turns participant = open_socket(SocketKind::dealer), coupler = open_socket(SocketKind::router);
  if (!turns_can_be_set()) GTEST_SKIP() << "this kernel does not let a thread choose the length of its turns";
  EXPECT_EQ(participant.longest_of_zeromq, 100'000U);
  EXPECT_EQ(participant.own, participant.own_before);
  EXPECT_EQ(coupler.longest_of_zeromq, 100'000U);
  EXPECT_EQ(coupler.own, 100'000U);
}

}  // namespace
}  // namespace tern::proto
