#pragma once
// Messages in and out of a socket, with the bytes and the wall time they cost.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "proto/transport/socket.hpp"
#include "proto/wire/message_check.hpp"

namespace tern::proto {

struct Traffic {
  double wait_s = 0;      ///< inside wait()
  double exchange_s = 0;  ///< inside an Exchange, waiting excluded
  std::uint64_t bytes_sent = 0, bytes_received = 0;

  /// Waits for the socket, at most longest_turn_s.
  void wait(Socket& socket);

  /// Counts its lifetime, less what was waited, as exchange.
  class Exchange {
   public:
    explicit Exchange(Traffic& traffic);
    ~Exchange();
    Exchange(const Exchange&) = delete;
    Exchange& operator=(const Exchange&) = delete;

   private:
    Traffic& traffic_;
    double waited_before_;
    std::chrono::steady_clock::time_point begin_;
  };
};

struct Arrived {
  std::string peer;     ///< routing id, router only
  std::string role;     ///< of the sender's key, router with keys only
  int connection = -1;  ///< file descriptor, as in SocketEvent
  std::string fault;    ///< of the bytes; empty when `message` holds what was sent
  wire::Message message;
};

/// The next message that is there already, parsed under the size cap; nothing when there is none.
std::optional<Arrived> take_message(Socket& socket, Traffic& traffic);

/// Returns false when the peer is gone or takes nothing any more. Throws InputOutputError beyond the size cap.
bool send_message(Socket& socket, const std::string& peer, const wire::Message& message, Traffic& traffic);

}  // namespace tern::proto
