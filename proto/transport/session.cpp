// Envelope and checks of one connection; the same code on both ends.

#include "proto/transport/session.hpp"

#include <fmt/format.h>

#include "base/peer_stopped.hpp"
#include "proto/wire/names.hpp"

namespace tern::proto {
namespace {

/// A sentence of another process goes to a terminal: control characters would reach it.
std::string printable(std::string sentence) {
  for (char& c : sentence)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return sentence;
}

}  // namespace

PeerLost lost(wire::Role role, std::uint32_t process_id, const Place& place) {
  const std::string who = name(role);
  const std::string id = process_id == 0 ? std::string() : fmt::format(" (process {})", process_id);
  return PeerLost(
      fmt::format("The {} process{} was lost {}: it was killed, crashed, or froze for more than 5 s, or the network to it was cut "
                  "that long. Its own messages and {}.log in the output directory may say why.",
                  who, id, where(place.step, place.time_s), who));
}

PeerLost bad_message(const std::string& who, const std::string& what, const Place& place, const std::string& fault) {
  return PeerLost(fmt::format("{} sent {} that cannot be used {}: {}. See docs/PROTOCOL.md, and run builds of one release.", who, what,
                              where(place.step, place.time_s), fault));
}

void Session::complete(wire::Message& message, const Place& place) {
  message.set_protocol_version(protocol_version);
  message.set_sender(self_);
  message.set_step(place.step);
  const std::string fault = find_body_fault(message, agreement_);
  if (!fault.empty())
    throw NumericalFailure(
        fmt::format("The {} process computed {} that cannot be sent {}: {}. A smaller fluid.numerics.courant or a "
                    "finer spacing may help; the frames before show where it began.",
                    name(self_), with_article(message.body_case()), where(place.step, place.time_s), fault));
  message.set_sequence(++sent_);
  remember(message, agreement_);
}

void Session::check(const wire::Message& message, const Place& place, std::initializer_list<Kind> expected) {
  std::string fault = find_envelope_fault(message, {peer_, received_ + 1, place.step}, expected);
  if (fault.empty()) fault = find_body_fault(message, agreement_);
  if (!fault.empty()) throw bad_message(fmt::format("The {} process", name(peer_)), with_article(message.body_case()), place, fault);
  if (message.body_case() == Kind::kAbort)
    throw PeerStopped(
        static_cast<ExitCode>(message.abort().exit_code()),
        fmt::format("The {} process stopped {}: {}", name(peer_), where(place.step, place.time_s), printable(message.abort().sentence())));
  ++received_;
  remember(message, agreement_);
}

wire::Message Session::abort_for(const Error& error, const Place& place) {
  std::string sentence = std::string(error.what()).substr(0, max_sentence_bytes);
  for (char& c : sentence)
    if (static_cast<unsigned char>(c) >= 0x80) c = '?';  // proto3 rejects text that is not UTF-8, e.g. a cut character
  wire::Message message;
  message.set_protocol_version(protocol_version);
  message.set_sender(self_);
  message.set_step(place.step);
  message.set_sequence(++sent_);
  message.mutable_abort()->set_exit_code(static_cast<int>(error.code()));
  message.mutable_abort()->set_sentence(sentence.empty() ? "no reason given" : sentence);
  return message;
}

}  // namespace tern::proto
