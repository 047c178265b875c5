#pragma once
// One side's view of one connection: sequence numbers both ways and what was agreed; turns faults into errors.

#include <cstdint>
#include <initializer_list>
#include <string>

#include "base/error.hpp"
#include "proto/wire/message_check.hpp"

namespace tern::proto {

/// Where this process stands, for envelopes and sentences.
struct Place {
  std::uint64_t step = 0;
  double time_s = 0;
};

/// The error that ends the run when `role` is gone. `process_id` 0 = not known.
PeerLost lost(wire::Role role, std::uint32_t process_id, const Place& place);

/// The error for a message that must not be used.
PeerLost bad_message(const std::string& who, const std::string& what, const Place& place, const std::string& fault);

class Session {
 public:
  Session(wire::Role self, wire::Role peer) : self_(self), peer_(peer) {}

  /// Completes the envelope of an outgoing message and checks its body. Throws NumericalFailure naming the value.
  void complete(wire::Message& message, const Place& place);

  /// Checks an incoming message and keeps what later ones are checked against. Throws PeerLost; for a proper Abort the
  /// Error it carries, with the sender named.
  void check(const wire::Message& message, const Place& place, std::initializer_list<Kind> expected);

  /// Builds the Abort for `error`: ASCII and within the size limit, so that it can always be read.
  wire::Message abort_for(const Error& error, const Place& place);

  wire::Role peer() const { return peer_; }

 private:
  wire::Role self_, peer_;
  std::uint64_t sent_ = 0, received_ = 0;
  Agreement agreement_;
};

}  // namespace tern::proto
