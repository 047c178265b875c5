#pragma once
// One ZeroMQ context, one socket and its monitor, owned together; nothing here knows the protocol.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

namespace tern::proto {

/// Freed memory, up to about 32 MiB, stays with this process. Otherwise glibc hands the pages of a large message back to the
/// system when it is freed, and the next one costs page faults, more than all its copies. Every Socket asks for it.
void keep_freed_memory();

enum class SocketKind { dealer, router };

/// What the monitor reports; everything else it says is dropped.
struct SocketEvent {
  enum class What { connected, disconnected } what;  ///< handshake of ZeroMQ done; connection lost, whatever the reason
  int connection;                                    ///< file descriptor
};

class Socket {
 public:
  explicit Socket(SocketKind kind);
  /// Messages that are still queued get at most 0.5 s.
  ~Socket();
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  /// Returns the endpoint as bound. Throws InputOutputError with the system's reason.
  std::string bind(const std::string& endpoint);
  void connect(const std::string& endpoint);

  /// Waits until a message or an event may be there, at most `milliseconds`; returns early on a signal. Only after both
  /// receive() and next_event() have found nothing: what has arrived before does not wake it.
  void wait(int milliseconds);

  struct Received {
    std::string peer;                  ///< routing id, router only
    int connection;                    ///< file descriptor
    std::span<const std::byte> bytes;  ///< valid during the call
    int frames;                        ///< payload frames; 1 in a proper message
  };
  /// Calls `handle` with one message if there is one. Returns whether there was.
  bool receive(const std::function<void(const Received&)>& handle);

  std::optional<SocketEvent> next_event();

  /// Queues one message of `size` bytes written by `write`; `peer` is the routing id (router only). Never blocks.
  /// Returns false when the peer is gone or takes nothing any more.
  bool send(const std::string& peer, std::size_t size, const std::function<void(std::byte*)>& write);

 private:
  void* context_ = nullptr;
  void* socket_ = nullptr;
  void* monitor_ = nullptr;
  std::array<int, 2> descriptors_{};  ///< of the two, to wait for
  SocketKind kind_;
};

}  // namespace tern::proto
