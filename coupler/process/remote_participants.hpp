#pragma once
// Fluid and structure in processes of their own, at the other end of the channel.

#include <functional>

#include "coupler/participants.hpp"
#include "coupler/stability/surface_check.hpp"
#include "proto/transport/channel.hpp"

namespace tern::coupler {

/// Orders that need no answer are sent ahead, so that the fluid finds its neighbours while the structure predicts its surface, and the
/// structure finishes its window while the fluid finishes its own. The fluid is told first: it computes longer.
template <int D>
class RemoteParticipants final : public Participants<D> {
 public:
  /// `at_begin` gets the structure's account of the begin of each window, before anything of the window is computed, and answers with
  /// the energies of both sides.
  using AtBegin = std::function<std::optional<Energies>(const wire::Account&)>;
  /// `own_structure`: it is tern's, of this version. What the check finds of it is no fault of its messages, but of the computation.
  RemoteParticipants(proto::CouplerChannel& channel, SurfaceCheck<D> check, bool own_structure, AtBegin at_begin)
      : channel_(channel), check_(std::move(check)), own_structure_(own_structure), at_begin_(std::move(at_begin)) {}

  void begin_window(Ticks begin, Ticks duration) override;
  Surface<D> predict_surface(Ticks begin, Ticks duration) override;
  std::optional<Energies> energies() const override { return energies_; }
  std::optional<FluidExtent<D>> extent() const override;
  void pass_window() override;
  InterfaceParticles<D> see_surface(const Surface<D>& surface) override;
  InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& condition) override;
  std::vector<Vector<D>> respond(const SurfaceLoad<D>& load) override;
  void end_window(const InterfaceForce<D>& force) override;
  void apply(const SurfaceLoad<D>& load) override;

  /// Whether both sides write a frame at the end of the next window.
  void write_frame_at_end(bool write) { write_frame_ = write; }
  /// The fluid's last answer to a window, of a run that goes on from a checkpoint.
  void set_window_done(wire::WindowDone done) { window_done_ = std::move(done); }
  /// The fluid's answer to end_window() or pass_window(), for which a window does not wait.
  const wire::WindowDone& receive_window_done();
  /// Ends the run; the structure's last account.
  wire::Account finish(bool interrupted);

 private:
  void require(wire::Role from, proto::Kind kind, const std::string& fault) const;
  void require_of_surface(proto::Kind kind, const std::string& fault) const;

  proto::CouplerChannel& channel_;
  SurfaceCheck<D> check_;
  bool own_structure_;
  Ticks begin_ = 0, duration_ = 0;
  AtBegin at_begin_;
  std::optional<Energies> energies_;
  wire::WindowDone window_done_;
  bool write_frame_ = false;
};

}  // namespace tern::coupler
