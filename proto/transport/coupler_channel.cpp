// The coupler's end of the channel: one connection per participant, told apart by routing id; the monitor knows them
// only by file descriptor, which the first message of each brings along.

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <deque>
#include <functional>
#include <optional>
#include <utility>

#include "base/log.hpp"
#include "base/version.hpp"
#include "proto/transport/channel.hpp"
#include "proto/transport/endpoint.hpp"
#include "proto/transport/keys.hpp"
#include "proto/transport/session.hpp"
#include "proto/transport/silence.hpp"
#include "proto/transport/socket.hpp"
#include "proto/transport/traffic.hpp"
#include "proto/transport/waiting.hpp"
#include "proto/wire/handshake.hpp"
#include "proto/wire/message_record.hpp"
#include "proto/wire/names.hpp"

namespace tern::proto {
namespace {

constexpr std::size_t max_pending = 16;  // the protocol never has more than two

struct Peer {
  std::string routing_id;
  int connection;
  std::uint32_t process_id;
  Session session;
  std::deque<wire::Message> inbox;
  bool settled = false;                       // what happened to its connection before it joined is known
  bool finished = false;                      // may leave
  bool gone = false;                          // lost, or stopped by its own Abort
  std::optional<wire::Checkpoint> kept = {};  // after a failure
  Silence silence = {};
};

/// Tells the log who was turned away: the first at once, then at most a line every 5 s, whoever floods the port.
class Refusals {
 public:
  void add(const std::string& sentence) {
    ++count_;
    const auto now = std::chrono::steady_clock::now();
    if (count_ > 1 && now < next_) return;
    const long more = count_ - told_ - 1;
    log_warning(more > 0 ? fmt::format("{} ({} more since the last such line)", sentence, more) : sentence);
    told_ = count_;
    next_ = now + std::chrono::seconds(5);
  }
  ~Refusals() {
    if (count_ > told_) log_info(fmt::format("{} more were refused without a line of their own", count_ - told_));
  }

 private:
  long count_ = 0, told_ = 0;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace

struct CouplerChannel::State {
  State(const std::optional<Keys>& own_keys, const std::string& directory, double start_s, double progress_s)
      : secured(own_keys.has_value()),
        keys(directory),
        start_deadline_s(start_s),
        progress_deadline_s(progress_s),
        socket(SocketKind::router, own_keys) {}

  bool secured;
  std::string keys;  // their directory

  double start_deadline_s, progress_deadline_s;
  std::string endpoint;
  Place place;
  Socket socket;
  Traffic traffic;
  std::map<wire::Role, Peer> peers;
  std::optional<MessageRecord> record;
  std::set<std::string> refused;  // routing ids that have been answered with Abort
  Refusals refusals;

  void keep(Peer& peer, Arrived&& arrived) {
    const std::string who = fmt::format("The {} process", name(peer.session.peer()));
    if (!arrived.fault.empty()) throw bad_message(who, "a message", place, arrived.fault);
    if (arrived.message.body_case() == Kind::kAbort) {
      peer.gone = true;
      if (arrived.message.abort().has_checkpoint()) peer.kept = arrived.message.abort().checkpoint();
      // It ends as Finish has told it to; the answer of the other one may still be on its way.
      if (peer.finished && arrived.message.abort().exit_code() == static_cast<int>(ExitCode::interrupted)) return;
      peer.session.check(arrived.message, place, {});
    }
    if (peer.inbox.size() >= max_pending)
      throw bad_message(who, "a message", place, fmt::format("{} messages wait already; the limit is {}", peer.inbox.size(), max_pending));
    if (arrived.message.body_case() == Kind::kFinished) peer.finished = true;
    peer.inbox.push_back(std::move(arrived.message));
  }

  void take_all(const std::function<void(Arrived&&)>& stranger) {
    while (auto arrived = take_message(socket, traffic)) {
      bool known = false;
      for (auto& [role, peer] : peers)
        if (peer.routing_id == arrived->peer) {
          known = true;
          keep(peer, std::move(*arrived));
          break;
        }
      if (!known && !refused.contains(arrived->peer)) stranger(std::move(*arrived));
    }
  }

  /// Sorts everything that has arrived; throws when somebody aborted or is lost.
  void collect(Waiting& waiting, const std::function<void(Arrived&&)>& stranger) {
    take_all(stranger);
    // What has become of each connection. A participant that has just joined may have got the descriptor that a stranger has
    // given up, so of what happened before only the last event counts; later any loss is its own.
    std::map<int, bool> open, closed;
    while (const auto event = socket.next_event()) {
      if (event->what == SocketEvent::What::accepted || event->what == SocketEvent::What::disconnected)
        open[event->connection] = event->what == SocketEvent::What::accepted;
      if (event->what == SocketEvent::What::disconnected) closed[event->connection] = true;
      const std::string sentence = refusal(*event);
      if (!sentence.empty()) refusals.add(sentence);
    }
    bool anybody_left = false;
    for (auto& [role, peer] : peers) {
      const auto found = open.find(peer.connection);
      if (peer.settled ? closed.contains(peer.connection) : found != open.end() && !found->second) peer.gone = anybody_left = true;
      peer.settled = true;
    }
    for (const auto& [role, peer] : peers)
      if (!peer.gone) socket.joined(peer.connection);
    if (anybody_left) take_all(stranger);  // last words arrived before the end of the connection
    waiting.check();                       // our own interruption first: after Ctrl-C the others leave as well
    for (auto& [role, peer] : peers) {
      if (!peer.gone && peer.silence.too_long(peer.connection, waiting.present_s())) peer.gone = true;
      if (peer.gone && !peer.finished) throw lost(role, peer.process_id, place);
    }
  }

  /// A sentence for a connection that did not come about, empty for other events.
  std::string refusal(const SocketEvent& event) const {
    switch (event.what) {
      case SocketEvent::What::key_refused:
        return fmt::format("refused a process at {}, which is not in {}/{}", event.who, keys, allow_list);
      case SocketEvent::What::other_security:
        return secured ? "refused a process that came without keys: every participant of this run needs --keys DIR"
                       : "refused a process that came with keys, and this coupler has none: start it with --keys DIR as well";
      case SocketEvent::What::other_key:
        return fmt::format("refused a process that took this coupler for another one: its coupler.public is not that of {}", keys);
      case SocketEvent::What::broken_off:
        if (!socket_file(endpoint).empty()) return {};  // another coupler has looked whether this one is alive
        return secured ? "a process connected and left before it had joined: it came without keys, was too slow, or is no participant"
                       : "a process connected and left before it had joined: it came with keys (this coupler has none), was too slow, "
                         "or is no participant";
      default: return {};
    }
  }

  void refuse(const std::string& routing_id, const Error& error) {
    refused.insert(routing_id);
    Session stranger(wire::COUPLER, wire::ROLE_UNSPECIFIED);
    send_message(socket, routing_id, stranger.abort_for(error, place), traffic);
  }

  void send(Peer& peer, const wire::Message& message) {
    if (peer.gone || !send_message(socket, peer.routing_id, message, traffic)) throw lost(peer.session.peer(), peer.process_id, place);
  }

  void abort(const Error& error) noexcept {
    for (auto& [role, peer] : peers) {
      if (peer.gone || peer.finished) continue;
      peer.gone = true;
      try {
        send_message(socket, peer.routing_id, peer.session.abort_for(error, place), traffic);
      } catch (...) {
        // The run ends because of `error`; a participant that cannot be told notices the lost connection.
      }
    }
  }

  /// Last words of those who have been asked for a checkpoint; whatever else they had sent is of a window that is given up.
  void take_last_words(std::set<wire::Role>& waited_for) {
    const auto hear = [&] {
      while (const auto arrived = take_message(socket, traffic))
        for (auto& [role, peer] : peers)
          if (peer.routing_id == arrived->peer && arrived->fault.empty() && arrived->message.has_abort() && waited_for.erase(role) > 0 &&
              arrived->message.abort().has_checkpoint())
            peer.kept = arrived->message.abort().checkpoint();
    };
    hear();
    std::set<int> left;
    while (const auto event = socket.next_event())
      if (event->what == SocketEvent::What::disconnected) left.insert(event->connection);
    if (!left.empty()) hear();  // what arrived before the end of the connection
    for (const auto& [role, peer] : peers)
      if (left.contains(peer.connection)) waited_for.erase(role);
  }

  Peer& peer(wire::Role role) {
    const auto found = peers.find(role);
    if (found == peers.end()) throw std::logic_error(fmt::format("no {} has joined", name(role)));
    return found->second;
  }
};

CouplerChannel::CouplerChannel(const Address& address, double start_deadline_s, double progress_deadline_s) {
  const std::string endpoint = resolved(address.endpoint);
  const auto keys = keys_for(endpoint, address.keys, address.insecure, "coupler");
  check_socket_file(endpoint);
  state_ = std::make_unique<State>(keys, address.keys, start_deadline_s, progress_deadline_s);
  state_->endpoint = state_->socket.bind(endpoint);
  const std::string file = socket_file(state_->endpoint);
  if (!file.empty()) ::chmod(file.c_str(), S_IRUSR | S_IWUSR);  // nobody else may join
  log_info(keys ? fmt::format("bound to {}, for the {} keys of {}/{}", state_->endpoint, keys->allowed.size(), address.keys, allow_list)
                : fmt::format("bound to {}", state_->endpoint));
}

CouplerChannel::~CouplerChannel() {
  const std::string file = state_ ? socket_file(state_->endpoint) : std::string();
  state_.reset();
  if (!file.empty()) ::unlink(file.c_str());
}

const std::string& CouplerChannel::endpoint() const { return state_->endpoint; }

void CouplerChannel::record(const std::string& path, bool anew) { state_->record.emplace(path, anew); }

std::uint64_t CouplerChannel::record_mark() { return state_->record ? state_->record->mark() : 0; }

std::map<wire::Role, wire::Hello> CouplerChannel::accept(const std::set<wire::Role>& expected, const std::string& case_hash,
                                                         int dimension) {
  const Traffic::Exchange exchange(state_->traffic);
  std::map<wire::Role, wire::Hello> hellos;
  std::map<wire::Role, wire::Message> to_record;  // in the order of roles, whoever comes first
  const auto meet = [&](Arrived&& arrived) {
    const auto stop = [&](const std::string& sentence) {
      const BadInput error(sentence);
      state_->refuse(arrived.peer, error);
      state_->abort(error);
      throw error;
    };
    const wire::Message& message = arrived.message;
    const wire::Role role = message.sender();
    const auto turn_away = [&](const std::string& sentence) {
      state_->refuse(arrived.peer, BadInput(sentence));
      state_->refusals.add(sentence);
    };
    if (!arrived.fault.empty()) return turn_away(bad_message("A stranger", "a message", state_->place, arrived.fault).what());
    if (state_->secured && arrived.role != name(role))
      return turn_away(
          fmt::format("A process with a key of the {0} calls itself {1} and was refused: start each participant with the "
                      "keys of its own role.",
                      arrived.role, name(role)));
    if (!expected.contains(role) || state_->peers.contains(role))
      return turn_away(
          fmt::format("A process that calls itself {} was refused: {}.", name(role),
                      expected.contains(role) ? "this role is taken; start each participant once" : "the case has no such role"));
    if (message.body_case() == Kind::kAbort) {  // it failed before it joined
      state_->refused.insert(arrived.peer);
      Session(wire::COUPLER, role).check(message, state_->place, {});
    }
    if (message.body_case() == Kind::kHello) {
      const std::string difference = find_difference(message, case_hash, dimension);
      if (!difference.empty()) stop(difference);
    }
    Session session(wire::COUPLER, role);
    try {
      session.check(message, state_->place, {Kind::kHello});
    } catch (const PeerLost& fault) {
      stop(fault.what());
    }
    if (state_->record && message.hello().checkpoint().empty()) to_record.emplace(role, message);
    const wire::Hello& hello = message.hello();
    log_info(fmt::format("{} joined: process {}, version {}, {} particles, {} surface points", name(role), hello.process_id(),
                         hello.version(), hello.particles(), hello.surface().body_size()));
    state_->peers.emplace(role, Peer{arrived.peer, arrived.connection, hello.process_id(), session, {}});
    hellos.emplace(role, hello);
  };

  Waiting waiting("coupler", "", 0, 0, state_->start_deadline_s);
  for (;;) {
    std::string missing;
    for (const wire::Role role : expected)
      if (!state_->peers.contains(role)) missing += (missing.empty() ? "" : " and ") + name(role);
    waiting.set_whom(missing.empty() ? "nobody" : missing);
    if (missing.empty()) {
      for (const auto& [role, message] : to_record) state_->record->write(message);
      return hellos;
    }
    state_->collect(waiting, meet);
    if (state_->peers.size() < expected.size()) state_->traffic.wait(state_->socket);
  }
}

void CouplerChannel::welcome(std::uint32_t surface_points, wire::Welcome welcome) {
  wire::Message message;
  *message.mutable_welcome() = std::move(welcome);
  message.mutable_welcome()->set_surface_points(surface_points);
  message.mutable_welcome()->set_version(fmt::format("{} {}", program_version, git_hash));
  for (const auto& [role, peer] : state_->peers) send(role, message);
}

std::map<wire::Role, std::string> CouplerChannel::save() {
  std::map<wire::Role, std::string> answers;
  for (const auto& [role, peer] : state_->peers) {
    wire::Message message;
    message.mutable_save();
    send(role, std::move(message));
  }
  for (const auto& [role, peer] : state_->peers) answers[role] = receive(role, {Kind::kSaved}).saved().hash();
  return answers;
}

void CouplerChannel::resume(std::uint64_t step, double time_s, std::uint64_t bytes_sent, std::uint64_t bytes_received,
                            std::uint64_t record_bytes) {
  set_step(step, time_s);
  state_->traffic.bytes_sent = bytes_sent;
  state_->traffic.bytes_received = bytes_received;
  if (state_->record) state_->record->go_back(record_bytes);
}

void CouplerChannel::send(wire::Role to, wire::Message message) {
  const Traffic::Exchange exchange(state_->traffic);
  Peer& peer = state_->peer(to);
  peer.session.complete(message, state_->place);
  state_->send(peer, message);
}

wire::Message CouplerChannel::receive(wire::Role from, std::initializer_list<Kind> expected) {
  const Traffic::Exchange exchange(state_->traffic);
  const auto ignore = [&](Arrived&& arrived) {
    const BadInput error("The run has begun; nobody can join it any more.");
    state_->refusals.add(fmt::format("a process that calls itself {} was refused: {}", name(arrived.message.sender()), error.what()));
    state_->refuse(arrived.peer, error);
  };
  Waiting waiting("coupler", name(from), state_->place.step, state_->place.time_s, state_->progress_deadline_s);
  if (state_->place.step > 0) waiting.be_patient();
  Peer& peer = state_->peer(from);
  for (;;) {
    state_->collect(waiting, ignore);
    if (!peer.inbox.empty()) {
      wire::Message message = std::move(peer.inbox.front());
      peer.inbox.pop_front();
      peer.session.check(message, state_->place, expected);
      if (state_->record && !message.has_saved()) state_->record->write(message);
      return message;
    }
    if (peer.gone) throw lost(from, peer.process_id, state_->place);
    state_->traffic.wait(state_->socket);
  }
}

void CouplerChannel::reject(wire::Role from, Kind kind, const std::string& fault) const {
  throw bad_message(fmt::format("The {} process", name(from)), with_article(kind), state_->place, fault);
}

void CouplerChannel::set_step(std::uint64_t step, double time_s) { state_->place = {step, time_s}; }

void CouplerChannel::abort(const Error& error) noexcept { state_->abort(error); }

std::uint64_t CouplerChannel::kept_step(std::uint64_t otherwise) const {
  for (const auto& [role, peer] : state_->peers)
    if (peer.gone) return peer.kept ? peer.kept->step() : 0;
  return otherwise;
}

std::map<wire::Role, std::string> CouplerChannel::abort_keeping(const Error& error, std::uint64_t step, double patience_s) {
  std::set<wire::Role> waited_for;
  for (auto& [role, peer] : state_->peers) {
    if (peer.gone || peer.finished) continue;
    peer.gone = true;
    wire::Message message = peer.session.abort_for(error, state_->place);
    message.mutable_abort()->mutable_checkpoint()->set_step(step);
    if (send_message(state_->socket, peer.routing_id, message, state_->traffic)) waited_for.insert(role);
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
  while (!waited_for.empty() && std::chrono::steady_clock::now() < end) {
    state_->traffic.wait(state_->socket);
    state_->take_last_words(waited_for);
  }
  std::map<wire::Role, std::string> kept;
  for (const auto& [role, peer] : state_->peers)
    if (peer.kept && peer.kept->step() == step) kept[role] = peer.kept->hash();
  return kept.size() == state_->peers.size() ? kept : std::map<wire::Role, std::string>{};
}

double CouplerChannel::wait_seconds() const { return state_->traffic.wait_s; }
double CouplerChannel::exchange_seconds() const { return state_->traffic.exchange_s; }
std::uint64_t CouplerChannel::bytes_sent() const { return state_->traffic.bytes_sent; }
std::uint64_t CouplerChannel::bytes_received() const { return state_->traffic.bytes_received; }

}  // namespace tern::proto
