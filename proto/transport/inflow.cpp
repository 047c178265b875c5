#include "proto/transport/inflow.hpp"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "proto/wire/message_check.hpp"

namespace tern::proto {
namespace {

constexpr std::chrono::milliseconds interval{5};  // in which a connection within a machine brings some megabytes

/// Bytes that have come in since the connection was made; nothing where it is no TCP connection.
std::optional<std::uint64_t> bytes_received(int connection) {
  tcp_info info{};
  socklen_t size = sizeof(info);
  if (::getsockopt(connection, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return std::nullopt;
  if (size < offsetof(tcp_info, tcpi_bytes_received) + sizeof(info.tcpi_bytes_received)) return std::nullopt;
  return info.tcpi_bytes_received;
}

}  // namespace

Inflow::Inflow() : thread_([this](const std::stop_token& stop) { watch(stop); }) {}

void Inflow::accepted(int connection) {
  if (!bytes_received(connection)) return;
  const std::lock_guard lock(mutex_);
  peers_.try_emplace(connection);
  changed_.notify_one();
}

void Inflow::closed(int connection) {
  const std::lock_guard lock(mutex_);
  peers_.erase(connection);
}

void Inflow::delivered(int connection) {
  const std::lock_guard lock(mutex_);
  if (const auto peer = peers_.find(connection); peer != peers_.end()) peer->second.before = bytes_received(connection).value_or(0);
}

void Inflow::joined(int connection) {
  const std::lock_guard lock(mutex_);
  if (bytes_received(connection)) peers_[connection].joined = true;
}

void Inflow::watch(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (!changed_.wait(lock, stop, [this] { return !peers_.empty(); })) return;
    look();
    changed_.wait_for(lock, stop, interval, [] { return false; });
  }
}

/// A joined peer may have one message of the largest size on its way, with some bytes for its frame and for heartbeats.
void Inflow::look() {
  constexpr std::uint64_t most_of_peer = max_message_bytes + (std::uint64_t{1} << 20);
  std::uint64_t of_strangers = 0;
  std::vector<std::pair<std::uint64_t, int>> strangers;
  for (const auto& [connection, peer] : peers_) {
    const std::uint64_t now = bytes_received(connection).value_or(0), pending = now > peer.before ? now - peer.before : 0;
    if (peer.joined) {
      if (pending > most_of_peer) ::shutdown(connection, SHUT_RDWR);
      continue;
    }
    of_strangers += pending;
    strangers.emplace_back(pending, connection);
  }
  std::sort(strangers.rbegin(), strangers.rend());  // who has sent most goes first
  for (const auto& [pending, connection] : strangers) {
    if (of_strangers <= max_bytes_of_strangers) return;
    ::shutdown(connection, SHUT_RDWR);
    of_strangers -= pending;
  }
}

}  // namespace tern::proto
