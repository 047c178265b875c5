#include "coupler/process/run.hpp"

#include <limits>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/interrupt.hpp"
#include "base/log.hpp"
#include "base/timing.hpp"
#include "base/version.hpp"
#include "coupler/process/accounts.hpp"
#include "coupler/process/remote_participants.hpp"
#include "proto/participant/participant.hpp"
#include "proto/wire/convert.hpp"
#include "proto/wire/names.hpp"
#include "run/checkpoint.hpp"
#include "run/progress.hpp"

namespace tern::coupler {
namespace {

/// Reports the added-mass ratio. Throws BadInput where explicit coupling cannot work, unless that was asked for.
template <int D>
void refuse_predicted_instability(const CommandLine& command, const Case& scene, const SurfaceProperties& properties, RunReport& report) {
  const AddedMass added = predict_added_mass<D>(scene, properties);
  report.set_measure("added_mass_ratio_predicted", added.ratio);
  log_info("Predicted added-mass ratio: " + describe(added) + ".");
  if (scene.coupling.algorithm != CouplingAlgorithm::explicit_staggering || added.ratio <= explicit_limit || command.allow_unstable) return;
  throw BadInput(
      fmt::format("The explicit coupling is predicted to be unstable, whatever the step: {}, above {}. Use "
                  "coupling.algorithm = \"auto\", or --allow-unstable to see it.",
                  describe(added), explicit_limit));
}

void check_bodies(const Case& scene, const SurfaceProperties& properties) {
  const std::size_t bodies = scene.structure->bodies.size();
  for (std::size_t k = 0; k < properties.body.size(); ++k)
    if (properties.body[k] >= bodies)
      throw BadInput(fmt::format("surface.body[{}] of the structure is {}; the case has {} elastic bodies, counted from 0.", k,
                                 properties.body[k], bodies));
}

template <int D>
Coupler<D> make_coupler(const Case& scene, const SurfaceProperties& properties) {
  Coupler<D> coupler(scene, properties);
  if (scene.coupling.repeats_as_needed())
    log_info(coupler.setup().learns ? "Coupling: one pass a window, and iterations where the sides do not agree after it."
                                    : "Coupling: iterations in every window, because a body has next to no mass.");
  return coupler;
}

/// `iterates`: whether windows are repeated.
void report_totals(const Totals& totals, bool iterates, RunReport& report) {
  report.set_measure("momentum_audit_max", totals.largest_force_error);
  // Of the impulses exchanged, the part that the two sides did not receive alike.
  report.set_measure("momentum_audit_mean", totals.impulse_size > 0 ? totals.impulse_sum / totals.impulse_size : 0);
  report.set_measure("moment_audit_max", totals.largest_moment_error);
  report.set_count("contacts", totals.contacts);
  report.set_count("wet_windows", totals.wet_windows);
  if (!iterates) return;
  report.set_measure("coupling_iterations_mean",
                     totals.windows ? static_cast<double>(totals.iterations) / static_cast<double>(totals.windows) : 0);
  report.set_count("coupling_iterations_max", totals.most_iterations);
  report.set_count("coupling_windows_open", totals.open_windows);
}

/// How the bodies have answered, where that is learnt.
template <int D>
void report_answers(const Coupler<D>& coupler, RunReport& report) {
  if (!coupler.setup().learns) return;
  for (std::size_t b = 0; b < coupler.setup().body_name.size(); ++b) {
    const auto learnt = coupler.state().response.of_body(coupler.setup(), b);
    if (!learnt) continue;
    const std::string& body = coupler.setup().body_name[b];
    report.set_measure("answer_lump_width_m." + body, learnt->width);
    report.set_measure("answer_mass_over_formula." + body, learnt->mass_over_formula);
    report.set_measure("answer_missed." + body, learnt->missed);
    report.set_measure("answer_missed_by_points." + body, learnt->missed_by_points);
  }
}

void report_evaluations(const Evaluations& evaluations, long gauges, RunReport& report) {
  report.set_evaluations("pressure", evaluations.pressure);
  report.set_evaluations("riemann_dissipation", evaluations.riemann_dissipation);
  report.set_evaluations("vem", evaluations.vem);
  report.set_evaluations("gauges", gauges);
  report.set_evaluations("coupling_iterations", evaluations.coupling_iterations);
  report.set_count("windows_without_exchange", evaluations.windows_without_exchange);
}

/// For so long after a failure the coupler waits for the last checkpoints; the launcher ends what is left after 5 s [s].
constexpr double longest_last_save_s = 4;

using Hellos = std::map<wire::Role, wire::Hello>;

/// Whether all participants keep checkpoints; the log is told of one that does not.
bool everybody_saves(const Hellos& hellos) {
  bool all = true;
  for (const auto& [role, hello] : hellos) {
    if (!hello.saves()) log_info(fmt::format("The {} does not answer Save: this run has no checkpoints.", proto::name(role)));
    all = all && hello.saves();
  }
  return all;
}

Manifest choose_checkpoint(const CheckpointStore& checkpoints, const Hellos& hellos) {
  std::map<std::string, std::vector<CheckpointFile>> offers{{"coupler", checkpoints.files()}};
  for (const auto& [role, hello] : hellos) {
    if (!hello.saves())
      throw BadInput(fmt::format("The run cannot be continued: the {} keeps no checkpoints (docs/PARTICIPANTS.md).", proto::name(role)));
    for (const wire::Checkpoint& file : hello.checkpoint()) offers[proto::name(role)].push_back({file.step(), file.hash()});
  }
  return checkpoints.choose(offers);
}

/// An account of the fluid of before gauges were added: these have no value in it. `before`: the gauges there were, by name.
wire::Account with_added_gauges(const wire::Account& old, const Case& scene, const std::map<std::string, std::string>& before) {
  wire::Account account = old;
  account.clear_gauge();
  account.clear_undefined();
  int next = 0;
  for (const GaugeCase& gauge : scene.gauges) {
    if (owner(gauge) != GaugeOwner::fluid) continue;
    const bool known = before.contains(gauge.name);
    for (std::size_t c = 0; c < gauge_columns(gauge, scene.dimension).size(); ++c, next += known) {
      account.add_gauge(known ? old.gauge(next) : 0);
      account.add_undefined(known ? old.undefined(next) : true);
    }
  }
  return account;
}

}  // namespace

template <int D>
void run(const CommandLine& command, const Case& scene, proto::CouplerChannel& channel, RunReport& report) {
  if (command.record) channel.record(command.out + "/interface.record", !command.resume);
  const auto hello = channel.accept({wire::FLUID, wire::STRUCTURE}, scene.hash, D);
  const SurfaceProperties properties = proto::from_wire(hello.at(wire::STRUCTURE).surface());
  check_accounts(scene, hello.at(wire::FLUID).account(), hello.at(wire::STRUCTURE).account());
  check_bodies(scene, properties);
  set_threads(command, static_cast<std::ptrdiff_t>(properties.body.size()), report);
  refuse_predicted_instability<D>(command, scene, properties, report);
  Coupler<D> coupler = make_coupler<D>(scene, properties);
  const CheckpointStore checkpoints(command.out, "coupler", scene);
  CheckpointClock clock(everybody_saves(hello) ? scene.output.checkpoint_interval : 0);
  std::optional<Manifest> manifest;
  if (command.resume) manifest = choose_checkpoint(checkpoints, hello);
  Accounts<D> accounts(command.out, scene, !manifest);
  Progress progress(scene.end_time, command.quiet);

  const Totals& totals = coupler.state().totals;
  StepControl control;
  const Ticks end = to_ticks(scene.end_time);
  const FrameSchedule schedule(scene.output.frame_interval, end);
  double& compute_s = report.timing("compute");
  double& output_s = report.timing("output");
  Ticks now = 0;
  wire::Account fluid_account = hello.at(wire::FLUID).account();
  const double first_of_fluid = hello.at(wire::FLUID).proposed_step_s();
  double proposed = first_of_fluid > 0 ? first_of_fluid : std::numeric_limits<double>::infinity();  // it does not limit the window
  const double longest_of_structure = hello.at(wire::STRUCTURE).proposed_step_s();
  std::string limit = hello.at(wire::FLUID).limit();
  wire::WindowDone done;

  // The structure reports its state at the begin of a window, the fluid at the end of the one before: the same instant.
  const auto record = [&](const wire::Account& structure_account) {
    ScopedTimer timer(output_s);
    accounts.record(now, fluid_account, structure_account, coupler);
    return accounts.energies(now, fluid_account, structure_account, coupler.setup().fluid_weight.pressure > 0);
  };
  const bool own_structure = hello.at(wire::STRUCTURE).version() == fmt::format("{} {}", program_version, git_hash);
  RemoteParticipants<D> participants(channel, SurfaceCheck<D>(scene, properties, !manifest, own_structure), own_structure, record);
  KeptStates kept;
  const auto step_now = [&] { return static_cast<std::uint64_t>(totals.windows); };
  const auto gather = [&](StateWriter& state) {
    state("coupler", coupler.state());
    state("control", control);
    state("now", now);
    state("window_done", done.SerializeAsString());
    state("gauges", scene.gauge_hashes);
    accounts.save(state);
    state("traffic/sent", channel.bytes_sent());
    state("traffic/received", channel.bytes_received());
    state("record", channel.record_mark());
    state("report", report.gathered());
  };
  /// Completes a set of which the participants have written theirs.
  const auto complete_set = [&](std::uint64_t step, double time_s, const std::string& own_hash,
                                const std::map<wire::Role, std::string>& hashes) {
    Manifest set{step, time_s, {{"coupler", own_hash}}};
    for (const auto& [role, hash] : hashes) set.hash[proto::name(role)] = hash;
    accounts.recorder().sync();
    checkpoints.write_manifest(std::move(set));
    clock.saved();
  };
  const auto save = [&] {
    ScopedTimer timer(output_s);
    const StateWriter state = kept.with_state(gather);
    const auto hashes = channel.save();
    complete_set(step_now(), seconds(now), checkpoints.save(step_now(), state), hashes);
  };
  /// After a failure: the state before it, if fluid and structure still have theirs.
  const auto save_before_failure = [&](const Error& error) {
    const Kept* own = kept.of(channel.kept_step(kept.before(error).step));
    if (!own) return;
    const auto hashes = channel.abort_keeping(error, own->step, longest_last_save_s);
    if (!hashes.empty()) complete_set(own->step, own->time_s, checkpoints.save_kept(*own), hashes);
  };
  const auto restore = [&] {
    checkpoints.load(manifest->step, [&](StateReader& file) {
      State<D> state = coupler.state();
      file("coupler", state);
      coupler.set_state(state);
      file("control", control);
      file("now", now);
      std::string window_done;
      file("window_done", window_done);
      if (!done.ParseFromString(window_done)) throw BadInput("The checkpoint of the coupler has no answer of the fluid.");
      accounts.restore(file);
      std::uint64_t sent = 0, received = 0, record_bytes = 0;
      file("traffic/sent", sent);
      file("traffic/received", received);
      file("record", record_bytes);
      RunReport::Gathered gathered;
      file("report", gathered);
      report.go_on_from(gathered);
      wire::Welcome welcome;
      welcome.set_resume_step(manifest->step);
      welcome.set_resume_ticks(now);
      welcome.set_extent(done.has_extent());
      channel.welcome(static_cast<std::uint32_t>(properties.body.size()), std::move(welcome));
      channel.resume(manifest->step, seconds(now), sent, received, record_bytes);
      std::map<std::string, std::string> gauges;
      file("gauges", gauges);
      *done.mutable_account() = with_added_gauges(done.account(), scene, gauges);
      if (clock.on()) kept.go_on_from(file, manifest->step, manifest->time_s);
    });
    participants.set_window_done(done);
    fluid_account = done.account();
    proposed = done.proposed_step_s();
    limit = done.limit();
    report.set_resumed(manifest->step, manifest->time_s);
    log_info(fmt::format("goes on from the checkpoint of step {}, t = {:.9g} s", manifest->step, manifest->time_s));
  };
  const auto report_now = [&] {
    report.set_time(seconds(now), totals.windows);
    report_totals(totals, coupler.setup().iterates, report);
    report_answers(coupler, report);
    report_evaluations(coupler.state().evaluations, accounts.evaluated_gauges(), report);
    proto::report_traffic(channel, report);
    report.update();
  };

  if (manifest) {
    restore();
  } else {
    checkpoints.clear();
    channel.welcome(static_cast<std::uint32_t>(properties.body.size()));
  }
  if (const auto& [halvings, until_s, longest_s] = command.repeat; halvings > 0) control.shorten(halvings, to_ticks(until_s), longest_s);
  const auto advance = [&] {
    const Stopwatch watch;
    const Ticks target = schedule.next(now, control.last_window());
    const WindowProposal proposal = coupler.propose(proposed, limit);
    proposed = proposal.seconds;
    limit = proposal.limit;
    if (longest_of_structure > 0 && longest_of_structure < proposed) {
      proposed = longest_of_structure;
      limit = "structure";
    }
    const Ticks duration = control.next(proposed, now, target);
    if (control.crawls())
      throw NumericalFailure(fmt::format(
          "A window of {:.3g} s is asked for at t = {:.9g} s (limit \"{}\"), and less than ten ticks of time, {:.2g} s, have been "
          "a hundred times in a row: the run would never end. Who asks for that has become unstable, or gives its "
          "proposed_step_s in another unit than seconds.",
          proposed, seconds(now), limit, seconds(10)));
    if (control.halvings() > 0) limit = "repeated";
    report.set_measure("window_s", seconds(duration));
    report.set_count("window_halvings", control.halvings());
    channel.set_step(static_cast<std::uint64_t>(totals.windows + 1), seconds(now));
    participants.write_frame_at_end(now + duration == target);
    const double waited = channel.wait_seconds() + channel.exchange_seconds();
    coupler.run_window(participants, now, duration);
    done = participants.receive_window_done();
    compute_s += watch.seconds() - (channel.wait_seconds() + channel.exchange_seconds() - waited);
    now += duration;
    accounts.recorder().step(now, duration, limit, static_cast<int>(done.iterations()), watch.seconds());
    progress.step(seconds(now), totals.windows, seconds(duration), limit, static_cast<int>(done.iterations()));
    fluid_account = done.account();
    proposed = done.proposed_step_s();
    limit = done.limit();
    report_now();
    if (clock.on() && KeptStates::due(step_now())) {
      ScopedTimer timer(output_s);
      kept.keep(step_now(), seconds(now), gather);
    }
    if (clock.due() || (clock.on() && (interrupted() || now >= end))) save();
  };
  try {
    while (now < end && !interrupted()) advance();
    if (const auto energies = record(participants.finish(interrupted()))) coupler.watch(seconds(now), *energies);
    accounts.recorder().flush();
  } catch (const Error& error) {
    if (state_was_sound(error)) keep_after_failure([&] { save_before_failure(error); });
    throw;
  }
  report_now();
  progress.finish(interrupted() ? "interrupted" : "done");
  throw_if_interrupted("between two windows");
}

template void run<2>(const CommandLine&, const Case&, proto::CouplerChannel&, RunReport&);
template void run<3>(const CommandLine&, const Case&, proto::CouplerChannel&, RunReport&);

}  // namespace tern::coupler
