#pragma once
// proto/interface.hpp <-> wire messages, bit for bit. Vectors travel point by point: x0 y0 [z0] x1 y1 [z1] ...
// A received message has been checked by the channel before it gets here: lengths are consistent (asserted).
//   wire::Message m;  *m.mutable_band() = to_wire(band);  channel.send(std::move(m));
//   Surface<D> s = from_wire<D>(channel.receive({Kind::kSurface}).surface());

#include "proto/interface.hpp"
#include "proto/wire/tern.pb.h"

namespace tern::proto {

wire::SurfaceProperties to_wire(const SurfaceProperties& properties);
SurfaceProperties from_wire(const wire::SurfaceProperties& message);

template <int D>
wire::Surface to_wire(const Surface<D>& surface);  ///< account left empty
template <int D>
wire::Band to_wire(const InterfaceParticles<D>& band);
template <int D>
wire::DissipativeLoad to_wire(const InterfaceCondition<D>& load);
template <int D>
wire::BandPressure to_wire(const InterfacePressure<D>& pressure);
template <int D>
wire::BandForce to_wire(const InterfaceForce<D>& force);
template <int D>
wire::SurfaceLoad to_wire(const SurfaceLoad<D>& load);
template <int D>
wire::SurfaceVelocity to_wire(const std::vector<Vector<D>>& velocity);

template <int D>
wire::Extent to_wire(const FluidExtent<D>& extent);

template <int D>
Surface<D> from_wire(const wire::Surface& message);
template <int D>
InterfaceParticles<D> from_wire(const wire::Band& message);
template <int D>
InterfaceCondition<D> from_wire(const wire::DissipativeLoad& message);
template <int D>
InterfacePressure<D> from_wire(const wire::BandPressure& message);
template <int D>
InterfaceForce<D> from_wire(const wire::BandForce& message);
template <int D>
SurfaceLoad<D> from_wire(const wire::SurfaceLoad& message);
template <int D>
std::vector<Vector<D>> from_wire(const wire::SurfaceVelocity& message);
template <int D>
FluidExtent<D> from_wire(const wire::Extent& message);

}  // namespace tern::proto
