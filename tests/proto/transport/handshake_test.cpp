// The handshake refuses, one by one, everything that does not fit, and both sides name the same difference.
// Seen to fail, one at a time: each comparison of handshake.cpp removed; each half of the role check of
// CouplerChannel::accept removed.

#include <zmq.h>

#include "channel_fixture.hpp"
#include "proto/transport/channel.hpp"

namespace tern::proto {
namespace {

struct Refusal {
  Outcome coupler, participant;
};

/// A fluid whose Hello has been changed meets a coupler of case ab12 in 2D.
Refusal refusal(wire::Role role, const std::function<void(wire::Hello&)>& change) {
  TemporaryEndpoint endpoint;
  Refusal result;
  std::future<Outcome> participant;
  {
    CouplerChannel coupler(endpoint.address(), 10, 10);
    participant = in_thread([&] {
      ParticipantChannel channel(endpoint.address(), role, 10, 10);
      join(channel, role, change);
    });
    result.coupler = outcome_of([&] { coupler.accept({role}, "ab12", 2); });
    if (result.coupler.code == 0) coupler.welcome(2);
    result.participant = participant.get();
  }
  return result;
}

void expect_both_say(const Refusal& refusal, const std::string& part) {
  EXPECT_EQ(refusal.coupler.code, 2) << refusal.coupler.sentence;
  EXPECT_EQ(refusal.participant.code, 2) << refusal.participant.sentence;
  EXPECT_TRUE(refusal.coupler.says(part)) << refusal.coupler.sentence;
  EXPECT_TRUE(refusal.participant.says(part)) << refusal.participant.sentence;
}

TEST(Handshake, AFittingHelloIsWelcomed) {
  const Refusal none = refusal(wire::STRUCTURE, [](wire::Hello&) {});
  EXPECT_EQ(none.coupler.sentence, "");
  EXPECT_EQ(none.participant.sentence, "");
}

TEST(Handshake, AnotherCaseIsRefused) {
  expect_both_say(refusal(wire::FLUID, [](wire::Hello& h) { h.set_case_hash("cd34"); }),
                  "The fluid process runs the case with hash cd34, the coupler the one with hash ab12");
}

TEST(Handshake, AnotherDimensionIsRefused) {
  expect_both_say(refusal(wire::FLUID, [](wire::Hello& h) { h.set_dimension(3); }),
                  "The fluid process runs in 3 dimensions, the coupler in 2");
}

/// Hellos that our own participant would not send.
Refusal raw_refusal(const std::function<void(wire::Message&)>& change) {
  TemporaryEndpoint endpoint;
  CouplerChannel coupler(endpoint.address(), 10, 10);
  void* context = zmq_ctx_new();
  void* socket = zmq_socket(context, ZMQ_DEALER);
  const int linger = 0, patience = 3000;
  zmq_setsockopt(socket, ZMQ_LINGER, &linger, sizeof(linger));
  zmq_setsockopt(socket, ZMQ_RCVTIMEO, &patience, sizeof(patience));
  zmq_connect(socket, endpoint.address().c_str());
  wire::Message hello = samples::make(Kind::kHello, wire::STRUCTURE);
  hello.set_protocol_version(protocol_version);
  hello.set_sequence(1);
  change(hello);
  const std::string bytes = hello.SerializeAsString();
  zmq_send(socket, bytes.data(), bytes.size(), 0);
  Refusal result;
  result.coupler = outcome_of([&] { coupler.accept({wire::STRUCTURE}, "ab12", 2); });
  std::string answer(4096, '\0');
  const int size = zmq_recv(socket, answer.data(), answer.size(), 0);
  wire::Message message;
  if (size > 0 && message.ParseFromArray(answer.data(), size))
    result.participant = {message.abort().exit_code(), message.abort().sentence()};
  zmq_close(socket);
  zmq_ctx_term(context);
  return result;
}

TEST(Handshake, AnotherProtocolVersionIsRefused) {
  expect_both_say(raw_refusal([](wire::Message& m) { m.set_protocol_version(8); }),
                  "The structure process speaks protocol version 8, the coupler version 6");
}

TEST(Handshake, InconsistentCountsAreRefused) {
  expect_both_say(raw_refusal([](wire::Message& m) { m.mutable_hello()->mutable_surface()->add_section_mass(1); }),
                  "surface.section_mass has 3 entries; it must have 2");
  expect_both_say(raw_refusal([](wire::Message& m) { m.mutable_hello()->clear_surface(); }),
                  "the structure must have at least one surface point");
}

TEST(Handshake, AnythingBeforeHelloIsRefused) {
  expect_both_say(raw_refusal([](wire::Message& m) { m.mutable_finished(); }), "body is Finished; it must be Hello now");
}

TEST(Handshake, ARoleTakenTwiceOrUnknownIsRefusedWhileTheOthersGoOn) {
  TemporaryEndpoint endpoint;
  CouplerChannel coupler(endpoint.address(), 20, 20);
  const auto participant = [&](wire::Role role) {
    return in_thread([&, role] {
      ParticipantChannel channel(endpoint.address(), role, 20, 20);
      join(channel, role);
      channel.receive({Kind::kFinish});
      wire::Message finished;
      samples::account(finished.mutable_finished()->mutable_account(), role == wire::FLUID ? 2 : 3, 2);
      channel.send(finished);
    });
  };
  // The structure comes last, so that the coupler is still accepting when the second fluid knocks.
  std::future<Outcome> fluids[2], stranger, structure;
  auto starter = std::async(std::launch::async, [&] {
    fluids[0] = participant(wire::FLUID);
    fluids[1] = participant(wire::FLUID);
    stranger = participant(static_cast<wire::Role>(9));
    stranger.wait();
    while (fluids[0].wait_for(std::chrono::milliseconds(10)) != std::future_status::ready &&
           fluids[1].wait_for(std::chrono::milliseconds(10)) != std::future_status::ready) {}
    // A third fluid fails before it has joined, and says so.
    in_thread([&] { ParticipantChannel(endpoint.address(), wire::FLUID, 20, 20).abort(BadInput("the directory is full")); }).wait();
    structure = participant(wire::STRUCTURE);
  });
  coupler.accept(both, "ab12", 2);
  starter.get();
  coupler.welcome(2);
  for (const wire::Role role : both) coupler.send(role, samples::make(Kind::kFinish));
  for (const wire::Role role : both) coupler.receive(role, {Kind::kFinished});

  Outcome first = fluids[0].get(), second = fluids[1].get();
  if (first.code != 0) std::swap(first, second);
  EXPECT_EQ(first.sentence, "");
  EXPECT_EQ(second.code, 2);
  EXPECT_TRUE(second.says("this role is taken")) << second.sentence;
  const Outcome unknown = stranger.get();
  EXPECT_EQ(unknown.code, 2);
  EXPECT_TRUE(unknown.says("role 9 was refused: the case has no such role")) << unknown.sentence;
  EXPECT_EQ(structure.get().sentence, "");
}

}  // namespace
}  // namespace tern::proto
