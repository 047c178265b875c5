// Any bytes as messages: nothing but a fault may come of them, and what is found to be in order can be used.
// Input: messages one after the other, each after its length as a varint, as in an interface.record.

#include <google/protobuf/io/coded_stream.h>

#include <map>
#include <span>

#include "proto/wire/convert.hpp"
#include "proto/wire/message_check.hpp"

namespace {

using namespace tern;
using proto::Kind;

/// Reads every number of an accepted message as the solvers do.
template <int D>
void use(const wire::Message& message) {
  switch (message.body_case()) {
    case Kind::kHello: proto::from_wire(message.hello().surface()); break;
    case Kind::kSurface: proto::from_wire<D>(message.surface()); break;
    case Kind::kInterfaceParticles: proto::from_wire<D>(message.interface_particles()); break;
    case Kind::kInterfaceCondition: proto::from_wire<D>(message.interface_condition()); break;
    case Kind::kInterfacePressure: proto::from_wire<D>(message.interface_pressure()); break;
    case Kind::kInterfaceForce: proto::from_wire<D>(message.interface_force()); break;
    case Kind::kSurfaceLoad: proto::from_wire<D>(message.surface_load()); break;
    case Kind::kSurfaceVelocity: proto::from_wire<D>(message.surface_velocity()); break;
    default: break;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  google::protobuf::io::CodedInputStream input(data, static_cast<int>(size));
  std::map<wire::Role, proto::Agreement> agreements;
  std::uint64_t sequence = 0;
  for (std::uint32_t length = 0; input.ReadVarint32(&length);) {
    const auto position = static_cast<std::size_t>(input.CurrentPosition());
    const std::size_t taken = std::min<std::size_t>(length, size - position);
    wire::Message message;
    const std::string unreadable = proto::parse(std::as_bytes(std::span(data + position, taken)), message);
    input.Skip(static_cast<int>(taken));
    if (!unreadable.empty()) continue;
    proto::find_envelope_fault(message, {message.sender(), ++sequence, message.step()}, {Kind::kHello, Kind::kInterfaceParticles});
    proto::Agreement& agreement = agreements[message.sender()];
    if (agreement.dimension == 0 && !message.has_hello()) continue;  // the channel takes nothing before a Hello
    if (!proto::find_body_fault(message, agreement).empty()) continue;
    proto::remember(message, agreement);
    agreement.dimension == 2 ? use<2>(message) : use<3>(message);
  }
  return 0;
}
