// tern-fluid: the fluid of a scene, alone or as one of three processes.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/error.hpp"
#include "base/timing.hpp"
#include "fluid/process/participant.hpp"
#include "fluid/process/ranks.hpp"
#include "run/command_line.hpp"
#include "run/solo_run.hpp"

namespace {

using namespace tern;

/// The fluid as run_alone() steps it.
template <int D>
struct Alone {
  SoloStep advance(Ticks now, Ticks target) {
    const StepProposal proposal = leader.fluid().propose_step();
    const Ticks duration = control.next(proposal.seconds, now, target);
    report.set_count("window_halvings", control.halvings());
    report.set_measure("window_s", seconds(duration));
    ScopedTimer timer(compute_s);
    leader.begin_window(now, duration);
    leader.pass_window();
    return {duration, control.halvings() > 0 ? "repeated" : proposal.limit, leader.fluid().last_solve().iterations};
  }
  Ticks last_window() const { return control.last_window(); }
  void save(StateWriter& file) {
    leader.save(file);
    file("control", control);
  }
  void restore(StateReader& file) {
    leader.restore(file);
    file("control", control);
    shorten();
  }

  Alone(const CommandLine& command, const Case& scene, const Ranks& ranks, RunReport& report_of_run)
      : leader(scene, ranks), report(report_of_run), repeat(command.repeat) {
    shorten();
  }
  void shorten() {
    if (repeat.halvings > 0) control.shorten(repeat.halvings, to_ticks(repeat.until_s), repeat.longest_s);
  }

  fluid::Leader<D> leader;
  RunReport& report;
  CommandLine::Repeat repeat;
  double& compute_s = report.timing("compute");
  StepControl control{};
};

/// Of this process that threads of its own are worth: of many ranks each has one thread unless it is told otherwise.
template <int D>
std::ptrdiff_t own_particles(const fluid::Leader<D>& leader, const Ranks& ranks) {
  return ranks.count() == 1 ? static_cast<std::ptrdiff_t>(leader.fluid().particles()) : 0;
}

template <int D>
void run_without_structure(const CommandLine& command, const Case& scene, const Ranks& ranks, RunReport& report) {
  Alone<D> alone(command, scene, ranks, report);
  set_threads(command, own_particles(alone.leader, ranks), report);
  run_alone(command, scene, report, fluid::FluidSide<D>(scene, alone.leader), gauge_columns(scene, GaugeOwner::fluid),
            fluid_energy_columns(), alone);
}

template <int D>
void run(const CommandLine& command, const Case& scene, const Ranks& ranks, RunReport& report) {
  if (command.alone()) return run_without_structure<D>(command, scene, ranks, report);
  proto::take_part(command, wire::FLUID, [&](proto::ParticipantChannel& channel) {
    fluid::Leader<D> leader(scene, ranks);
    set_threads(command, own_particles(leader, ranks), report);
    fluid::Participant<D> participant(command, scene, report, channel, leader);
    proto::take_part_as_fluid<D>(channel, participant);
  });
}

int lead(int argc, char** argv, const Ranks& ranks) {
  return run_main(argc, argv, "fluid", [&](const CommandLine& command, const Case& scene, RunReport& report) {
    if (!scene.fluid) throw BadInput(scene.path + " has no [fluid] table, so there is nothing for tern-fluid to do.");
    if (command.alone() && scene.structure)
      throw BadInput(scene.path + " has a [structure] table: start tern-fluid with --endpoint, or use ./tern run.");
    scene.dimension == 2 ? run<2>(command, scene, ranks, report) : run<3>(command, scene, ranks, report);
  });
}

}  // namespace

int main(int argc, char** argv) {
  if (!ranks_were_started()) {
    // As many processes that know nothing of each other would all write into one directory.
    if (const char* count = std::getenv("OMPI_COMM_WORLD_SIZE"); count != nullptr && std::string(count) != "1") {
      std::fputs("tern-fluid: this build has no ranks (cmake --preset ranks has); start it without mpirun.\n", stderr);
      return static_cast<int>(ExitCode::bad_input);
    }
    return lead(argc, argv, {});
  }
  const RanksAtWork at_work;
  const Ranks ranks = Ranks::all();
  fluid::announce(ranks);
  if (!ranks.first()) return fluid::follow(argc, argv, ranks);
  const int code = lead(argc, argv, ranks);
  fluid::dismiss(ranks);
  return code;
}
