// Serialisation straight into the socket's buffer: one copy per message and direction.

#include "proto/transport/traffic.hpp"

#include "base/error.hpp"
#include "proto/transport/silence.hpp"

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>

namespace tern::proto {
namespace {

double since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// What of a message counts as traffic: not its sequence number, and no checkpoints, so that a run that was continued has counted what
/// one that never stopped has.
std::uint64_t counted_bytes(const wire::Message& message, std::size_t size) {
  if (message.has_save() || message.has_saved()) return 0;
  return size - (1 + google::protobuf::io::CodedOutputStream::VarintSize64(message.sequence()));
}

}  // namespace

void Traffic::wait(Socket& socket) {
  const auto begin = std::chrono::steady_clock::now();
  socket.wait(static_cast<int>(1000 * longest_turn_s));
  wait_s += since(begin);
}

Traffic::Exchange::Exchange(Traffic& traffic)
    : traffic_(traffic), waited_before_(traffic.wait_s), begin_(std::chrono::steady_clock::now()) {}

Traffic::Exchange::~Exchange() { traffic_.exchange_s += since(begin_) - (traffic_.wait_s - waited_before_); }

std::optional<Arrived> take_message(Socket& socket, Traffic& traffic) {
  std::optional<Arrived> arrived;
  socket.receive([&](const Socket::Received& received) {
    arrived.emplace();
    arrived->peer = received.peer;
    arrived->role = received.role;
    arrived->connection = received.connection;
    arrived->fault =
        received.frames == 1 ? parse(received.bytes, arrived->message) : fmt::format("{} frames; a message is one frame", received.frames);
    traffic.bytes_received += arrived->fault.empty() ? counted_bytes(arrived->message, received.bytes.size()) : received.bytes.size();
  });
  return arrived;
}

bool send_message(Socket& socket, const std::string& peer, const wire::Message& message, Traffic& traffic) {
  const std::size_t size = message.ByteSizeLong();
  if (size > max_message_bytes)
    throw InputOutputError(
        fmt::format("A message of {} bytes cannot be sent, the limit is {}: the interface has too many points or "
                    "particles near it; use a larger spacing.",
                    size, max_message_bytes));
  const bool sent =
      socket.send(peer, size, [&](std::byte* bytes) { message.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(bytes)); });
  if (sent) traffic.bytes_sent += counted_bytes(message, size);
  return sent;
}

}  // namespace tern::proto
