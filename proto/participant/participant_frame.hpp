#pragma once
// What tern's own fluid and structure have in common as participants (participant.hpp): they derive from this and add their
// numerics.

#include <string>
#include <utility>

#include "proto/participant/participant.hpp"
#include "proto/wire/account.hpp"
#include "run/process_output.hpp"

namespace tern::proto {

/// Answers for the state, and writes what is due; `Side` as in run/process_output.hpp.
template <class Side>
class ParticipantFrame {
 public:
  ParticipantFrame(const CommandLine& command, const Case& scene, RunReport& report, const ParticipantChannel& channel, Side side)
      : scene_(scene), report_(report), channel_(channel), output_(command, scene, report, std::move(side)) {}

  wire::Account account() {
    ScopedTimer timer(output_s_);
    return proto::account(output_.energies(), output_.gauges());
  }

  void end_window(const Window& window) {
    ScopedTimer timer(output_s_);
    output_.count_window();
    if (window.write_frame) output_.write_frame();
    report_now();
    report_.update();
  }

  void finish() {
    output_.write_frame();
    report_now();
  }

 protected:
  /// What every participant says at first; the present state becomes the first frame.
  wire::Hello hello(int dimension, std::size_t particles) {
    wire::Hello hello;
    hello.set_case_hash(scene_.hash);
    hello.set_dimension(static_cast<std::uint32_t>(dimension));
    hello.set_particles(static_cast<std::uint32_t>(particles));
    *hello.mutable_account() = account();
    output_.write_frame();
    return hello;
  }

  /// The result of work(), its time counted as computing.
  template <class Work>
  auto timed(Work&& work) {
    ScopedTimer timer(compute_s_);
    return work();
  }

 private:
  void report_now() {
    output_.report();
    report_traffic(channel_, report_);
  }

  const Case& scene_;
  RunReport& report_;
  const ParticipantChannel& channel_;
  double& compute_s_ = report_.timing("compute");
  double& output_s_ = report_.timing("output");
  ProcessOutput<Side> output_;
};

/// part(channel), from making the solver to the end of the run, as the participant `role` of the coupler that the command line
/// names; the coupler is told when it fails.
template <class Part>
void take_part(const CommandLine& command, wire::Role role, Part&& part) {
  ParticipantChannel channel({command.endpoint, command.keys, command.insecure}, role, 300, 2 * command.deadline_s);
  telling_the_coupler(channel, [&] { part(channel); });
}

}  // namespace tern::proto
