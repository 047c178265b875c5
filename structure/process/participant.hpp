#pragma once
// The structure as one of three processes: what proto/participant/participant.hpp asks of a solver.

#include <vector>

#include "proto/participant/participant_frame.hpp"
#include "structure/coupled_structure.hpp"
#include "structure/process/structure_side.hpp"

namespace tern::structure {

template <int D>
class Participant : public proto::ParticipantFrame<Participant<D>, StructureSide<D>> {
  using Frame = proto::ParticipantFrame<Participant<D>, StructureSide<D>>;
  using Frame::timed;

 public:
  Participant(const CommandLine& command, const Case& scene, RunReport& report, proto::ParticipantChannel& channel, Structure<D>& structure)
      : Frame(command, scene, report, channel, StructureSide<D>(scene, structure)),
        trial_s_(report.timing("compute.trial")),
        structure_(structure),
        coupled_(structure, scene.coupling.algorithm) {}

  wire::Hello hello() {
    wire::Hello hello = Frame::hello(D, structure_.particles());
    *hello.mutable_surface() = proto::to_wire(structure_.surface_properties());
    return hello;
  }

  Surface<D> predict_surface(Ticks begin, Ticks duration) {
    ScopedTimer timer(trial_s_);
    return timed([&] { return coupled_.predict_surface(begin, duration); });
  }
  std::vector<Vector<D>> respond(const SurfaceLoad<D>& load) {
    ScopedTimer timer(trial_s_);
    return timed([&] { return coupled_.respond(load); });
  }
  void apply(const SurfaceLoad<D>& load) {
    timed([&] { coupled_.apply(load); });
  }

  void save_solver(StateWriter& file) const { file("structure", coupled_.state()); }
  void restore_solver(StateReader& file) {
    CoupledState<D> state = coupled_.state();
    file("structure", state);
    coupled_.set_state(state);
  }

 private:
  double& trial_s_;  // passes over a window but the last
  Structure<D>& structure_;
  CoupledStructure<D> coupled_;
};

}  // namespace tern::structure
