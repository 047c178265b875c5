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

/// Without surface load, in windows of equal length between two instants of output.
template <int D>
void run_without_fluid(const CommandLine& command, const Case& scene, RunReport& report) {
  structure::Structure<D> structure(scene);
  const FrameSchedule gauge_times(scene.output.gauge_interval, to_ticks(scene.end_time));
  const double sub_steps = sub_steps_per_window(scene);
  const Meetable meetable(scene, structure.surface_properties().body);
  MeetingState<D> meeting;
  watch_meetings(meetable, 0, structure.surface(), meeting);
  double& compute_s = report.timing("compute");
  const auto advance = [&](Ticks now, Ticks target) -> SoloStep {
    const Ticks left = std::min(target, gauge_times.next(now)) - now;
    const auto windows = static_cast<Ticks>(seconds(left) / (sub_steps * structure.largest_sub_step())) + 1;
    const Ticks duration = std::max<Ticks>(left / windows, 1);
    ScopedTimer timer(compute_s);
    structure.trial(now, duration);
    watch_meetings(meetable, seconds(now + duration), structure.surface(), meeting);
    return {duration, "output", -1};
  };
  run_alone(command, scene, report, structure::StructureSide<D>(scene, structure), gauge_columns(scene, GaugeOwner::structure),
            structure_energy_columns(scene), advance);
}

template <int D>
void run(const CommandLine& command, const Case& scene, RunReport& report) {
  if (command.alone()) return run_without_fluid<D>(command, scene, report);
  proto::take_part(command, wire::STRUCTURE, [&](proto::ParticipantChannel& channel) {
    structure::Structure<D> structure(scene);
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
