#pragma once
// proto/interface.hpp <-> wire messages, bit for bit. Vectors travel point by point: x0 y0 [z0] x1 y1 [z1] ...
// A received message has been checked by the channel before it gets here: lengths are consistent (asserted).
//   wire::Message m;  *m.mutable_interface_particles() = to_wire(particles);  channel.send(std::move(m));
//   Surface<D> s = from_wire<D>(channel.receive({Kind::kSurface}).surface());

#include "proto/interface.hpp"
#include "proto/wire/tern.pb.h"

namespace tern::proto {

wire::SurfaceProperties to_wire(const SurfaceProperties& properties);
SurfaceProperties from_wire(const wire::SurfaceProperties& message);

template <int D>
wire::Surface to_wire(const Surface<D>& surface);  ///< account left empty
template <int D>
wire::InterfaceParticles to_wire(const InterfaceParticles<D>& particles);
template <int D>
wire::InterfaceCondition to_wire(const InterfaceCondition<D>& load);
template <int D>
wire::InterfacePressure to_wire(const InterfacePressure<D>& pressure);
template <int D>
wire::InterfaceForce to_wire(const InterfaceForce<D>& force);
template <int D>
wire::SurfaceLoad to_wire(const SurfaceLoad<D>& load);
template <int D>
wire::SurfaceVelocity to_wire(const std::vector<Vector<D>>& velocity);

template <int D>
wire::Extent to_wire(const FluidExtent<D>& extent);

template <int D>
Surface<D> from_wire(const wire::Surface& message);
template <int D>
InterfaceParticles<D> from_wire(const wire::InterfaceParticles& message);
template <int D>
InterfaceCondition<D> from_wire(const wire::InterfaceCondition& message);
template <int D>
InterfacePressure<D> from_wire(const wire::InterfacePressure& message);
template <int D>
InterfaceForce<D> from_wire(const wire::InterfaceForce& message);
template <int D>
SurfaceLoad<D> from_wire(const wire::SurfaceLoad& message);
template <int D>
std::vector<Vector<D>> from_wire(const wire::SurfaceVelocity& message);
template <int D>
FluidExtent<D> from_wire(const wire::Extent& message);

}  // namespace tern::proto
