#pragma once
// What tern's own fluid and structure have in common as participants (participant.hpp): they derive from this and add their
// numerics.

#include <string>
#include <utility>

#include <fmt/format.h>

#include "proto/participant/participant.hpp"
#include "proto/wire/account.hpp"
#include "run/process_output.hpp"

namespace tern::proto {

/// Answers for the state, and writes what is due; `Side` as in run/process_output.hpp. Who derives from it brings
///
///   void save_solver(StateWriter&) const;      all from which the solver goes on
///   void restore_solver(StateReader&);
template <class Derived, class Side>
class ParticipantFrame {
 public:
  ParticipantFrame(const CommandLine& command, const Case& scene, RunReport& report, ParticipantChannel& channel, Side side)
      : scene_(scene),
        report_(report),
        channel_(channel),
        resumes_(command.resume),
        checkpoints_(command.out, Side::role, scene),
        output_(command, scene, report, std::move(side)) {}

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
    const auto step = static_cast<std::uint64_t>(output_.windows());
    if (scene_.output.checkpoint_interval > 0 && KeptStates::due(step))
      kept_.keep(step, seconds(output_.time()), [&](StateWriter& state) { gather(state); });
  }

  void finish() {
    output_.write_frame();
    report_now();
  }

  std::string save(std::uint64_t step) {
    ScopedTimer timer(output_s_);
    return checkpoints_.save(step, kept_.with_state([&](StateWriter& state) { gather(state); }));
  }

  void save_after_failure(const Error& error, std::uint64_t wanted) noexcept {
    if (const Kept* kept = kept_.of(wanted > 0 ? wanted : kept_.before(error).step))
      keep_after_failure([&] { channel_.set_kept(kept->step, checkpoints_.save_kept(*kept)); });
  }

  void resume(const wire::Welcome& welcome) {
    if (resumes_ != (welcome.resume_step() > 0))
      throw BadInput(fmt::format("The coupler {}, this {} {}: start all processes of the run with --resume, or all without.",
                                 resumes_ ? "begins anew" : "goes on from a checkpoint", Side::role,
                                 resumes_ ? "goes on from a checkpoint" : "begins anew"));
    if (!resumes_) return checkpoints_.clear();
    checkpoints_.load(welcome.resume_step(), [&](StateReader& file) {
      static_cast<Derived*>(this)->restore_solver(file);
      output_.restore(file);
      std::uint64_t sent = 0, received = 0;
      file("traffic/sent", sent);
      file("traffic/received", received);
      channel_.resume(welcome.resume_step(), seconds(welcome.resume_ticks()), sent, received);
      if (scene_.output.checkpoint_interval > 0) kept_.go_on_from(file, welcome.resume_step(), seconds(welcome.resume_ticks()));
    });
  }

 protected:
  /// What every participant says at first; the present state becomes the first frame, unless the run goes on from a checkpoint.
  wire::Hello hello(int dimension, std::size_t particles) {
    wire::Hello hello;
    hello.set_case_hash(scene_.hash);
    hello.set_dimension(static_cast<std::uint32_t>(dimension));
    hello.set_particles(static_cast<std::uint32_t>(particles));
    *hello.mutable_account() = account();
    hello.set_saves(true);
    if (resumes_) {
      for (const CheckpointFile& file : checkpoints_.files()) {
        hello.add_checkpoint()->set_step(file.step);
        hello.mutable_checkpoint()->rbegin()->set_hash(file.hash);
      }
    } else {
      output_.write_frame();
    }
    return hello;
  }

  /// The result of work(), its time counted as computing.
  template <class Work>
  auto timed(Work&& work) {
    ScopedTimer timer(compute_s_);
    return work();
  }

 private:
  void gather(StateWriter& state) const {
    static_cast<const Derived*>(this)->save_solver(state);
    output_.save(state);
    state("traffic/sent", channel_.bytes_sent());
    state("traffic/received", channel_.bytes_received());
  }
  void report_now() {
    output_.report();
    report_traffic(channel_, report_);
  }

  const Case& scene_;
  RunReport& report_;
  ParticipantChannel& channel_;
  bool resumes_;
  CheckpointStore checkpoints_;
  KeptStates kept_;
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
