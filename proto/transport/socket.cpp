// Sockets that ask for signs of life (silence.hpp looks whether they come), a size cap, bounded linger, and a monitor.

#include "proto/transport/socket.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <poll.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cstring>
#include <stdexcept>

#include "base/error.hpp"
#include "proto/transport/zeromq.hpp"
#include "proto/wire/message_check.hpp"

namespace tern::proto {
namespace {

constexpr int heartbeat_interval_ms = 1000;
constexpr int handshake_ms = 5000;  // somebody who connects and says nothing is dropped
constexpr int connect_ms = 3000;
constexpr int linger_ms = 500;
constexpr int reconnect_ms = 20, longest_reconnect_ms = 500;
constexpr std::uint64_t short_turns_ns = 100'000;  // the shortest there are
constexpr int queue_messages = 64;                 // the protocol never has more than a few on the way

void set(void* socket, int option, int value) {
  require(zmq_setsockopt(socket, option, &value, sizeof(value)) == 0, "set a socket option");
}

void set(void* socket, int option, const std::string& value) {
  require(zmq_setsockopt(socket, option, value.c_str(), value.size()) == 0, "set a socket option");
}

/// Numbers with a colon are IPv6 and stand in brackets.
void permit_ipv6(void* socket, const std::string& endpoint) {
  if (endpoint.starts_with("tcp://[")) set(socket, ZMQ_IPV6, 1);
}

/// A stranger who opens connections must not leave this process without descriptors for its own files.
void raise_descriptor_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

/// Length of the turns [ns] that Linux (6.12 and later) gives this thread, and every thread it starts, before another may have the
/// core; 0: as usual. Returns that of before. The share of a core stays what it was, but who asks for short turns and wakes up does
/// not wait until one that computes has had a long one. Where the kernel does not know this, or there is no permission, nothing changes.
std::uint64_t set_turns(std::uint64_t nanoseconds) {
  struct {  // sched_attr of the kernel, which this C library does not have and newer ones do
    std::uint32_t size, policy;
    std::uint64_t flags;
    std::int32_t nice;
    std::uint32_t priority;
    std::uint64_t runtime, deadline, period;
  } attributes{};
  if (::syscall(SYS_sched_getattr, 0, &attributes, sizeof(attributes), 0) != 0 || attributes.policy != SCHED_OTHER) return 0;
  const std::uint64_t before = attributes.runtime;
  attributes.runtime = nanoseconds;
  ::syscall(SYS_sched_setattr, 0, &attributes, 0);
  return before;
}

/// RAII around zmq_msg_t.
struct Frame {
  zmq_msg_t message;
  Frame() { zmq_msg_init(&message); }
  explicit Frame(std::size_t size) { require(zmq_msg_init_size(&message, size) == 0, "allocate a message"); }
  ~Frame() { zmq_msg_close(&message); }
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;
  std::byte* data() { return static_cast<std::byte*>(zmq_msg_data(&message)); }
  std::size_t size() { return zmq_msg_size(&message); }
  bool more() { return zmq_msg_more(&message) != 0; }
};

int take(Frame& frame, void* socket, int flags) {
  return through_signals([&] { return zmq_msg_recv(&frame.message, socket, flags); });
}

}  // namespace

void keep_freed_memory() {
  constexpr int kept_bytes = 32 << 20;  // the most glibc allows
  mallopt(M_MMAP_THRESHOLD, kept_bytes);
  mallopt(M_TRIM_THRESHOLD, kept_bytes);
}

Socket::Socket(SocketKind kind, const std::optional<Keys>& keys) : kind_(kind) {
  keep_freed_memory();
  context_ = zmq_ctx_new();
  require(context_ != nullptr, "make a context");
  const std::uint64_t turns = set_turns(short_turns_ns);  // ZeroMQ's threads begin with the first socket
  socket_ = zmq_socket(context_, kind == SocketKind::dealer ? ZMQ_DEALER : ZMQ_ROUTER);
  if (kind == SocketKind::dealer) set_turns(turns);  // a participant computes; everybody waits for the coupler
  require(socket_ != nullptr, "make a socket");
  set(socket_, ZMQ_LINGER, linger_ms);
  set(socket_, ZMQ_HEARTBEAT_IVL, heartbeat_interval_ms);
  set(socket_, ZMQ_HEARTBEAT_TIMEOUT, 0);  // never: ZeroMQ would take a pause of this process for the peer's silence
  set(socket_, ZMQ_HANDSHAKE_IVL, handshake_ms);
  set(socket_, ZMQ_CONNECT_TIMEOUT, connect_ms);
  set(socket_, ZMQ_RECONNECT_IVL, reconnect_ms);
  set(socket_, ZMQ_RECONNECT_IVL_MAX, longest_reconnect_ms);
  set(socket_, ZMQ_SNDHWM, queue_messages);
  set(socket_, ZMQ_RCVHWM, queue_messages);
  // Twice the protocol's cap: between the two the sender is told what was wrong, above it the connection is dropped
  // unread.
  const std::int64_t cap = 2 * static_cast<std::int64_t>(max_message_bytes);
  require(zmq_setsockopt(socket_, ZMQ_MAXMSGSIZE, &cap, sizeof(cap)) == 0, "limit the message size");
  int events =
      ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL;
  if (kind == SocketKind::router) {
    set(socket_, ZMQ_ROUTER_MANDATORY, 1);  // a message to a lost peer is an error
    if (keys) zap_handler_.emplace(context_, keys->allowed);
    events |= ZMQ_EVENT_ACCEPTED;
  } else {
    events |= ZMQ_EVENT_CONNECTED | ZMQ_EVENT_CLOSED | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;
  }
  if (keys) {
    set(socket_, ZMQ_CURVE_SECRETKEY, keys->own_secret);
    if (kind == SocketKind::router) {
      set(socket_, ZMQ_CURVE_SERVER, 1);
    } else {
      set(socket_, ZMQ_CURVE_PUBLICKEY, keys->own_public);
      set(socket_, ZMQ_CURVE_SERVERKEY, keys->coupler_public);
    }
  }

  constexpr const char* address = "inproc://monitor";
  require(through_signals([&] { return zmq_socket_monitor(socket_, address, events); }) == 0, "watch a socket");
  monitor_ = zmq_socket(context_, ZMQ_PAIR);
  require(monitor_ != nullptr, "watch a socket");
  set(monitor_, ZMQ_LINGER, 0);
  // No limit of waiting events: at the limit ZeroMQ's own thread would stop, in the midst of a flood of connections, until this
  // process looks; in the destructor it would never look again.
  set(monitor_, ZMQ_RCVHWM, 0);
  require(through_signals([&] { return zmq_connect(monitor_, address); }) == 0, "watch a socket");
  descriptors_ = {descriptor(socket_), descriptor(monitor_), zap_handler_ ? zap_handler_->descriptor() : -1};
}

Socket::~Socket() {
  zmq_socket_monitor(socket_, nullptr, 0);
  zmq_close(monitor_);
  zmq_close(socket_);
  zap_handler_.reset();
  while (zmq_ctx_term(context_) != 0 && zmq_errno() == EINTR) {}
}

std::string Socket::bind(const std::string& endpoint) {
  permit_ipv6(socket_, endpoint);
  if (endpoint.starts_with("tcp://")) {
    raise_descriptor_limit();
    inflow_ = std::make_unique<Inflow>();
  }
  if (through_signals([&] { return zmq_bind(socket_, endpoint.c_str()); }) != 0)
    throw InputOutputError(
        fmt::format("The coupler cannot bind the endpoint \"{}\": {}; choose another one.", endpoint, zmq_strerror(zmq_errno())));
  std::array<char, 512> bound{};
  std::size_t size = bound.size();
  require(through_signals([&] { return zmq_getsockopt(socket_, ZMQ_LAST_ENDPOINT, bound.data(), &size); }) == 0, "name the endpoint");
  return bound.data();
}

void Socket::connect(const std::string& endpoint) {
  permit_ipv6(socket_, endpoint);
  if (through_signals([&] { return zmq_connect(socket_, endpoint.c_str()); }) != 0)
    throw BadInput(
        fmt::format("The endpoint \"{}\" cannot be used: {}; use the one the coupler printed.", endpoint, zmq_strerror(zmq_errno())));
}

void Socket::wait(int milliseconds) {
  std::array<pollfd, 3> items{};
  for (std::size_t k = 0; k < items.size(); ++k) items[k] = {descriptors_[k], POLLIN, 0};  // poll passes over -1
  if (::poll(items.data(), items.size(), milliseconds) <= 0) return;
  events_may_wait_ |= items[1].revents != 0 || items[2].revents != 0;
}

bool Socket::receive(const std::function<void(const Received&)>& handle) {
  Frame peer;
  if (kind_ == SocketKind::router && take(peer, socket_, ZMQ_DONTWAIT) < 0) return false;
  Frame payload;
  if (take(payload, socket_, ZMQ_DONTWAIT) < 0) return false;
  int frames = 1;
  for (bool more = payload.more(); more; ++frames) {
    Frame extra;
    more = take(extra, socket_, 0) >= 0 && extra.more();
  }
  if (inflow_) inflow_->delivered(zmq_msg_get(&payload.message, ZMQ_SRCFD));
  const char* role = zap_handler_ ? zmq_msg_gets(&payload.message, "User-Id") : nullptr;
  handle({{reinterpret_cast<const char*>(peer.data()), peer.size()},
          role != nullptr ? role : "",
          zmq_msg_get(&payload.message, ZMQ_SRCFD),
          {payload.data(), payload.size()},
          frames});
  return true;
}

void Socket::joined(int connection) {
  if (inflow_) inflow_->joined(connection);
}

std::optional<SocketEvent> Socket::next_event() {
  using What = SocketEvent::What;
  if (!events_may_wait_) return std::nullopt;
  if (zap_handler_)
    if (auto who = zap_handler_->answer()) return SocketEvent{What::key_refused, -1, *std::move(who)};
  Frame frame;
  if (take(frame, monitor_, ZMQ_DONTWAIT) < 0) {
    events_may_wait_ = false;
    return std::nullopt;
  }
  std::uint16_t event = 0;
  std::int32_t value = 0;
  std::memcpy(&event, frame.data(), sizeof(event));
  std::memcpy(&value, frame.data() + sizeof(event), sizeof(value));
  Frame address;
  take(address, monitor_, 0);
  switch (event) {
    case ZMQ_EVENT_ACCEPTED:
      if (inflow_) inflow_->accepted(value);
      return SocketEvent{What::accepted, value, {}};
    case ZMQ_EVENT_CONNECTED: return SocketEvent{What::reached, value, {}};
    case ZMQ_EVENT_HANDSHAKE_SUCCEEDED: return SocketEvent{What::connected, -1, {}};
    case ZMQ_EVENT_DISCONNECTED:
      if (inflow_) inflow_->closed(value);
      return SocketEvent{What::disconnected, value, {}};
    case ZMQ_EVENT_CLOSED: return SocketEvent{What::nobody_there, -1, {}};
    case ZMQ_EVENT_HANDSHAKE_FAILED_AUTH: return SocketEvent{What::key_refused, -1, {}};
    case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL:
      return SocketEvent{value == ZMQ_PROTOCOL_ERROR_ZMTP_MECHANISM_MISMATCH ? What::other_security
                         : value == ZMQ_PROTOCOL_ERROR_ZMTP_CRYPTOGRAPHIC    ? What::other_key
                                                                             : What::broken_off,
                         -1,
                         {}};
    default: return SocketEvent{What::broken_off, -1, {}};
  }
}

bool Socket::send(const std::string& peer, std::size_t size, const std::function<void(std::byte*)>& write) {
  const auto send_who = [&] { return zmq_send(socket_, peer.data(), peer.size(), ZMQ_SNDMORE | ZMQ_DONTWAIT); };
  if (kind_ == SocketKind::router && through_signals(send_who) < 0) return false;
  Frame payload(size);
  write(payload.data());
  return through_signals([&] { return zmq_msg_send(&payload.message, socket_, ZMQ_DONTWAIT); }) >= 0;
}

}  // namespace tern::proto
