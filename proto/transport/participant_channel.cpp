// The participant's end of the channel: one connection, to the coupler.

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <utility>

#include "base/log.hpp"
#include "base/time.hpp"
#include "base/version.hpp"
#include "proto/transport/channel.hpp"
#include "proto/transport/endpoint.hpp"
#include "proto/transport/keys.hpp"
#include "proto/transport/session.hpp"
#include "proto/transport/silence.hpp"
#include "proto/transport/socket.hpp"
#include "proto/transport/traffic.hpp"
#include "proto/transport/waiting.hpp"
#include "proto/wire/names.hpp"

namespace tern::proto {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double nobody_there_s = 1;  // then the user is told; a run on one machine meets sooner
// Keys that do not fit look like a coupler that is just ending, and like a tunnel whose far end is not there yet.
constexpr std::chrono::seconds broken_off_patience{4};
// Of a handshake that ends after as long a silence nothing is known of keys: who should answer stands still (half of handshake_ms).
constexpr std::chrono::milliseconds silent{2500};

}  // namespace

struct ParticipantChannel::State {
  State(const Address& address, const std::optional<Keys>& own_keys, wire::Role self, double start_s, double progress_s)
      : endpoint(address.endpoint),
        keys(address.keys),
        role(self),
        start_deadline_s(start_s),
        progress_deadline_s(progress_s),
        session(self, wire::COUPLER),
        socket(SocketKind::dealer, own_keys) {}

  std::string endpoint, keys;
  wire::Role role;
  double start_deadline_s, progress_deadline_s;
  Place place;
  Session session;
  Socket socket;
  Traffic traffic;
  int connection = -1;
  Silence silence;
  bool coupler_gone = false;  // lost, or it said itself that it stops
  std::uint64_t wanted_step = 0;
  std::optional<wire::Checkpoint> kept;

  bool send(const wire::Message& message) { return send_message(socket, {}, message, traffic); }

  std::optional<wire::Message> take(std::initializer_list<Kind> expected) {
    std::optional<Arrived> arrived = take_message(socket, traffic);
    if (!arrived) return std::nullopt;
    if (!arrived->fault.empty()) throw bad_message("The coupler process", "a message", place, arrived->fault);
    if (arrived->message.body_case() == Kind::kAbort) {
      coupler_gone = true;
      wanted_step = arrived->message.abort().checkpoint().step();
    }
    session.check(arrived->message, place, expected);
    return std::move(arrived->message);
  }

  /// A sentence for the end of an attempt to connect that cannot succeed by waiting, empty otherwise.
  std::string hopeless(SocketEvent::What what) const {
    if (what == SocketEvent::What::key_refused)
      return fmt::format(
          "The coupler at {0} refused the key {1}/{2}.secret: its public key is not in the coupler's list. Copy the "
          "keys of this role from where ./tern keys made those of the coupler, or add the line \"{2} KEY\" with the "
          "key of {2}.public to its {3}.",
          endpoint, keys, name(role), allow_list);
    if (what == SocketEvent::What::other_security)
      return keys.empty()
                 ? fmt::format("The coupler at {} demands keys, and this {} was started without: add --keys DIR.", endpoint, name(role))
                 : fmt::format(
                       "The coupler at {} was started without keys, and this {} has some: start both with --keys "
                       "DIR, or both without.",
                       endpoint, name(role));
    return {};
  }

  /// The same for connections that are ended during the handshake again and again.
  std::string broken_off() const {
    return fmt::format("What answers at {} ends every connection during the handshake: {}, or it is no tern coupler.", endpoint,
                       keys.empty() ? std::string("the coupler there demands keys (add --keys DIR)")
                                    : fmt::format("{}/coupler.public is not the key of the coupler there (copy it from its machine), it "
                                                  "was started without keys",
                                                  keys));
  }

  /// Until the coupler has answered at all, it may still have to be started: another deadline, another sentence.
  wire::Message receive(std::initializer_list<Kind> expected, bool connected) {
    const Traffic::Exchange exchange(traffic);
    const std::string coupler = fmt::format("a coupler at {}", endpoint);
    Waiting waiting(name(role), connected ? "coupler" : coupler, place.step, place.time_s,
                    connected ? progress_deadline_s : start_deadline_s);
    if (place.step > 0) waiting.be_patient();
    std::optional<Clock::time_point> first_broken_off, reached;
    for (;;) {
      if (auto message = take(expected)) return std::move(*message);
      bool lost_now = coupler_gone;
      while (const auto event = socket.next_event()) {
        using What = SocketEvent::What;
        if (event->what == What::reached) {
          connection = event->connection;
          reached = Clock::now();
        }
        if (connected) {
          lost_now |= event->what == What::disconnected;
          continue;
        }
        if (event->what == What::connected) {
          connected = true;
          // It answers when everybody has come, and is the first to give up.
          waiting = Waiting(name(role), "coupler", place.step, place.time_s, 2 * start_deadline_s);
        } else if (event->what == What::nobody_there) {
          waiting.set_whom(coupler + ", where nobody answers (not started yet, another address, or a firewall)");
          waiting.speak_after(nobody_there_s);
        } else if (event->what == What::broken_off && reached && Clock::now() - *reached > silent) {
          waiting.set_whom(coupler + ", which is silent during the handshake (it stands still, or it is no coupler)");
        } else if (event->what == What::broken_off || event->what == What::other_key) {
          if (!first_broken_off) first_broken_off = Clock::now();
          waiting.set_whom(coupler + ", which ends the connection during the handshake");
        } else if (const std::string sentence = hopeless(event->what); !sentence.empty()) {
          throw BadInput(sentence);
        }
      }
      if (!connected && first_broken_off && Clock::now() - *first_broken_off > broken_off_patience) throw BadInput(broken_off());
      waiting.check();
      lost_now |= connected && silence.too_long(connection, waiting.present_s());
      if (lost_now) {
        coupler_gone = true;
        if (auto message = take(expected)) return std::move(*message);  // its last words arrived before the end of the connection
        throw lost(wire::COUPLER, 0, place);
      }
      traffic.wait(socket);
    }
  }
};

ParticipantChannel::ParticipantChannel(const Address& address, wire::Role role, double start_deadline_s, double progress_deadline_s) {
  const std::string endpoint = resolved(address.endpoint);
  const auto keys = keys_for(endpoint, address.keys, address.insecure, name(role));
  state_ = std::make_unique<State>(address, keys, role, start_deadline_s, progress_deadline_s);
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
  log_info(fmt::format("joined the coupler (version {}) at {}: {} surface points", answer.welcome().version(), state_->endpoint,
                       answer.welcome().surface_points()));
  return answer.welcome();
}

void ParticipantChannel::send(wire::Message message) {
  const Traffic::Exchange exchange(state_->traffic);
  state_->session.complete(message, state_->place);
  if (!state_->send(message)) throw lost(wire::COUPLER, 0, state_->place);
}

wire::Message ParticipantChannel::receive(std::initializer_list<Kind> expected) {
  wire::Message message = state_->receive(expected, true);
  if (message.body_case() == Kind::kBeginWindow) set_step(message.step(), seconds(message.begin_window().begin_ticks()));
  return message;
}

void ParticipantChannel::set_step(std::uint64_t step, double time_s) { state_->place = {step, time_s}; }

void ParticipantChannel::resume(std::uint64_t step, double time_s, std::uint64_t bytes_sent, std::uint64_t bytes_received) {
  set_step(step, time_s);
  state_->traffic.bytes_sent = bytes_sent;
  state_->traffic.bytes_received = bytes_received;
}

void ParticipantChannel::abort(const Error& error) noexcept {
  if (state_->coupler_gone && (state_->wanted_step == 0 || !state_->kept)) return;
  try {
    wire::Message message = state_->session.abort_for(error, state_->place);
    if (state_->kept) *message.mutable_abort()->mutable_checkpoint() = *state_->kept;
    state_->send(message);
  } catch (...) {
    // The run ends because of `error`; that the coupler cannot be told is noticed there as a lost peer.
  }
}

bool ParticipantChannel::coupler_gone() const { return state_->coupler_gone; }

std::uint64_t ParticipantChannel::wanted_step() const { return state_->wanted_step; }

void ParticipantChannel::set_kept(std::uint64_t step, const std::string& hash) {
  state_->kept.emplace();
  state_->kept->set_step(step);
  state_->kept->set_hash(hash);
}

double ParticipantChannel::wait_seconds() const { return state_->traffic.wait_s; }
double ParticipantChannel::exchange_seconds() const { return state_->traffic.exchange_s; }
std::uint64_t ParticipantChannel::bytes_sent() const { return state_->traffic.bytes_sent; }
std::uint64_t ParticipantChannel::bytes_received() const { return state_->traffic.bytes_received; }

}  // namespace tern::proto
