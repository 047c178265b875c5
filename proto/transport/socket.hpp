#pragma once
// One ZeroMQ context, one socket and its monitor, owned together; nothing here knows the protocol.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "proto/transport/inflow.hpp"
#include "proto/transport/keys.hpp"
#include "proto/transport/zap_handler.hpp"

namespace tern::proto {

/// Freed memory, up to about 32 MiB, stays with this process. Otherwise glibc hands the pages of a large message back to the
/// system when it is freed, and the next one costs page faults, more than all its copies. Every Socket asks for it.
void keep_freed_memory();

enum class SocketKind { dealer, router };

/// What happens to connections.
struct SocketEvent {
  enum class What {
    accepted,        ///< somebody has connected; nothing is known about who it is
    reached,         ///< there is a connection to the coupler, the handshake of ZeroMQ follows; at the participant
    connected,       ///< handshake of ZeroMQ done
    disconnected,    ///< connection lost, whatever the reason, also during the handshake
    nobody_there,    ///< an attempt to connect has failed: refused, or no answer for 3 s
    key_refused,     ///< the key is not in the coupler's list; at the coupler with `who`
    other_security,  ///< one end uses keys and the other does not
    other_key,       ///< what came cannot be decrypted: it was meant for another coupler
    broken_off,      ///< connection ended during the handshake, by the other end or after 5 s of silence
  } what;
  int connection = -1;  ///< file descriptor, of accepted, reached and disconnected
  std::string who;      ///< address and key, of key_refused at the coupler
};

class Socket {
 public:
  /// With keys all connections are encrypted, and a router lets in only those of its list.
  explicit Socket(SocketKind kind, const std::optional<Keys>& keys = {});
  /// Messages that are still queued get at most 0.5 s.
  ~Socket();
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  /// The host of a tcp endpoint must be a number, "*" or an interface. Returns the endpoint as bound. Throws InputOutputError
  /// with the system's reason.
  std::string bind(const std::string& endpoint);
  void connect(const std::string& endpoint);

  /// Waits until a message or an event may be there, at most `milliseconds`; returns early on a signal. Only after both
  /// receive() and next_event() have found nothing: what has arrived before does not wake it.
  void wait(int milliseconds);

  struct Received {
    std::string peer;                  ///< routing id, router only
    std::string role;                  ///< of the sender's key, router with keys only
    int connection;                    ///< file descriptor
    std::span<const std::byte> bytes;  ///< valid during the call
    int frames;                        ///< payload frames; 1 in a proper message
  };
  /// Calls `handle` with one message if there is one. Returns whether there was.
  bool receive(const std::function<void(const Received&)>& handle);

  /// The peer of this connection is one of the run; to be said after events have been taken (inflow.hpp).
  void joined(int connection);

  /// What has happened to connections until the last wait().
  std::optional<SocketEvent> next_event();

  /// Queues one message of `size` bytes written by `write`; `peer` is the routing id (router only). Never blocks.
  /// Returns false when the peer is gone or takes nothing any more.
  bool send(const std::string& peer, std::size_t size, const std::function<void(std::byte*)>& write);

 private:
  void* context_ = nullptr;
  void* socket_ = nullptr;
  void* monitor_ = nullptr;
  std::unique_ptr<Inflow> inflow_;         ///< router at a network address only
  std::optional<ZapHandler> zap_handler_;  ///< router with keys only
  std::array<int, 3> descriptors_{};       ///< of the three, to wait for
  bool events_may_wait_ = true;            ///< false: monitor and zap_handler had nothing, and their descriptors have been still since
  SocketKind kind_;
};

}  // namespace tern::proto
