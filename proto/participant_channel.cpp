// The participant's end of the channel: one connection, to the coupler.

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <utility>

#include "particles/log.hpp"
#include "particles/time.hpp"
#include "particles/version.hpp"
#include "proto/channel.hpp"
#include "proto/conversation.hpp"
#include "proto/endpoint.hpp"
#include "proto/names.hpp"
#include "proto/socket.hpp"
#include "proto/traffic.hpp"
#include "proto/waiting.hpp"

namespace tern::proto {

struct ParticipantChannel::State {
  State(const std::string& address, wire::Role self, double start_s, double progress_s)
      : endpoint(address),
        role(self),
        start_deadline_s(start_s),
        progress_deadline_s(progress_s),
        conversation(self, wire::COUPLER),
        socket(SocketKind::dealer) {}

  std::string endpoint;
  wire::Role role;
  double start_deadline_s, progress_deadline_s;
  Place place;
  Conversation conversation;
  Socket socket;
  Traffic traffic;
  bool coupler_gone = false;  // lost, or it said itself that it stops

  bool send(const wire::Message& message) { return send_message(socket, {}, message, traffic); }

  std::optional<wire::Message> take(std::initializer_list<Kind> expected) {
    std::optional<Arrived> arrived = take_message(socket, traffic);
    if (!arrived) return std::nullopt;
    if (!arrived->fault.empty()) throw bad_message("The coupler process", "a message", place, arrived->fault);
    if (arrived->message.body_case() == Kind::kAbort) coupler_gone = true;
    conversation.check(arrived->message, place, expected);
    return std::move(arrived->message);
  }

  /// Until the coupler has answered at all, it may still have to be started: another deadline, another sentence.
  wire::Message receive(std::initializer_list<Kind> expected, bool connected) {
    const Traffic::Exchange exchange(traffic);
    Waiting waiting(name(role), connected ? "coupler" : fmt::format("a coupler at {}", endpoint), place.step,
                    place.time_s, connected ? progress_deadline_s : start_deadline_s);
    for (;;) {
      if (auto message = take(expected)) return std::move(*message);
      bool lost_now = coupler_gone;
      while (const auto event = socket.next_event()) {
        if (event->what == SocketEvent::What::disconnected) lost_now = true;
        if (!connected && event->what == SocketEvent::What::connected) {
          connected = true;
          waiting = Waiting(name(role), "coupler", place.step, place.time_s, progress_deadline_s);
        }
      }
      waiting.check();
      if (lost_now) {
        coupler_gone = true;
        if (auto message = take(expected))
          return std::move(*message);  // its last words arrived before the end of the connection
        throw lost(wire::COUPLER, 0, place);
      }
      traffic.wait(socket);
    }
  }
};

ParticipantChannel::ParticipantChannel(const std::string& endpoint, wire::Role role, double start_deadline_s,
                                       double progress_deadline_s) {
  check_connect_endpoint(endpoint);
  state_ = std::make_unique<State>(endpoint, role, start_deadline_s, progress_deadline_s);
  state_->socket.connect(endpoint);
}

ParticipantChannel::~ParticipantChannel() = default;

wire::Welcome ParticipantChannel::handshake(wire::Hello hello) {
  hello.set_process_id(static_cast<std::uint32_t>(::getpid()));
  if (hello.version().empty()) hello.set_version(fmt::format("{} {}", program_version, git_hash));
  wire::Message message;
  *message.mutable_hello() = std::move(hello);
  send(std::move(message));
  const wire::Message answer = state_->receive({Kind::kWelcome}, false);
  log_info(fmt::format("joined the coupler (version {}) at {}: {} surface points", answer.welcome().version(),
                       state_->endpoint, answer.welcome().surface_points()));
  return answer.welcome();
}

void ParticipantChannel::send(wire::Message message) {
  const Traffic::Exchange exchange(state_->traffic);
  state_->conversation.complete(message, state_->place);
  if (!state_->send(message)) throw lost(wire::COUPLER, 0, state_->place);
}

wire::Message ParticipantChannel::receive(std::initializer_list<Kind> expected) {
  wire::Message message = state_->receive(expected, true);
  if (message.body_case() == Kind::kBeginWindow)
    set_step(message.step(), seconds(message.begin_window().begin_ticks()));
  return message;
}

void ParticipantChannel::set_step(std::uint64_t step, double time_s) { state_->place = {step, time_s}; }

void ParticipantChannel::abort(const Error& error) noexcept {
  if (state_->coupler_gone) return;
  try {
    state_->send(state_->conversation.abort_for(error, state_->place));
  } catch (...) {
    // The run ends because of `error`; that the coupler cannot be told is noticed there as a lost peer.
  }
}

double ParticipantChannel::wait_seconds() const { return state_->traffic.wait_s; }
double ParticipantChannel::exchange_seconds() const { return state_->traffic.exchange_s; }
std::uint64_t ParticipantChannel::bytes_sent() const { return state_->traffic.bytes_sent; }
std::uint64_t ParticipantChannel::bytes_received() const { return state_->traffic.bytes_received; }

}  // namespace tern::proto
