// tern-structure: the elastic bodies of a scene, alone or as one of three processes.

#include <algorithm>

#include "base/error.hpp"
#include "base/timing.hpp"
#include "meeting/meeting.hpp"
#include "run/solo_run.hpp"
#include "scene/estimate.hpp"
#include "structure/process/participant.hpp"

namespace {

using namespace tern;

/// Items that several threads would share: the loops of the structure have one.
constexpr std::ptrdiff_t shared_out = 0;

/// The structure as run_alone() steps it: without surface load, in windows of equal length between two instants of output.
template <int D>
struct Alone {
  Alone(const Case& scene, RunReport& report)
      : structure(scene),
        gauge_interval(scene.output.gauge_interval),
        sub_steps(sub_steps_per_window(scene)),
        meetable(scene, structure.surface_properties().body),
        compute_s(report.timing("compute")) {
    watch_meetings(meetable, 0, structure.surface(), meeting);
  }

  SoloStep advance(Ticks now, Ticks target) {
    const Ticks left = (gauge_interval > 0 ? std::min(target, next_multiple(gauge_interval, now)) : target) - now;
    const auto windows = static_cast<Ticks>(seconds(left) / (sub_steps * structure.largest_sub_step())) + 1;
    const Ticks duration = std::max<Ticks>(left / windows, 1);
    ScopedTimer timer(compute_s);
    structure.trial(now, duration);
    watch_meetings(meetable, seconds(now + duration), structure.surface(), meeting);
    return {duration, windows > 1 ? "sub-step" : "output", -1};
  }
  Ticks last_window() const { return 0; }  // sub-steps may be short
  void save(StateWriter& file) const {
    file("structure", structure.state());
    file("meeting", meeting);
  }
  void restore(StateReader& file) {
    structure::CompleteState<D> state = structure.state();
    file("structure", state);
    structure.set_state(state);
    file("meeting", meeting);
  }

  structure::Structure<D> structure;
  double gauge_interval;  ///< [s]
  double sub_steps;
  Meetable meetable;
  MeetingState<D> meeting;
  double& compute_s;
};

template <int D>
void run_without_fluid(const CommandLine& command, const Case& scene, RunReport& report) {
  Alone<D> alone(scene, report);
  set_threads(command, shared_out, report);
  run_alone(command, scene, report, structure::StructureSide<D>(scene, alone.structure), gauge_columns(scene, GaugeOwner::structure),
            structure_energy_columns(scene), alone);
}

template <int D>
void run(const CommandLine& command, const Case& scene, RunReport& report) {
  if (command.alone()) return run_without_fluid<D>(command, scene, report);
  proto::take_part(command, wire::STRUCTURE, [&](proto::ParticipantChannel& channel) {
    structure::Structure<D> structure(scene);
    set_threads(command, shared_out, report);
    structure::Participant<D> participant(command, scene, report, channel, structure);
    proto::take_part_as_structure<D>(channel, participant);
  });
}

}  // namespace

int main(int argc, char** argv) {
  return run_main(argc, argv, "structure", [](const CommandLine& command, const Case& scene, RunReport& report) {
    if (!scene.structure) throw BadInput(scene.path + " has no [[structure.body]], so there is nothing for tern-structure to do.");
    if (command.alone() && scene.fluid)
      throw BadInput(scene.path + " has a [fluid] table: start tern-structure with --endpoint, or use ./tern run.");
    scene.dimension == 2 ? run<2>(command, scene, report) : run<3>(command, scene, report);
  });
}
