// tern-fluid: the fluid of a scene, alone or as one of three processes.

#include "base/error.hpp"
#include "base/timing.hpp"
#include "fluid/process/participant.hpp"
#include "run/solo_run.hpp"

namespace {

using namespace tern;

/// The fluid as run_alone() steps it.
template <int D>
struct Alone {
  SoloStep advance(Ticks now, Ticks target) {
    const StepProposal proposal = fluid.propose_step();
    const Ticks duration = control.next(proposal.seconds, now, target);
    report.set_count("window_halvings", control.halvings());
    report.set_measure("window_s", seconds(duration));
    ScopedTimer timer(compute_s);
    fluid.begin_window(now, duration);
    fluid.pass_window();
    return {duration, control.halvings() > 0 ? "repeated" : proposal.limit, fluid.last_solve().iterations};
  }
  void save(StateWriter& file) const {
    file("fluid", fluid.state());
    file("control", control);
  }
  void restore(StateReader& file) {
    fluid::State<D> state;
    file("fluid", state);
    fluid.set_state(std::move(state));
    file("control", control);
    shorten();
  }

  Alone(const CommandLine& command, const Case& scene, RunReport& report_of_run)
      : fluid(scene), report(report_of_run), repeat(command.repeat) {
    shorten();
  }
  void shorten() {
    if (repeat.halvings > 0) control.shorten(repeat.halvings, to_ticks(repeat.until_s), repeat.longest_s);
  }

  fluid::Fluid<D> fluid;
  RunReport& report;
  CommandLine::Repeat repeat;
  double& compute_s = report.timing("compute");
  StepControl control{};
};

template <int D>
void run_without_structure(const CommandLine& command, const Case& scene, RunReport& report) {
  Alone<D> alone(command, scene, report);
  run_alone(command, scene, report, fluid::FluidSide<D>(scene, alone.fluid), gauge_columns(scene, GaugeOwner::fluid),
            fluid_energy_columns(), alone);
}

template <int D>
void run(const CommandLine& command, const Case& scene, RunReport& report) {
  if (command.alone()) return run_without_structure<D>(command, scene, report);
  proto::take_part(command, wire::FLUID, [&](proto::ParticipantChannel& channel) {
    fluid::Fluid<D> fluid(scene);
    fluid::Participant<D> participant(command, scene, report, channel, fluid);
    proto::take_part_as_fluid<D>(channel, participant);
  });
}

}  // namespace

int main(int argc, char** argv) {
  return run_main(argc, argv, "fluid", [](const CommandLine& command, const Case& scene, RunReport& report) {
    if (!scene.fluid) throw BadInput(scene.path + " has no [fluid] table, so there is nothing for tern-fluid to do.");
    if (command.alone() && scene.structure)
      throw BadInput(scene.path + " has a [structure] table: start tern-fluid with --endpoint, or use ./tern run.");
    scene.dimension == 2 ? run<2>(command, scene, report) : run<3>(command, scene, report);
  });
}
