#include "coupler/process/remote_participants.hpp"

#include <fmt/format.h>

#include <utility>

#include "base/error.hpp"
#include "proto/wire/convert.hpp"
#include "proto/wire/names.hpp"

namespace tern::coupler {

using proto::from_wire, proto::Kind, proto::to_wire;

template <int D>
void RemoteParticipants<D>::begin_window(Ticks begin, Ticks duration) {
  wire::Message order;
  order.mutable_begin_window()->set_begin_ticks(begin);
  order.mutable_begin_window()->set_duration_ticks(duration);
  order.mutable_begin_window()->set_write_frame(write_frame_);
  channel_.send(wire::FLUID, order);
  channel_.send(wire::STRUCTURE, std::move(order));
}

template <int D>
void RemoteParticipants<D>::require(wire::Role from, Kind kind, const std::string& fault) const {
  if (!fault.empty()) channel_.reject(from, kind, fault);
}

template <int D>
void RemoteParticipants<D>::require_of_surface(Kind kind, const std::string& fault) const {
  if (!fault.empty() && own_structure_)
    throw NumericalFailure(fmt::format(
        "The structure has run away in the window from t = {:.6g} s: in its {} {}. Likely cause: a body too soft or too light for "
        "the load of such a window. Use a smaller fluid.numerics.gravity_courant and courant, or a stiffer or heavier body.",
        seconds(begin_), proto::name(kind), fault));
  require(wire::STRUCTURE, kind, fault);
}

template <int D>
Surface<D> RemoteParticipants<D>::predict_surface(Ticks begin, Ticks duration) {
  const wire::Message message = channel_.receive(wire::STRUCTURE, {Kind::kSurface});
  energies_ = at_begin_(message.surface().account());
  Surface<D> surface = from_wire<D>(message.surface());
  begin_ = begin;
  duration_ = duration;
  require_of_surface(Kind::kSurface, check_.surface(duration, surface));
  return surface;
}

template <int D>
std::optional<FluidExtent<D>> RemoteParticipants<D>::extent() const {
  if (!window_done_.has_extent()) return std::nullopt;
  return from_wire<D>(window_done_.extent());
}

template <int D>
void RemoteParticipants<D>::pass_window() {
  wire::Message message;
  message.mutable_surface();
  channel_.send(wire::FLUID, std::move(message));
}

template <int D>
InterfaceParticles<D> RemoteParticipants<D>::see_surface(const Surface<D>& surface) {
  wire::Message message;
  *message.mutable_surface() = to_wire<D>(surface);
  channel_.send(wire::FLUID, std::move(message));
  InterfaceParticles<D> particles = from_wire<D>(channel_.receive(wire::FLUID, {Kind::kInterfaceParticles}).interface_particles());
  require(wire::FLUID, Kind::kInterfaceParticles, check_.particles(duration_, particles));
  return particles;
}

template <int D>
InterfacePressure<D> RemoteParticipants<D>::solve_pressure(const InterfaceCondition<D>& condition) {
  wire::Message message;
  *message.mutable_interface_condition() = to_wire<D>(condition);
  channel_.send(wire::FLUID, std::move(message));
  return from_wire<D>(channel_.receive(wire::FLUID, {Kind::kInterfacePressure}).interface_pressure());
}

template <int D>
std::vector<Vector<D>> RemoteParticipants<D>::respond(const SurfaceLoad<D>& load) {
  wire::Message message;
  *message.mutable_surface_load() = to_wire<D>(load);
  message.mutable_surface_load()->set_trial(true);
  channel_.send(wire::STRUCTURE, std::move(message));
  std::vector<Vector<D>> velocity = from_wire<D>(channel_.receive(wire::STRUCTURE, {Kind::kSurfaceVelocity}).surface_velocity());
  require_of_surface(Kind::kSurfaceVelocity, check_.answer(load, velocity));
  return velocity;
}

template <int D>
void RemoteParticipants<D>::end_window(const InterfaceForce<D>& force) {
  wire::Message message;
  *message.mutable_interface_force() = to_wire<D>(force);
  channel_.send(wire::FLUID, std::move(message));
}

template <int D>
void RemoteParticipants<D>::apply(const SurfaceLoad<D>& load) {
  wire::Message message;
  *message.mutable_surface_load() = to_wire<D>(load);
  channel_.send(wire::STRUCTURE, std::move(message));
  check_.apply(load);
}

template <int D>
const wire::WindowDone& RemoteParticipants<D>::receive_window_done() {
  window_done_ = channel_.receive(wire::FLUID, {Kind::kWindowDone}).window_done();
  return window_done_;
}

template <int D>
wire::Account RemoteParticipants<D>::finish(bool interrupted) {
  for (wire::Role role : {wire::FLUID, wire::STRUCTURE}) {
    wire::Message message;
    message.mutable_finish()->set_interrupted(interrupted);
    channel_.send(role, std::move(message));
  }
  channel_.receive(wire::FLUID, {Kind::kFinished});
  return channel_.receive(wire::STRUCTURE, {Kind::kFinished}).finished().account();
}

template class RemoteParticipants<2>;
template class RemoteParticipants<3>;

}  // namespace tern::coupler
