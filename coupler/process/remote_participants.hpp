#pragma once
// The two participants as run_window() sees them, at the other end of the channel.

#include <functional>
#include <optional>

#include "coupler/window.hpp"
#include "proto/transport/channel.hpp"
#include "proto/wire/convert.hpp"

namespace tern::coupler {

/// Both sides of a run in other processes. Orders that need no answer are sent ahead, so that the fluid finds its neighbours
/// while the structure makes its trial, and the structure finishes its window while the fluid finishes its own. The fluid is told
/// first: it computes longer.
template <int D>
class RemoteParticipants {
 public:
  /// `at_begin` gets the structure's account of the begin of each window, before anything of the window is computed.
  RemoteParticipants(proto::CouplerChannel& channel, std::function<void(const wire::Account&)> at_begin)
      : channel_(channel), at_begin_(std::move(at_begin)) {}

  // Fluid side.
  void begin_window(Ticks begin, Ticks duration) {
    wire::Message order;
    order.mutable_begin_window()->set_begin_ticks(begin);
    order.mutable_begin_window()->set_duration_ticks(duration);
    order.mutable_begin_window()->set_write_frame(write_frame_);
    channel_.send(wire::FLUID, order);
    channel_.send(wire::STRUCTURE, std::move(order));
  }
  InterfaceParticles<D> see_surface(const Surface<D>& surface) {
    wire::Message message;
    *message.mutable_surface() = proto::to_wire<D>(surface);
    channel_.send(wire::FLUID, std::move(message));
    return proto::from_wire<D>(channel_.receive(wire::FLUID, {proto::Kind::kBand}).band());
  }
  InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& load) {
    wire::Message message;
    *message.mutable_dissipative_load() = proto::to_wire<D>(load);
    channel_.send(wire::FLUID, std::move(message));
    return proto::from_wire<D>(channel_.receive(wire::FLUID, {proto::Kind::kBandPressure}).band_pressure());
  }
  void end_window(const InterfaceForce<D>& force) {
    wire::Message message;
    *message.mutable_band_force() = proto::to_wire<D>(force);
    channel_.send(wire::FLUID, std::move(message));
  }
  std::optional<FluidExtent<D>> extent() const {
    if (!window_done_.has_extent()) return std::nullopt;
    return proto::from_wire<D>(window_done_.extent());
  }
  void pass_window() {
    wire::Message message;
    message.mutable_surface();
    channel_.send(wire::FLUID, std::move(message));
  }
  /// The fluid's answer to end_window() or pass_window(), for which run_window() does not wait.
  const wire::WindowDone& receive_window_done() {
    window_done_ = channel_.receive(wire::FLUID, {proto::Kind::kWindowDone}).window_done();
    return window_done_;
  }

  // Structure side.
  Surface<D> predict_surface(Ticks, Ticks) {
    const wire::Message message = channel_.receive(wire::STRUCTURE, {proto::Kind::kSurface});
    at_begin_(message.surface().account());
    return proto::from_wire<D>(message.surface());
  }
  std::vector<Vector<D>> respond(const SurfaceLoad<D>& load) {
    wire::Message message;
    *message.mutable_surface_load() = proto::to_wire<D>(load);
    message.mutable_surface_load()->set_trial(true);
    channel_.send(wire::STRUCTURE, std::move(message));
    return proto::from_wire<D>(channel_.receive(wire::STRUCTURE, {proto::Kind::kSurfaceVelocity}).surface_velocity());
  }
  void apply(const SurfaceLoad<D>& load) {
    wire::Message message;
    *message.mutable_surface_load() = proto::to_wire<D>(load);
    channel_.send(wire::STRUCTURE, std::move(message));
  }

  void write_frame_at_end(bool write) { write_frame_ = write; }

 private:
  proto::CouplerChannel& channel_;
  std::function<void(const wire::Account&)> at_begin_;
  wire::WindowDone window_done_;
  bool write_frame_ = false;
};

}  // namespace tern::coupler
