// What one exchange between the coupler and a participant costs: conversion, checks on both ends, supervision of the peer and
// transport, against a bare ZeroMQ round trip of the same bytes over sockets of the same types; the same where both ends ask again
// and again instead of going to sleep; and a round trip over a socket of the system without ZeroMQ. Table of docs/SPEED.md:
//   build/release/bench/bench-exchange [points ...]
// Every answer comes from a process of its own through ipc. 2D, as many interface particles as surface points. Exchanges:
//   surface:   Surface there (position, velocity, normal, area), InterfaceParticles back (label, position, velocity, mass, volume,
//              divergence): the least the protocol has with two vectors each way
//   pressure:  InterfaceCondition there (a vector, two scalars: the bytes of two vectors), InterfacePressure back (a vector, a scalar)
// Blocks of both in turn and blocks of the bare round trips alternate, so that all see the same machine. Microseconds per
// exchange: the fastest block / the median of the blocks.
// A second table has what of it each passage over the numbers of one message takes, in this process alone.

#include <fmt/format.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "fixtures/scratch_directory.hpp"
#include "proto/transport/channel.hpp"
#include "proto/transport/socket.hpp"
#include "proto/wire/convert.hpp"
#include "proto/wire/message_check.hpp"

namespace {

using namespace tern;
using proto::Kind;

constexpr int blocks = 60;

/// Runs `work` in a process of its own, which must leave by itself.
class Answerer {
 public:
  explicit Answerer(const std::function<void()>& work) : process_(::fork()) {
    if (process_ < 0) throw std::runtime_error("no process can be started");
    if (process_ > 0) return;
    try {
      work();
      ::_exit(0);
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}\n", error.what());
      ::_exit(1);
    }
  }
  ~Answerer() { ::waitpid(process_, nullptr, 0); }
  Answerer(const Answerer&) = delete;
  Answerer& operator=(const Answerer&) = delete;

 private:
  pid_t process_;
};

/// What the two sides tell each other. Labels are shuffled, as particles are sorted by place and not by label.
struct Content {
  Surface<2> surface;
  InterfaceParticles<2> particles;
  InterfaceCondition<2> load;
  InterfacePressure<2> pressure;

  explicit Content(std::size_t points) {
    const std::vector<Vector<2>> vectors(points, Vector<2>(0.1, -1.3));
    const std::vector<double> scalars(points, 0.7);
    surface = {vectors, vectors, std::vector<Vector<2>>(points, Vector<2>(0.6, 0.8)), scalars};
    std::vector<std::uint32_t> labels(points);
    std::iota(labels.begin(), labels.end(), 0);
    std::shuffle(labels.begin(), labels.end(), std::mt19937(1));
    particles = {labels, vectors, vectors, scalars, scalars, scalars, {}, {}, {}};
    load.force = vectors;
    load.reference_pressure = load.response.share = load.response.mass = scalars;
    load.response.lump.assign(scalars.size(), 0);
    pressure = {scalars, vectors};
  }
};

/// The fluid's end: answers until the coupler ends the run.
void answer_coupler(const std::string& endpoint, std::size_t points) {
  const Content content(points);
  proto::ParticipantChannel channel(endpoint, wire::FLUID);
  wire::Hello hello;
  hello.set_dimension(2);
  channel.handshake(hello);
  for (;;) {
    const wire::Message order = channel.receive({Kind::kSurface, Kind::kInterfaceCondition, Kind::kFinish});
    wire::Message answer;
    if (order.has_surface()) {
      const Surface<2> surface = proto::from_wire<2>(order.surface());
      *answer.mutable_interface_particles() = proto::to_wire<2>(content.particles);
    } else if (order.has_interface_condition()) {
      const InterfaceCondition<2> load = proto::from_wire<2>(order.interface_condition());
      *answer.mutable_interface_pressure() = proto::to_wire<2>(content.pressure);
    } else {
      answer.mutable_finished();
    }
    const bool last = order.has_finish();
    channel.send(std::move(answer));
    if (last) return;
  }
}

/// The coupler's end.
class Coupler {
 public:
  Coupler(const std::string& endpoint, std::size_t points) : content_(points), channel_(endpoint) {
    channel_.accept({wire::FLUID}, "", 2);
    channel_.welcome(static_cast<std::uint32_t>(points));
  }
  ~Coupler() {
    wire::Message message;
    message.mutable_finish();
    channel_.send(wire::FLUID, std::move(message));
    channel_.receive(wire::FLUID, {Kind::kFinished});
  }
  Coupler(const Coupler&) = delete;
  Coupler& operator=(const Coupler&) = delete;

  void exchange_surface() {
    wire::Message message;
    *message.mutable_surface() = proto::to_wire<2>(content_.surface);
    channel_.send(wire::FLUID, std::move(message));
    const InterfaceParticles<2> particles =
        proto::from_wire<2>(channel_.receive(wire::FLUID, {Kind::kInterfaceParticles}).interface_particles());
  }
  void exchange_pressure() {
    wire::Message message;
    *message.mutable_interface_condition() = proto::to_wire<2>(content_.load);
    channel_.send(wire::FLUID, std::move(message));
    const InterfacePressure<2> pressure =
        proto::from_wire<2>(channel_.receive(wire::FLUID, {Kind::kInterfacePressure}).interface_pressure());
  }
  std::size_t bytes_sent() const { return channel_.bytes_sent(); }
  std::size_t bytes_received() const { return channel_.bytes_received(); }

 private:
  Content content_;
  proto::CouplerChannel channel_;
};

void require(bool done) {
  if (!done) throw std::runtime_error(fmt::format("ZeroMQ: {}", zmq_strerror(zmq_errno())));
}

/// How long an end asks for a message, giving others the core in between, before it goes to sleep. Longer than any round trip
/// here, and no longer: an end whose turn it is not must leave the machine to those that are measured.
constexpr std::chrono::milliseconds awake{2}, asleep{0};

/// A ZeroMQ socket with nothing around it, in a process that keeps its memory as the others do.
class BareSocket {
 public:
  BareSocket(int type, std::chrono::milliseconds patience)
      : patience_(patience), context_(zmq_ctx_new()), socket_(zmq_socket(context_, type)) {
    require(socket_ != nullptr);
    proto::keep_freed_memory();
  }
  ~BareSocket() {
    zmq_close(socket_);
    zmq_ctx_term(context_);
  }
  BareSocket(const BareSocket&) = delete;
  BareSocket& operator=(const BareSocket&) = delete;

  void bind(const std::string& endpoint) { require(zmq_bind(socket_, endpoint.c_str()) == 0); }
  void connect(const std::string& endpoint) { require(zmq_connect(socket_, endpoint.c_str()) == 0); }
  void send(const std::vector<std::byte>& bytes, int flags = 0) { require(zmq_send(socket_, bytes.data(), bytes.size(), flags) >= 0); }
  /// One frame into `bytes`.
  void receive(std::vector<std::byte>& bytes) {
    zmq_msg_t frame;
    zmq_msg_init(&frame);
    bool there = false;
    for (const auto until = std::chrono::steady_clock::now() + patience_; !there && std::chrono::steady_clock::now() < until;) {
      there = zmq_msg_recv(&frame, socket_, ZMQ_DONTWAIT) >= 0;
      if (!there) ::sched_yield();
    }
    if (!there) require(zmq_msg_recv(&frame, socket_, 0) >= 0);
    const auto* begin = static_cast<const std::byte*>(zmq_msg_data(&frame));
    bytes.assign(begin, begin + zmq_msg_size(&frame));
    zmq_msg_close(&frame);
  }

 private:
  std::chrono::milliseconds patience_;
  void* context_;
  void* socket_;
};

/// Answers a message whose first bytes are a number by as many bytes, until an empty one comes.
void answer_bare(const std::string& endpoint, std::chrono::milliseconds patience) {
  BareSocket socket(ZMQ_DEALER, patience);
  socket.connect(endpoint);
  std::vector<std::byte> order(1), answer;
  socket.send(order);  // the other end learns the routing id
  for (;;) {
    socket.receive(order);
    if (order.empty()) return;
    std::size_t size = 0;
    std::memcpy(&size, order.data(), sizeof(size));
    answer.resize(size);
    socket.send(answer);
  }
}

struct Sizes {
  std::size_t there, back;
};

class BareCoupler {
 public:
  BareCoupler(const std::string& endpoint, std::chrono::milliseconds patience) : socket_(ZMQ_ROUTER, patience) {
    socket_.bind(endpoint);
    socket_.receive(peer_);
    socket_.receive(answer_);
  }
  ~BareCoupler() { send({}); }
  BareCoupler(const BareCoupler&) = delete;
  BareCoupler& operator=(const BareCoupler&) = delete;

  void exchange(const Sizes& sizes) {
    order_.resize(sizes.there);
    std::memcpy(order_.data(), &sizes.back, sizeof(sizes.back));
    send(order_);
    socket_.receive(peer_);
    socket_.receive(answer_);
  }

 private:
  void send(const std::vector<std::byte>& bytes) {
    socket_.send(peer_, ZMQ_SNDMORE);
    socket_.send(bytes);
  }
  BareSocket socket_;
  std::vector<std::byte> peer_, order_, answer_;
};

/// A pair of connected sockets of the system, one end of which a process of its own answers: two wake-ups per round trip.
class SystemSockets {
 public:
  SystemSockets() : ends_(connected()), echo_([this] { answer(); }) { ::close(ends_[1]); }
  ~SystemSockets() { ::close(ends_[0]); }
  SystemSockets(const SystemSockets&) = delete;
  SystemSockets& operator=(const SystemSockets&) = delete;

  void exchange(const Sizes& sizes) {
    bytes_.resize(std::max(sizes.there, sizes.back));
    pass(ends_[0], reinterpret_cast<const std::byte*>(&sizes), sizeof(sizes));
    pass(ends_[0], bytes_.data(), sizes.there);
    if (!take(ends_[0], bytes_.data(), sizes.back)) throw std::runtime_error("the answering process has gone");
  }

 private:
  static std::array<int, 2> connected() {
    std::array<int, 2> ends;
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0) throw std::runtime_error("no sockets can be had");
    return ends;
  }
  void answer() {
    ::close(ends_[0]);
    for (Sizes sizes{}; take(ends_[1], reinterpret_cast<std::byte*>(&sizes), sizeof(sizes));) {
      bytes_.resize(std::max(sizes.there, sizes.back));
      take(ends_[1], bytes_.data(), sizes.there);
      pass(ends_[1], bytes_.data(), sizes.back);
    }
  }
  static void pass(int end, const std::byte* bytes, std::size_t size) {
    for (ssize_t sent = 0; size > 0; bytes += sent, size -= static_cast<std::size_t>(sent)) {
      sent = ::send(end, bytes, size, MSG_NOSIGNAL);
      if (sent <= 0) throw std::runtime_error("the other process has gone");
    }
  }
  static bool take(int end, std::byte* bytes, std::size_t size) {
    for (ssize_t got = 0; size > 0; bytes += got, size -= static_cast<std::size_t>(got)) {
      got = ::recv(end, bytes, size, 0);
      if (got <= 0) return false;
    }
    return true;
  }

  std::vector<std::byte> bytes_;
  std::array<int, 2> ends_;
  Answerer echo_;
};

/// Microseconds of one call, block by block.
struct Series {
  std::vector<double> microseconds;

  double least() const { return *std::min_element(microseconds.begin(), microseconds.end()); }
  double median() const {
    std::vector<double> sorted = microseconds;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

using Calls = std::vector<std::function<void()>>;

/// Adds the mean over `rounds` of each of the calls, which are made in turn as in a window.
void add_block(int rounds, const Calls& calls, std::vector<Series>& series) {
  std::vector<double> sum(calls.size());
  for (int round = 0; round < rounds; ++round)
    for (std::size_t k = 0; k < calls.size(); ++k) {
      const auto begin = std::chrono::steady_clock::now();
      calls[k]();
      sum[k] += std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
    }
  for (std::size_t k = 0; k < calls.size(); ++k) series[k].microseconds.push_back(sum[k] / rounds);
}

void measure(const ScratchDirectory& directory, std::size_t points) {
  const std::vector<std::string> names{"surface", "pressure"};
  const std::string endpoint = fmt::format("ipc://{}/{}", directory.path(), points);
  const Answerer participant([&] { answer_coupler(endpoint, points); });  // before this process has threads
  const Answerer echo([&] { answer_bare(endpoint + "-bare", asleep); });
  const Answerer awake_echo([&] { answer_bare(endpoint + "-awake", awake); });
  SystemSockets system;
  BareCoupler bare(endpoint + "-bare", asleep), bare_awake(endpoint + "-awake", awake);
  Coupler coupler(endpoint, points);
  const Calls exchanges{[&] { coupler.exchange_surface(); }, [&] { coupler.exchange_pressure(); }};

  std::vector<Sizes> sizes;
  for (const auto& exchange : exchanges) {
    const Sizes before{coupler.bytes_sent(), coupler.bytes_received()};
    exchange();
    sizes.push_back({coupler.bytes_sent() - before.there, coupler.bytes_received() - before.back});
  }
  Calls round_trips, awake_round_trips, system_round_trips;
  for (const Sizes& size : sizes) {
    round_trips.push_back([&] { bare.exchange(size); });
    awake_round_trips.push_back([&] { bare_awake.exchange(size); });
    system_round_trips.push_back([&] { system.exchange(size); });
  }

  const int rounds = static_cast<int>(std::clamp<std::size_t>(200000 / points, 20, 200));
  std::vector<Series> full(names.size()), transport(names.size()), transport_awake(names.size()), without(names.size());
  for (int block = 0; block < blocks; ++block) {
    add_block(rounds, exchanges, full);
    add_block(rounds, round_trips, transport);
    add_block(rounds, awake_round_trips, transport_awake);
    add_block(rounds, system_round_trips, without);
  }
  for (std::size_t k = 0; k < names.size(); ++k)
    fmt::print("| {} | {} | {} / {} | {:.0f} / {:.0f} | {:.0f} / {:.0f} | {:.0f} / {:.0f} | {:.0f} / {:.0f} | {:.0f} | {:.2f} |\n", points,
               names[k], sizes[k].there, sizes[k].back, full[k].least(), full[k].median(), transport[k].least(), transport[k].median(),
               transport_awake[k].least(), transport_awake[k].median(), without[k].least(), without[k].median(),
               full[k].least() - transport[k].least(), full[k].least() / transport[k].least());
  std::fflush(stdout);
}

/// What becomes of one message between the vectors of the sender and those of the receiver, passage by passage; `fill` and `read`
/// convert. The least of the blocks.
void measure_passages(std::size_t points, const char* name, const std::function<void(wire::Message&)>& fill,
                      const std::function<void(const wire::Message&)>& read) {
  wire::Message message;
  message.set_sender(wire::COUPLER);
  fill(message);
  proto::Agreement agreement;
  agreement.dimension = 2;
  agreement.surface_points = agreement.interface_particles = points;
  std::vector<std::byte> bytes(message.ByteSizeLong()), copy(bytes.size());
  const auto serialise = [&] {
    message.ByteSizeLong();
    message.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(bytes.data()));
  };
  serialise();
  const auto require_none = [](const std::string& fault) {
    if (!fault.empty()) throw std::runtime_error(fault);
  };
  const Calls passages{[&] {
                         wire::Message other;
                         fill(other);
                       },
                       [&] { require_none(proto::find_body_fault(message, agreement)); },
                       serialise,
                       [&] {
                         wire::Message other;
                         require_none(proto::parse(bytes, other));
                       },
                       [&] { read(message); },
                       [&] { std::memcpy(copy.data(), bytes.data(), bytes.size()); }};
  const int rounds = static_cast<int>(std::clamp<std::size_t>(200000 / points, 20, 200));
  std::vector<Series> series(passages.size());
  for (int block = 0; block < blocks; ++block) add_block(rounds, passages, series);
  fmt::print("| {} | {} | {} |", points, name, bytes.size());
  for (const Series& passage : series) fmt::print(" {:.1f} |", passage.least());
  fmt::print("\n");
}

}  // namespace

int main(int argc, char** argv) {
  fmt::print(
      "| points | exchange | bytes there / back | tern | bare ZeroMQ | bare ZeroMQ, awake | system's sockets | tern less bare, "
      "least | ratio |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  std::fflush(stdout);
  const ScratchDirectory directory;
  std::vector<std::size_t> sizes{100, 1000, 10000};
  if (argc > 1) sizes.clear();
  for (int k = 1; k < argc; ++k) sizes.push_back(std::stoul(argv[k]));
  for (const std::size_t points : sizes) measure(directory, points);
  fmt::print(
      "\n| points | message | bytes | vectors to message | check | to bytes | from bytes | message to vectors | for comparison: one copy "
      "|\n"
      "|---|---|---|---|---|---|---|---|---|\n");
  for (const std::size_t points : sizes) {
    const Content content(points);
    measure_passages(
        points, "Surface", [&](wire::Message& message) { *message.mutable_surface() = proto::to_wire<2>(content.surface); },
        [](const wire::Message& message) { const Surface<2> surface = proto::from_wire<2>(message.surface()); });
    measure_passages(
        points, "InterfaceParticles",
        [&](wire::Message& message) { *message.mutable_interface_particles() = proto::to_wire<2>(content.particles); },
        [](const wire::Message& message) { const InterfaceParticles<2> particles = proto::from_wire<2>(message.interface_particles()); });
  }
}
