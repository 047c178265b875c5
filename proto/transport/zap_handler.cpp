// One REP socket at the address that ZeroMQ asks inside a process.

#include "proto/transport/zap_handler.hpp"

#include <fmt/format.h>
#include <zmq.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "proto/transport/zeromq.hpp"

namespace tern::proto {
namespace {

/// All frames of the next message; empty when there is none.
std::vector<std::string> receive(void* socket) {
  std::vector<std::string> frames;
  for (bool more = true; more;) {
    zmq_msg_t frame;
    zmq_msg_init(&frame);
    if (through_signals([&] { return zmq_msg_recv(&frame, socket, ZMQ_DONTWAIT); }) < 0) {
      zmq_msg_close(&frame);
      return {};
    }
    frames.emplace_back(static_cast<const char*>(zmq_msg_data(&frame)), zmq_msg_size(&frame));
    more = zmq_msg_more(&frame) != 0;
    zmq_msg_close(&frame);
  }
  return frames;
}

std::string z85(const std::string& key) {
  std::array<char, 41> text{};
  if (key.size() != 32) return {};
  return zmq_z85_encode(text.data(), reinterpret_cast<const std::uint8_t*>(key.data()), key.size()) ? text.data() : "";
}

}  // namespace

ZapHandler::ZapHandler(void* context, std::map<std::string, std::string> allowed)
    : socket_(zmq_socket(context, ZMQ_REP)), allowed_(std::move(allowed)) {
  require(socket_ != nullptr, "make a socket");
  const int none = 0;
  zmq_setsockopt(socket_, ZMQ_LINGER, &none, sizeof(none));
  require(through_signals([&] { return zmq_bind(socket_, "inproc://zeromq.zap.01"); }) == 0, "answer authentication requests");
}

ZapHandler::~ZapHandler() { zmq_close(socket_); }

std::optional<std::string> ZapHandler::answer() {
  for (;;) {
    // version, request id, domain, address, routing id, mechanism (always CURVE here), public key
    const std::vector<std::string> request = receive(socket_);
    if (request.size() < 7) return std::nullopt;
    const std::string key = z85(request[6]);
    const auto known = allowed_.find(key);
    const bool passes = known != allowed_.end();
    const std::vector<std::string> reply{
        "1.0", request[1], passes ? "200" : "400", passes ? "OK" : "not in the list", passes ? known->second : "", ""};
    for (std::size_t k = 0; k < reply.size(); ++k)
      through_signals(
          [&] { return zmq_send(socket_, reply[k].data(), reply[k].size(), ZMQ_DONTWAIT | (k + 1 < reply.size() ? ZMQ_SNDMORE : 0)); });
    if (!passes) return fmt::format("{} with the public key {}", request[3], key);
  }
}

int ZapHandler::descriptor() const { return proto::descriptor(socket_); }

}  // namespace tern::proto
