#pragma once
// The channel between the three processes: the coupler binds a ROUTER socket, the participants connect DEALER sockets.
// Every wait notices interruption, a lost peer (monitor and silence), an Abort from anybody and the progress
// deadline. docs/PROTOCOL.md is the numbered call order; tern.proto is the schema.

#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "proto/wire/protocol.hpp"

namespace tern::proto {

/// Where the coupler is, and how the two make sure of each other.
struct Address {
  Address(std::string where, std::string keys_directory = {}, bool without_keys = false)
      : endpoint(std::move(where)), keys(std::move(keys_directory)), insecure(without_keys) {}
  std::string endpoint;   ///< ipc://PATH or tcp://HOST:PORT
  std::string keys;       ///< directory of the keys (keys.hpp); empty: no encryption, for this machine only
  bool insecure = false;  ///< no keys on a network either; every start says so
};

/// One participant's end (fluid or structure). One object per process, for its whole life; not thread-safe.
class ParticipantChannel {
 public:
  /// Connects; returns at once, the coupler may start later. Throws BadInput when address or keys cannot be used. Given up as
  /// PeerLost is a coupler that is not there after `start_deadline_s`, one that is but waits for the other participant for twice
  /// that, and one that later leaves a message out for `progress_deadline_s`.
  ParticipantChannel(const Address& address, wire::Role role, double start_deadline_s = 300, double progress_deadline_s = 300);
  ~ParticipantChannel();
  ParticipantChannel(const ParticipantChannel&) = delete;
  ParticipantChannel& operator=(const ParticipantChannel&) = delete;

  /// Says hello and waits for the answer. Fills Hello.process_id, and Hello.version when it is empty. Throws the error
  /// of the coupler's Abort (BadInput when the two do not fit), BadInput when the keys do not fit, PeerLost when nobody answers.
  wire::Welcome handshake(wire::Hello hello);

  /// Fills protocol_version, sender, sequence and step, checks the content and sends it; never blocks.
  /// Throws NumericalFailure when a value may not be sent (not finite, out of its physical bounds).
  void send(wire::Message message);

  /// Waits for the next message of the coupler and checks it. Throws PeerLost (lost, stuck, bad message, a kind that is
  /// not `expected`), Interrupted, or an Error with the exit code of an Abort. The numbers of surface points and of interface
  /// particles are known from Welcome, Hello and the InterfaceParticles sent last. An accepted BeginWindow sets step and time as
  /// set_step does.
  wire::Message receive(std::initializer_list<Kind> expected);

  /// Window number of the messages to come and its begin [s], for messages and sentences.
  void set_step(std::uint64_t step, double time_s);

  /// Tells the coupler why this process ends, and what it has kept; does nothing when the coupler is gone. An error that comes from the
  /// coupler's own Abort is sent back only as the answer to its question for a checkpoint.
  void abort(const Error& error) noexcept;
  /// The step of which the coupler's Abort wants a checkpoint; 0: of none, or there was no Abort.
  std::uint64_t wanted_step() const;
  /// Whether the coupler was lost or has said that it stops.
  bool coupler_gone() const;
  /// A checkpoint has been written after a failure.
  void set_kept(std::uint64_t step, const std::string& hash);

  /// Goes on from a checkpoint: number and end [s] of its window, and the traffic until then.
  void resume(std::uint64_t step, double time_s, std::uint64_t bytes_sent, std::uint64_t bytes_received);

  double wait_seconds() const;      ///< waiting for messages [s]
  double exchange_seconds() const;  ///< building, checking, sending, parsing [s]
  std::uint64_t bytes_sent() const;
  std::uint64_t bytes_received() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The coupler's end. One object per process, for its whole life; not thread-safe.
class CouplerChannel {
 public:
  /// Binds and logs the endpoint (port * = any free one). Throws BadInput for an address or keys that cannot be used, among them
  /// a network address without keys, InputOutputError when the socket file cannot be made or the port is in use.
  explicit CouplerChannel(const Address& address, double start_deadline_s = 300, double progress_deadline_s = 300);
  ~CouplerChannel();  ///< removes the ipc socket file; pending messages get at most 0.5 s
  CouplerChannel(const CouplerChannel&) = delete;
  CouplerChannel& operator=(const CouplerChannel&) = delete;

  const std::string& endpoint() const;  ///< as bound, with the real port

  /// From here on, writes every message that is accepted from a participant to a file (message_record.hpp), anew or at its end.
  void record(const std::string& path, bool anew = true);
  /// Length of that file [bytes]; 0 without.
  std::uint64_t record_mark();

  /// Waits for one Hello of each expected role. The first difference (protocol version, case hash, dimension, counts)
  /// is sent back as Abort and thrown as BadInput; a role taken twice, not expected or not that of the key, and somebody whose
  /// first words are no message, is refused and logged, the others go on.
  std::map<wire::Role, wire::Hello> accept(const std::set<wire::Role>& expected, const std::string& case_hash, int dimension);

  /// Answers every Hello: the run begins. `welcome` lacks the number of points in the structure's Hello, `surface_points`, and the version.
  void welcome(std::uint32_t surface_points, wire::Welcome welcome = {});

  /// Has every participant keep its state between two windows; what each answers.
  std::map<wire::Role, std::string> save();

  /// As ParticipantChannel::resume; the record goes back to a length.
  void resume(std::uint64_t step, double time_s, std::uint64_t bytes_sent, std::uint64_t bytes_received, std::uint64_t record_bytes);

  /// As ParticipantChannel::send, to one participant.
  void send(wire::Role to, wire::Message message);

  /// Waits for the next message of `from`; messages of the other participant are kept for its own receive. Errors as
  /// ParticipantChannel::receive, whichever participant causes them. After an accepted Finished a participant may
  /// leave.
  wire::Message receive(wire::Role from, std::initializer_list<Kind> expected);

  /// Throws the error of a message of `from` that was accepted, and turns out to have this fault.
  [[noreturn]] void reject(wire::Role from, Kind kind, const std::string& fault) const;

  void set_step(std::uint64_t step, double time_s);

  /// Sends Abort to every participant that is still there, except the one whose Abort is being passed on.
  void abort(const Error& error) noexcept;

  /// The same, and asks those participants to keep their state at the end of `step`, for which it waits `patience_s`; what all of them
  /// have kept. Empty unless that is so.
  std::map<wire::Role, std::string> abort_keeping(const Error& error, std::uint64_t step, double patience_s);
  /// What the participant that has stopped has kept; `otherwise` when none has stopped.
  std::uint64_t kept_step(std::uint64_t otherwise) const;

  double wait_seconds() const;
  double exchange_seconds() const;
  std::uint64_t bytes_sent() const;
  std::uint64_t bytes_received() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tern::proto
