// A whole run over real sockets: windows in the order of docs/PROTOCOL.md, aborts, bad messages, endpoints.
// Seen to fail, one at a time: sequence not raised in Session::check, BeginWindow not setting the participant's
// step, nothing sent by CouplerChannel::abort, the socket file neither made private nor removed, no limit of waiting
// messages, extra frames accepted, the test for a loopback address in keys_for, those of check_socket_file for a
// file that is no socket and for one in use removed.

#include "proto/transport/channel.hpp"

#include <sys/time.h>
#include <zmq.h>

#include <csignal>
#include <fstream>
#include <future>
#include <limits>

#include "channel_fixture.hpp"

namespace tern::proto {
namespace {

void fluid_run(const std::string& address) {
  ParticipantChannel channel(address, wire::FLUID, 10, 10);
  join(channel, wire::FLUID);
  for (;;) {
    const wire::Message begin = channel.receive({Kind::kBeginWindow, Kind::kFinish});
    if (begin.has_finish()) break;
    channel.receive({Kind::kSurface});
    channel.send(samples::make(Kind::kInterfaceParticles));
    channel.receive({Kind::kInterfaceCondition});
    channel.send(samples::make(Kind::kInterfacePressure));
    while (channel.receive({Kind::kInterfaceCondition, Kind::kInterfaceForce}).has_interface_condition())
      channel.send(samples::make(Kind::kInterfacePressure));
    channel.send(samples::make(Kind::kWindowDone));
  }
  channel.send(samples::make(Kind::kFinished));
  EXPECT_GT(channel.bytes_sent(), 0u);
  EXPECT_GT(channel.bytes_received(), 0u);
  EXPECT_GT(channel.wait_seconds(), 0);
  EXPECT_GT(channel.exchange_seconds(), 0);
}

void structure_run(const std::string& address) {
  ParticipantChannel channel(address, wire::STRUCTURE, 10, 10);
  join(channel, wire::STRUCTURE);
  for (;;) {
    const wire::Message begin = channel.receive({Kind::kBeginWindow, Kind::kFinish});
    if (begin.has_finish()) break;
    channel.send(samples::make(Kind::kSurface, wire::STRUCTURE));
    if (!channel.receive({Kind::kSurfaceLoad}).surface_load().trial()) continue;
    channel.send(samples::make(Kind::kSurfaceVelocity, wire::STRUCTURE));
    channel.receive({Kind::kSurfaceLoad});
  }
  wire::Message finished;
  samples::account(finished.mutable_finished()->mutable_account(), 3, 2);
  channel.send(finished);
}

void begin_window(CouplerChannel& channel, std::uint64_t step) {
  channel.set_step(step, 1e-3 * static_cast<double>(step));
  wire::Message begin = samples::make(Kind::kBeginWindow);
  begin.mutable_begin_window()->set_begin_ticks(50 * (static_cast<std::int64_t>(step) - 1));
  channel.send(wire::FLUID, begin);
  channel.send(wire::STRUCTURE, begin);
}

void window(CouplerChannel& channel, std::uint64_t step) {
  begin_window(channel, step);
  wire::Message surface = channel.receive(wire::STRUCTURE, {Kind::kSurface});
  surface.mutable_surface()->clear_account();
  channel.send(wire::FLUID, surface);
  const wire::Message particles = channel.receive(wire::FLUID, {Kind::kInterfaceParticles});
  EXPECT_EQ(particles.interface_particles().id(2), 9u);
  channel.send(wire::FLUID, samples::make(Kind::kInterfaceCondition));
  channel.receive(wire::FLUID, {Kind::kInterfacePressure});
  if (step % 2 == 0) {  // this window is tried a second time
    wire::Message trial = samples::make(Kind::kSurfaceLoad);
    trial.mutable_surface_load()->set_trial(true);
    channel.send(wire::STRUCTURE, trial);
    const auto answer = channel.receive(wire::STRUCTURE, {Kind::kSurfaceVelocity});
    wire::Message load = samples::make(Kind::kInterfaceCondition);
    *load.mutable_interface_condition()->mutable_surface_velocity() = answer.surface_velocity().velocity();
    channel.send(wire::FLUID, load);
    channel.receive(wire::FLUID, {Kind::kInterfacePressure});
  }
  channel.send(wire::FLUID, samples::make(Kind::kInterfaceForce));
  channel.send(wire::STRUCTURE, samples::make(Kind::kSurfaceLoad));
  channel.receive(wire::FLUID, {Kind::kWindowDone});
}

void finish(CouplerChannel& channel) {
  channel.send(wire::FLUID, samples::make(Kind::kFinish));
  channel.send(wire::STRUCTURE, samples::make(Kind::kFinish));
  channel.receive(wire::FLUID, {Kind::kFinished});
  channel.receive(wire::STRUCTURE, {Kind::kFinished});
}

void whole_run(const std::string& address) {
  CouplerChannel coupler(address, 10, 10);
  auto fluid = in_thread([&] { fluid_run(coupler.endpoint()); });
  auto structure = in_thread([&] { structure_run(coupler.endpoint()); });
  const Outcome own = outcome_of([&] {
    const auto hellos = coupler.accept(both, "ab12", 2);
    EXPECT_EQ(hellos.at(wire::STRUCTURE).surface().body_size(), 2);
    EXPECT_EQ(hellos.at(wire::FLUID).process_id(), static_cast<std::uint32_t>(::getpid()));
    coupler.welcome(2);
    for (std::uint64_t step = 1; step <= 50; ++step) window(coupler, step);
    finish(coupler);
  });
  EXPECT_EQ(own.sentence, "");
  EXPECT_EQ(fluid.get().sentence, "");
  EXPECT_EQ(structure.get().sentence, "");
}

TEST(Channel, FiftyWindowsPassOverASocketFileThatIsPrivateAndRemovedAtTheEnd) {
  TemporaryEndpoint endpoint;
  {
    CouplerChannel coupler(endpoint.address());
    EXPECT_EQ(std::filesystem::status(endpoint.file()).permissions(),
              std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  }
  EXPECT_FALSE(std::filesystem::exists(endpoint.file()));
  whole_run(endpoint.address());
  EXPECT_TRUE(std::filesystem::is_empty(endpoint.directory()));
}

TEST(Channel, FiftyWindowsPassOverAFreeLoopbackPort) { whole_run("tcp://127.0.0.1:*"); }

// A signal must neither lose a message nor make a peer seem lost. Seen to fail: without through_signals() in socket.cpp.
TEST(Channel, FiftyWindowsPassWhileSignalsRainDown) {
  struct sigaction action = {}, before = {};
  action.sa_handler = [](int) {};
  sigaction(SIGALRM, &action, &before);
  const itimerval often = {{0, 20}, {0, 20}}, never = {};
  setitimer(ITIMER_REAL, &often, nullptr);
  TemporaryEndpoint endpoint;
  for (int k = 0; k < 5; ++k) whole_run(endpoint.address());
  setitimer(ITIMER_REAL, &never, nullptr);
  sigaction(SIGALRM, &before, nullptr);
}

TEST(Channel, AFailingParticipantIsTheCauseEverywhere) {
  TemporaryEndpoint endpoint;
  CouplerChannel coupler(endpoint.address(), 10, 10);
  auto structure = in_thread([&] {
    ParticipantChannel channel(endpoint.address(), wire::STRUCTURE, 10, 10);
    join(channel, wire::STRUCTURE);
    channel.receive({Kind::kBeginWindow});
    channel.abort(NumericalFailure("J = -0.3 at particle 12."));
  });
  auto fluid = in_thread([&] {
    ParticipantChannel channel(endpoint.address(), wire::FLUID, 10, 10);
    join(channel, wire::FLUID);
    channel.receive({Kind::kBeginWindow});
    channel.receive({Kind::kSurface});
  });
  const Outcome own = outcome_of([&] {
    try {
      coupler.accept(both, "ab12", 2);
      coupler.welcome(2);
      window(coupler, 1);
    } catch (const Error& error) {
      coupler.abort(error);
      throw;
    }
  });
  EXPECT_EQ(structure.get().code, 0);
  EXPECT_EQ(own.code, 3);
  EXPECT_EQ(own.sentence, "The structure process stopped at step 1, t = 0.001 s: J = -0.3 at particle 12.");
  const Outcome other = fluid.get();
  EXPECT_EQ(other.code, 3);
  EXPECT_TRUE(other.says("The coupler process stopped at step 1") && other.says("J = -0.3 at particle 12.")) << other.sentence;
}

TEST(Channel, NothingThatIsNotFiniteIsSent) {
  TemporaryEndpoint endpoint;
  CouplerChannel coupler(endpoint.address(), 10, 10);
  auto fluid = in_thread([&] {
    ParticipantChannel channel(endpoint.address(), wire::FLUID, 10, 10);
    join(channel, wire::FLUID);
    wire::Message particles = samples::make(Kind::kInterfaceParticles);
    particles.mutable_interface_particles()->set_velocity(3, std::numeric_limits<double>::quiet_NaN());
    channel.set_step(4, 0.004);
    channel.send(particles);
  });
  coupler.accept({wire::FLUID}, "ab12", 2);
  coupler.welcome(2);
  const Outcome outcome = fluid.get();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_TRUE(
      outcome.says("The fluid process computed an InterfaceParticles that cannot be sent at step 4, t = 0.004 s: velocity[3] is nan"))
      << outcome.sentence;
}

/// A foreign participant: a bare socket that joins properly, then sends what it is told to.
Outcome coupler_receiving(const std::vector<std::string>& frames) {
  TemporaryEndpoint endpoint;
  CouplerChannel coupler(endpoint.address(), 10, 10);
  void* context = zmq_ctx_new();
  void* socket = zmq_socket(context, ZMQ_DEALER);
  const int linger = 0;
  zmq_setsockopt(socket, ZMQ_LINGER, &linger, sizeof(linger));
  zmq_connect(socket, endpoint.address().c_str());
  wire::Message hello = samples::make(Kind::kHello, wire::FLUID);
  hello.set_protocol_version(protocol_version);
  hello.set_sequence(1);
  const std::string bytes = hello.SerializeAsString();
  zmq_send(socket, bytes.data(), bytes.size(), 0);
  const Outcome outcome = outcome_of([&] {
    coupler.accept({wire::FLUID}, "ab12", 2);
    coupler.welcome(2);
    coupler.set_step(1, 0);
    for (std::size_t i = 0; i < frames.size(); ++i)
      zmq_send(socket, frames[i].data(), frames[i].size(), i + 1 < frames.size() ? ZMQ_SNDMORE : 0);
    coupler.receive(wire::FLUID, {Kind::kInterfaceParticles});
  });
  zmq_close(socket);
  zmq_ctx_term(context);
  return outcome;
}

std::string particles_bytes(const std::function<void(wire::Message&)>& spoil = {}) {
  wire::Message particles = samples::make(Kind::kInterfaceParticles, wire::FLUID);
  particles.set_protocol_version(protocol_version);
  particles.set_sequence(2);
  particles.set_step(1);
  if (spoil) spoil(particles);
  return particles.SerializeAsString();
}

TEST(Channel, ABadMessageEndsTheRunWithItsReason) {
  EXPECT_EQ(coupler_receiving({particles_bytes()}).sentence, "");
  const std::vector<std::pair<std::vector<std::string>, const char*>> bad{
      {{"garbage \x01\x02\xff"}, "sent a message that cannot be used at step 1, t = 0 s: 11 bytes that are not a message"},
      {{""}, "protocol_version is 0"},
      {{particles_bytes().substr(0, 40)}, "40 bytes that are not a message"},
      {{particles_bytes(), "more"}, "2 frames; a message is one frame"},
      {{particles_bytes([](auto& m) { m.set_sequence(9); })}, "sequence is 9; it must be 2"},
      {{particles_bytes([](auto& m) { m.set_step(3); })}, "step is 3; it must be 1"},
      {{particles_bytes([](auto& m) { m.set_sender(wire::STRUCTURE); })}, "sender is structure; it must be fluid"},
      {{particles_bytes([](auto& m) { m.set_protocol_version(8); })}, "protocol_version is 8"},
      {{particles_bytes([](auto& m) { m.mutable_interface_force(); })}, "body is InterfaceForce; it must be InterfaceParticles now"},
      {{particles_bytes([](auto& m) { m.mutable_interface_particles()->set_mass(0, -1); })},
       "mass[0] is -1; it must be finite and above 0"},
  };
  for (const auto& [frames, reason] : bad) {
    const Outcome outcome = coupler_receiving(frames);
    EXPECT_EQ(outcome.code, 4) << reason;
    EXPECT_TRUE(outcome.says(reason)) << "\"" << outcome.sentence << "\" should say \"" << reason << "\"";
    EXPECT_TRUE(outcome.says("The fluid process")) << outcome.sentence;
  }
}

TEST(Channel, AParticipantThatFloodsTheCouplerIsStopped) {
  TemporaryEndpoint endpoint;
  CouplerChannel coupler(endpoint.address(), 10, 10);
  auto fluid = in_thread([&] {
    ParticipantChannel channel(endpoint.address(), wire::FLUID, 10, 10);
    join(channel, wire::FLUID);
    for (int i = 0; i < 40; ++i) channel.send(samples::make(Kind::kInterfaceParticles));
    channel.receive({Kind::kFinish});
  });
  auto structure = in_thread([&] {
    ParticipantChannel channel(endpoint.address(), wire::STRUCTURE, 10, 10);
    join(channel, wire::STRUCTURE);
    channel.receive({Kind::kFinish});
  });
  coupler.accept(both, "ab12", 2);
  coupler.welcome(2);
  const Outcome own = outcome_of([&] { coupler.receive(wire::STRUCTURE, {Kind::kSurface}); });
  EXPECT_EQ(own.code, 4);
  EXPECT_TRUE(own.says("16 messages wait already")) << own.sentence;
  coupler.abort(PeerLost(own.sentence));
  EXPECT_EQ(fluid.get().code, 4);
  EXPECT_EQ(structure.get().code, 4);
}

TEST(Channel, AnEndpointThatCannotBeUsedIsRefusedWithItsReason) {
  TemporaryEndpoint endpoint;
  const auto bound = [](const std::string& address) { return outcome_of([&] { CouplerChannel coupler(address); }); };
  for (const char* address : {"tcp://0.0.0.0:5555", "tcp://*:5555", "tcp://192.168.1.1:5555", "tcp://[::]:5555"})
    EXPECT_TRUE(bound(address).says("can be reached from the network")) << address;
  EXPECT_EQ(bound("tcp://no such host:5555").code, 2);
  EXPECT_TRUE(bound("tcp://no such host:5555").says("cannot be found"));
  EXPECT_EQ(bound("tcp://0.0.0.0:5555").code, 2);
  EXPECT_TRUE(bound("tcp://127.0.0.1").says("lacks a host or a port"));
  EXPECT_TRUE(bound("tcp://127.0.0.1:70000").says("lacks a host or a port"));
  EXPECT_TRUE(bound("udp://127.0.0.1:5555").says("unknown kind"));
  EXPECT_TRUE(bound("ipc://" + std::string(120, 'x')).says("the system's limit is"));
  EXPECT_TRUE(bound("ipc://" + endpoint.directory() + "/absent/tern.sock").says("is not a directory"));
  std::ofstream(endpoint.file()) << "somebody's results";
  EXPECT_TRUE(bound(endpoint.address()).says("not a socket"));
  EXPECT_TRUE(std::filesystem::is_regular_file(endpoint.file()));
  std::filesystem::remove(endpoint.file());
  CouplerChannel first(endpoint.address());
  EXPECT_TRUE(bound(endpoint.address()).says("in use by a running coupler"));
  EXPECT_TRUE(std::filesystem::is_socket(endpoint.file()));
}

// Seen to fail: with that Abort taken for the end of the run ("The fluid process stopped ...: The run was interrupted").
TEST(Channel, WhoHasAnsweredFinishMayStopBeforeTheOtherHas) {
  TemporaryEndpoint endpoint;
  CouplerChannel coupler(endpoint.address(), 10, 10);
  std::promise<void> stopped;
  auto fluid = in_thread([&] {
    ParticipantChannel channel(endpoint.address(), wire::FLUID, 10, 10);
    join(channel, wire::FLUID);
    channel.receive({Kind::kFinish});
    channel.send(samples::make(Kind::kFinished));
    channel.abort(Interrupted("The run was interrupted; results up to here are kept."));
    stopped.set_value();
  });
  auto structure = in_thread([&] {
    ParticipantChannel channel(endpoint.address(), wire::STRUCTURE, 10, 10);
    join(channel, wire::STRUCTURE);
    channel.receive({Kind::kFinish});
    stopped.get_future().wait();
    wire::Message finished;
    samples::account(finished.mutable_finished()->mutable_account(), 3, 2);
    channel.send(finished);
  });
  const Outcome own = outcome_of([&] {
    coupler.accept(both, "ab12", 2);
    coupler.welcome(2);
    for (const wire::Role role : both) {
      wire::Message order = samples::make(Kind::kFinish);
      order.mutable_finish()->set_interrupted(true);
      coupler.send(role, std::move(order));
    }
    for (const wire::Role role : {wire::STRUCTURE, wire::FLUID}) coupler.receive(role, {Kind::kFinished});
  });
  EXPECT_EQ(own.sentence, "");
  EXPECT_EQ(fluid.get().sentence, "");
  EXPECT_EQ(structure.get().sentence, "");
}

}  // namespace
}  // namespace tern::proto
