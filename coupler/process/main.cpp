// tern-coupler: owns time and everything that happens between fluid and structure.

#include <algorithm>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/interrupt.hpp"
#include "base/log.hpp"
#include "base/timing.hpp"
#include "coupler/process/remote_participants.hpp"
#include "coupler/stability/added_mass.hpp"
#include "proto/wire/account.hpp"
#include "run/command_line.hpp"
#include "run/progress.hpp"
#include "run/recorder.hpp"

namespace {

using namespace tern;
using proto::Kind;

/// Sums over a run of what the windows did.
struct Totals {
  double work_on_fluid = 0, riemann = 0, mitigation = 0, contact = 0;
  double largest_force_error = 0, largest_moment_error = 0;
  double impulse_sum = 0, impulse_size = 0;
  long contacts = 0, wet_windows = 0, trials = 0, open_windows = 0;
  int most_trials = 0;

  void add(const coupler::WindowAudit& audit, const coupler::FixedPoint& fixed_point, double duration) {
    work_on_fluid += audit.work_on_fluid;
    riemann += audit.riemann_dissipation;
    mitigation += audit.mitigation_dissipation;
    contact += audit.contact_dissipation;
    contacts += audit.contacts;
    wet_windows += audit.pairs > 0;
    trials += fixed_point.trials();
    most_trials = std::max(most_trials, fixed_point.trials());
    open_windows += !fixed_point.converged();
    largest_force_error = std::max(largest_force_error, audit.force_error);
    largest_moment_error = std::max(largest_moment_error, audit.moment_error);
    impulse_sum += audit.force_sum * duration;
    impulse_size += audit.force_size * duration;
  }
  /// Of the impulses exchanged, the part that the two sides did not receive alike.
  double mean_force_error() const { return impulse_size > 0 ? impulse_sum / impulse_size : 0; }
  /// The last is the work on both sides together: what the interface made or took because the fluid has seen another motion of
  /// the surface than the one that came about.
  std::vector<double> energies(double work_on_structure) const {
    return {work_on_fluid, riemann, mitigation, contact, work_on_structure + work_on_fluid};
  }
  static std::vector<std::string> columns() {
    return {"interface_work_on_fluid_J", "riemann_dissipation_J", "vem_dissipation_J", "contact_dissipation_J", "interface_staggering_J"};
  }
};

template <class T>
std::vector<T> joined(std::vector<T> first, const std::vector<T>& second, const std::vector<T>& third) {
  first.insert(first.end(), second.begin(), second.end());
  first.insert(first.end(), third.begin(), third.end());
  return first;
}

/// Throws BadInput when a participant accounts for other things than the case asks it for.
void check_account(const char* role, const wire::Account& account, const std::vector<std::string>& energies,
                   const std::vector<std::string>& gauges) {
  const auto check = [&](const char* field, int size, const std::vector<std::string>& columns) {
    if (size == static_cast<int>(columns.size())) return;
    throw BadInput(fmt::format("The {} process reports {} values in account.{}, the case asks for {}: {}.", role, size, field,
                               columns.size(), columns.empty() ? "none" : fmt::format("{}", fmt::join(columns, ", "))));
  };
  check("energy", account.energy_size(), energies);
  check("gauge", account.gauge_size(), gauges);
}

/// Reports the added-mass ratio. Throws BadInput where explicit coupling cannot work, unless that was asked for.
template <int D>
void refuse_predicted_instability(const CommandLine& command, const Case& scene, const SurfaceProperties& properties, RunReport& report) {
  const coupler::AddedMass added = coupler::predict_added_mass<D>(scene, properties);
  report.set_measure("added_mass_ratio_predicted", added.ratio);
  log_info("Predicted added-mass ratio: " + describe(added) + ".");
  if (scene.coupling.algorithm != CouplingAlgorithm::cm0 || added.ratio <= coupler::explicit_limit || command.allow_unstable) return;
  throw BadInput(
      fmt::format("The explicit coupling CM0 is predicted to be unstable, whatever the step: {}, above {}. Use "
                  "coupling.algorithm = \"CM2\", or --allow-unstable to see it.",
                  describe(added), coupler::explicit_limit));
}

template <int D>
void run(const CommandLine& command, const Case& scene, RunReport& report) {
  proto::CouplerChannel channel({command.endpoint, command.keys, command.insecure}, 300, command.deadline_s);
  if (!command.quiet && channel.endpoint().starts_with("tcp://"))
    fmt::print(stderr, "tern-coupler: listens at {} and waits for fluid and structure\n", channel.endpoint());
  try {
    if (command.record) channel.record(command.out + "/interface.record");
    const auto hello = channel.accept({wire::FLUID, wire::STRUCTURE}, scene.hash, D);
    const wire::Hello &fluid_hello = hello.at(wire::FLUID), &structure_hello = hello.at(wire::STRUCTURE);
    const SurfaceProperties properties = proto::from_wire(structure_hello.surface());
    const std::vector<std::string> structure_columns = structure_energy_columns(scene);
    const auto work_column = std::find(structure_columns.begin(), structure_columns.end(), "interface_work_on_structure_J");
    check_account("fluid", fluid_hello.account(), fluid_energy_columns(), gauge_columns(scene, GaugeOwner::fluid));
    check_account("structure", structure_hello.account(), structure_columns, gauge_columns(scene, GaugeOwner::structure));
    refuse_predicted_instability<D>(command, scene, properties, report);
    coupler::CouplingStep<D> step(scene, properties);
    if (scene.coupling.algorithm == CouplingAlgorithm::automatic)
      log_info(step.algorithm() == CouplingAlgorithm::cm3 ? "Coupling by CM3: a body is light." : "Coupling by CM2: no body is light.");
    Recorder recorder(command.out,
                      joined(gauge_columns(scene, GaugeOwner::fluid), gauge_columns(scene, GaugeOwner::structure),
                             gauge_columns(scene, GaugeOwner::coupler)),
                      joined(fluid_energy_columns(), structure_columns, Totals::columns()), scene.output.gauge_interval);
    Progress progress(scene.end_time, command.quiet);
    channel.welcome(static_cast<std::uint32_t>(properties.body.size()));

    Totals totals;
    const bool walls_move =
        std::any_of(scene.walls.begin(), scene.walls.end(), [](const WallCase& wall) { return wall.motion.has_value(); });
    StepControl control;
    const Ticks end = to_ticks(scene.end_time);
    const FrameSchedule schedule(scene.output.frame_interval, end);
    double& compute_s = report.timing("compute");
    double& output_s = report.timing("output");

    wire::Account fluid_account = fluid_hello.account();
    double proposed = fluid_hello.proposed_step_s();
    std::string limit = fluid_hello.limit();
    long windows = 0, evaluated_gauges = 0;
    // The structure reports its state at the begin of a window, the fluid at the end of the one before: the same instant.
    const auto record = [&](Ticks now, const wire::Account& structure_account) {
      ScopedTimer timer(output_s);
      GaugeValues own;
      for (const GaugeCase& gauge : scene.gauges) {
        if (owner(gauge.kind) != GaugeOwner::coupler) continue;
        const auto body = std::find_if(scene.structure->bodies.begin(), scene.structure->bodies.end(),
                                       [&](const StructureBody& b) { return b.name == gauge.body; });
        const Vector<D> load = step.total_load(static_cast<std::uint32_t>(body - scene.structure->bodies.begin()));
        for (int c = 0; c < D; ++c) own.push_back(load[c]);
      }
      evaluated_gauges += static_cast<long>(own.size());
      const std::vector<double> structure_energies = proto::energies(structure_account);
      const std::vector<double> fluid_energies = proto::energies(fluid_account);
      const double work = structure_energies[static_cast<std::size_t>(work_column - structure_columns.begin())];
      recorder.account(now, joined(proto::gauge_values(fluid_account), proto::gauge_values(structure_account), own),
                       joined(fluid_energies, structure_energies, totals.energies(work)));
      // The columns begin with kinetic and potential, kinetic and strain energy. Walls that move give the fluid what nobody counts, and a
      // foreign participant may not keep an account.
      const double present = fluid_energies[0] + structure_energies[0] + structure_energies[1];
      const bool no_account = fluid_energies[0] == 0 || work == 0 || (step.fluid_has_weight() && fluid_energies[1] == 0);
      if (walls_move || (now > 0 && no_account)) return;
      step.check_energy(seconds(now), fluid_energies[0] + fluid_energies[1] + work, present);
    };
    Ticks now = 0;
    coupler::RemoteParticipants<D> participants(channel, [&](const wire::Account& account) { record(now, account); });
    const auto report_now = [&] {
      report.set_time(seconds(now), windows);
      report.set_measure("momentum_audit_max", totals.largest_force_error);
      report.set_measure("momentum_audit_mean", totals.mean_force_error());
      report.set_measure("moment_audit_max", totals.largest_moment_error);
      report.set_count("contacts", totals.contacts);
      report.set_count("wet_windows", totals.wet_windows);
      const coupler::Evaluations& evaluations = step.evaluations();
      report.set_evaluations("pressure", evaluations.pressure);
      report.set_evaluations("riemann_dissipation", evaluations.riemann_dissipation);
      report.set_evaluations("vem", evaluations.vem);
      report.set_evaluations("gauges", evaluated_gauges);
      report.set_evaluations("repeated_trials", evaluations.repeated_trials);
      report.set_count("windows_without_exchange", evaluations.windows_without_exchange);
      if (step.algorithm() == CouplingAlgorithm::cm3) {
        report.set_measure("coupling_trials_mean", windows ? static_cast<double>(totals.trials) / static_cast<double>(windows) : 0);
        report.set_count("coupling_trials_max", totals.most_trials);
        report.set_count("coupling_windows_open", totals.open_windows);
      }
      report.timing("wait") = channel.wait_seconds();
      report.timing("exchange") = channel.exchange_seconds();
      report.set_count("bytes_sent", static_cast<long>(channel.bytes_sent()));
      report.set_count("bytes_received", static_cast<long>(channel.bytes_received()));
      report.update();
    };

    while (now < end && !interrupted()) {
      const Stopwatch watch;
      const Ticks target = schedule.next(now);
      const Ticks duration = control.next(proposed, now, target);
      channel.set_step(static_cast<std::uint64_t>(windows + 1), seconds(now));
      participants.write_frame_at_end(now + duration == target);
      const double waited = channel.wait_seconds() + channel.exchange_seconds();
      coupler::run_window<D>(participants, participants, step, now, duration);
      const wire::WindowDone& done = participants.receive_window_done();
      compute_s += watch.seconds() - (channel.wait_seconds() + channel.exchange_seconds() - waited);
      totals.add(step.audit(), step.trials(), seconds(duration));
      now += duration;
      ++windows;
      recorder.step(now, duration, limit, static_cast<int>(done.iterations()), watch.seconds());
      progress.step(seconds(now), windows, seconds(duration), limit, static_cast<int>(done.iterations()));
      fluid_account = done.account();
      proposed = done.proposed_step_s();
      limit = done.limit();
      report_now();
    }

    for (wire::Role role : {wire::FLUID, wire::STRUCTURE}) {
      wire::Message message;
      message.mutable_finish()->set_interrupted(interrupted());
      channel.send(role, std::move(message));
    }
    channel.receive(wire::FLUID, {Kind::kFinished});
    record(now, channel.receive(wire::STRUCTURE, {Kind::kFinished}).finished().account());
    recorder.flush();
    report_now();
    progress.finish(interrupted() ? "interrupted" : "done");
    if (interrupted()) throw Interrupted("The run was interrupted; results up to here are kept.");
  } catch (const Error& error) {
    channel.abort(error);
    throw;
  }
}

}  // namespace

int main(int argc, char** argv) {
  return run_main(argc, argv, "coupler", [](const CommandLine& command, const Case& scene, RunReport& report) {
    if (!scene.fluid || !scene.structure)
      throw BadInput(scene.path + " has no [" + (scene.fluid ? "structure" : "fluid") +
                     "] table: nothing is coupled, so no coupler is needed. Use ./tern run, or start the one process by hand.");
    scene.dimension == 2 ? run<2>(command, scene, report) : run<3>(command, scene, report);
  });
}
