// Peers that die, freeze, fall silent or were never there are noticed in time and named; nobody waits for ever.
// Seen to fail, one at a time, by running into the time limit of the test: monitor events ignored by the coupler, by
// the participant; silences not looked at in either channel; the deadline and the interruption not looked at in Waiting::check.

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <array>
#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <vector>

#include "base/interrupt.hpp"
#include "channel_fixture.hpp"
#include "proto/transport/channel.hpp"

namespace tern::proto {
namespace {

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Another process, made before this one has any ZeroMQ thread; killed with the object.
class Child {
 public:
  explicit Child(const std::function<void()>& work) : id_(::fork()) {
    if (id_ == 0) {
      install_interrupt_handler();
      ::_exit(outcome_of(work).code);
    }
  }
  ~Child() {
    if (reaped_) return;
    ::kill(id_, SIGKILL);
    ::waitpid(id_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  void signal(int number) const { ::kill(id_, number); }
  pid_t id() const { return id_; }
  bool ended() {
    siginfo_t state{};
    return ::waitid(P_PID, static_cast<id_t>(id_), &state, WEXITED | WNOHANG | WNOWAIT) != 0 || state.si_pid != 0;
  }
  /// Waits for its end; returns the exit code, -1 after a signal.
  int exit_code() {
    int status = 0;
    ::waitpid(id_, &status, 0);
    reaped_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t id_;
  bool reaped_ = false;
};

void join_and_wait(const std::string& address, wire::Role role) {
  ParticipantChannel channel(address, role, 30, 60);
  join(channel, role);
  channel.receive({Kind::kFinish});
}

TEST(Liveness, AKilledParticipantIsNoticedWithinASecondAndTheOtherIsTold) {
  TemporaryEndpoint endpoint;
  const Child fluid([&] { join_and_wait(endpoint.address(), wire::FLUID); });
  CouplerChannel coupler(endpoint.address(), 30, 60);
  auto structure = in_thread([&] { join_and_wait(endpoint.address(), wire::STRUCTURE); });
  coupler.accept(both, "ab12", 2);
  coupler.welcome(2);
  coupler.set_step(17, 0.0123);
  fluid.signal(SIGKILL);
  Outcome outcome;
  // Waiting for the structure: whoever dies is noticed, not only the one that is waited for.
  EXPECT_LT(seconds_of([&] { outcome = outcome_of([&] { coupler.receive(wire::STRUCTURE, {Kind::kSurface}); }); }), 1.0);
  EXPECT_EQ(outcome.code, 4);
  EXPECT_TRUE(outcome.says("The fluid process (process " + std::to_string(fluid.id()) + ") was lost at step 17, t = 0.0123 s"))
      << outcome.sentence;
  coupler.abort(PeerLost(outcome.sentence));
  const Outcome other = structure.get();
  EXPECT_EQ(other.code, 4);
  EXPECT_TRUE(other.says("The fluid process") && other.says("was lost at step 17")) << other.sentence;
}

TEST(Liveness, AKilledCouplerIsNoticedWithinASecond) {
  TemporaryEndpoint endpoint;
  const Child coupler([&] {
    CouplerChannel channel(endpoint.address(), 30, 60);
    channel.accept({wire::FLUID}, "ab12", 2);
    channel.welcome(2);
    channel.receive(wire::FLUID, {Kind::kFinished});
  });
  ParticipantChannel channel(endpoint.address(), wire::FLUID, 30, 60);
  join(channel, wire::FLUID);
  coupler.signal(SIGKILL);
  Outcome outcome;
  EXPECT_LT(seconds_of([&] { outcome = outcome_of([&] { channel.receive({Kind::kBeginWindow}); }); }), 1.0);
  EXPECT_EQ(outcome.code, 4);
  EXPECT_TRUE(outcome.says("The coupler process was lost before the first step")) << outcome.sentence;
}

TEST(Liveness, AFrozenParticipantIsNoticedWithinTenSeconds) {
  TemporaryEndpoint endpoint;
  const Child fluid([&] { join_and_wait(endpoint.address(), wire::FLUID); });
  CouplerChannel coupler(endpoint.address(), 30, 60);
  coupler.accept({wire::FLUID}, "ab12", 2);
  coupler.welcome(2);
  fluid.signal(SIGSTOP);
  Outcome outcome;
  const double noticed = seconds_of([&] { outcome = outcome_of([&] { coupler.receive(wire::FLUID, {Kind::kInterfaceParticles}); }); });
  EXPECT_LT(noticed, 10.0);
  EXPECT_GT(noticed, 1.0);  // a busy machine must not look like a frozen one
  EXPECT_EQ(outcome.code, 4);
  EXPECT_TRUE(outcome.says("was lost before the first step")) << outcome.sentence;
}

/// An address of this machine's own network at which nobody listens.
std::string free_local_address() {
  const int probe = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{.sin_family = AF_INET, .sin_port = 0, .sin_addr = {htonl(INADDR_LOOPBACK)}, .sin_zero = {}};
  socklen_t size = sizeof(address);
  ::bind(probe, reinterpret_cast<sockaddr*>(&address), size);
  ::getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(probe);
  return fmt::format("tcp://127.0.0.1:{}", ntohs(address.sin_port));
}

/// A coupler that waits for a fluid, and the fluid that waits for it 7 s, as processes of their own.
struct TwoProcesses {
  explicit TwoProcesses(std::string address)
      : endpoint(std::move(address)),
        coupler([this] {
          CouplerChannel channel(endpoint, 30, 60);
          channel.accept({wire::FLUID}, "ab12", 2);
          channel.welcome(2);
          channel.receive(wire::FLUID, {Kind::kFinished});
        }),
        fluid([this] {
          ParticipantChannel channel(endpoint, wire::FLUID, 30, 7);
          join(channel, wire::FLUID);
          channel.receive({Kind::kFinish});
        }) {}
  std::string endpoint;
  Child coupler, fluid;
};

// Seen to fail without the look at the silence in ParticipantChannel, which then waits for its deadline.
TEST(Liveness, AFrozenCouplerIsNoticedWithinTenSeconds) {
  TemporaryEndpoint endpoint;
  const std::array addresses{endpoint.address(), free_local_address()};
  std::vector<std::unique_ptr<Child>> couplers;
  for (const std::string& address : addresses)
    couplers.push_back(std::make_unique<Child>([&] {
      CouplerChannel channel(address, 30, 60);
      channel.accept({wire::FLUID}, "ab12", 2);
      channel.welcome(2);
      channel.receive(wire::FLUID, {Kind::kFinished});
    }));
  std::vector<std::future<Outcome>> fluids;
  for (const std::string& address : addresses) fluids.push_back(in_thread([&] { join_and_wait(address, wire::FLUID); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  for (const auto& coupler : couplers) coupler->signal(SIGSTOP);
  EXPECT_LT(seconds_of([&] {
              for (auto& fluid : fluids) {
                const Outcome outcome = fluid.get();
                EXPECT_EQ(outcome.code, 4);
                EXPECT_TRUE(outcome.says("The coupler process was lost before the first step")) << outcome.sentence;
              }
            }),
            10.0);
}

// Seen to fail with ZeroMQ's own limits of 5 s (ZMQ_HEARTBEAT_TIMEOUT, ZMQ_HEARTBEAT_TTL), with which they lose each other at once; and
// with all of the time that passes counted in Waiting::check, with which the fluid gives up.
TEST(Liveness, WhoFrozeTogetherGoOn) {
  TemporaryEndpoint endpoint;
  std::vector<std::unique_ptr<TwoProcesses>> pairs;
  for (const std::string& address : {endpoint.address(), free_local_address()}) pairs.push_back(std::make_unique<TwoProcesses>(address));
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));  // they have met, and asked each other for a sign of life
  for (const int number : {SIGSTOP, SIGCONT}) {
    for (const auto& pair : pairs) {
      pair->fluid.signal(number);
      pair->coupler.signal(number);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(number == SIGSTOP ? 7000 : 3000));
  }
  for (const auto& pair : pairs) {
    EXPECT_FALSE(pair->coupler.ended()) << pair->endpoint;
    EXPECT_FALSE(pair->fluid.ended()) << pair->endpoint;
    pair->fluid.signal(SIGSTOP);  // and one that freezes alone is still noticed, over a network as well
  }
  const auto noticed = seconds_of([&] {
    for (const auto& pair : pairs) EXPECT_EQ(pair->coupler.exit_code(), 4) << pair->endpoint;
  });
  EXPECT_LT(noticed, 10.0);
  EXPECT_GT(noticed, 1.0);
}

TEST(Liveness, AnInterruptedParticipantStopsWaitingAtOnceWithItsOwnExitCode) {
  TemporaryEndpoint endpoint;
  Child fluid([&] { join_and_wait(endpoint.address(), wire::FLUID); });
  CouplerChannel coupler(endpoint.address(), 30, 60);
  coupler.accept({wire::FLUID}, "ab12", 2);
  coupler.welcome(2);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  fluid.signal(SIGINT);
  int code = 0;
  EXPECT_LT(seconds_of([&] { code = fluid.exit_code(); }), 1.0);
  EXPECT_EQ(code, 130);
}

TEST(Liveness, AParticipantThatIsAliveButSilentIsGivenUpAtTheProgressDeadline) {
  TemporaryEndpoint endpoint;
  CouplerChannel coupler(endpoint.address(), 10, 0.3);
  auto fluid = in_thread([&] { join_and_wait(endpoint.address(), wire::FLUID); });
  coupler.accept({wire::FLUID}, "ab12", 2);
  coupler.welcome(2);
  coupler.set_step(3, 0.5);
  const Outcome outcome = outcome_of([&] { coupler.receive(wire::FLUID, {Kind::kInterfaceParticles}); });
  EXPECT_EQ(outcome.code, 4);
  EXPECT_TRUE(outcome.says("The coupler process waited 0.") && outcome.says("for fluid at step 3, t = 0.5 s and gave up"))
      << outcome.sentence;
  coupler.abort(PeerLost(outcome.sentence));
  EXPECT_EQ(fluid.get().code, 4);
}

TEST(Liveness, ACouplerThatIsNotThereIsGivenUpAtTheStartDeadline) {
  TemporaryEndpoint endpoint;
  ParticipantChannel channel(endpoint.address(), wire::STRUCTURE, 0.3, 60);
  const Outcome outcome = outcome_of([&] { join(channel, wire::STRUCTURE); });
  EXPECT_EQ(outcome.code, 4);
  EXPECT_TRUE(outcome.says("for a coupler at " + endpoint.address()) && outcome.says("gave up")) << outcome.sentence;
}

TEST(Liveness, AParticipantThatNeverComesIsNamedAtTheStartDeadline) {
  TemporaryEndpoint endpoint;
  CouplerChannel coupler(endpoint.address(), 1.0, 60);
  auto fluid = in_thread([&] { join_and_wait(endpoint.address(), wire::FLUID); });
  const Outcome outcome = outcome_of([&] { coupler.accept(both, "ab12", 2); });
  EXPECT_TRUE(outcome.says("for structure before the first step and gave up")) << outcome.sentence;
  coupler.abort(PeerLost(outcome.sentence));
  EXPECT_EQ(fluid.get().code, 4);
}

TEST(Liveness, AParticipantMayStartBeforeTheCoupler) {
  TemporaryEndpoint endpoint;
  auto fluid = in_thread([&] {
    ParticipantChannel channel(endpoint.address(), wire::FLUID, 30, 30);
    join(channel, wire::FLUID);
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  CouplerChannel coupler(endpoint.address(), 30, 30);
  coupler.accept({wire::FLUID}, "ab12", 2);
  coupler.welcome(2);
  EXPECT_EQ(fluid.get().sentence, "");
}

TEST(Liveness, WhatAParticipantSaidBeforeItLeftCounts) {
  // Abort and the end of the connection arrive together; the reason must win every time.
  // Seen to fail: the monitor looked at before the messages in CouplerChannel::State::collect.
  for (int round = 0; round < 20; ++round) {
    TemporaryEndpoint endpoint;
    CouplerChannel coupler(endpoint.address(), 30, 60);
    auto fluid = in_thread([&] {
      ParticipantChannel channel(endpoint.address(), wire::FLUID, 30, 30);
      join(channel, wire::FLUID);
      channel.abort(InputOutputError("No space left on device."));
    });
    coupler.accept({wire::FLUID}, "ab12", 2);
    coupler.welcome(2);
    if (round % 2 == 0) fluid.wait();  // both have arrived, or arrive during the wait
    const Outcome outcome = outcome_of([&] { coupler.receive(wire::FLUID, {Kind::kInterfaceParticles}); });
    EXPECT_EQ(outcome.code, 5) << outcome.sentence;
    fluid.get();
  }
}

}  // namespace
}  // namespace tern::proto
