// Conversions between proto/interface.hpp and the wire schema: the same doubles in the same order, nothing else.

#include "proto/wire/convert.hpp"

#include <cassert>
#include <cstring>

namespace tern::proto {
namespace {

using Doubles = google::protobuf::RepeatedField<double>;

template <int D>
void put(Doubles* field, const std::vector<Vector<D>>& vectors) {
  static_assert(sizeof(Vector<D>) == D * sizeof(double), "vectors are contiguous doubles");
  if (vectors.empty()) return field->Clear();
  const double* begin = vectors.data()->data();
  field->Assign(begin, begin + D * vectors.size());
}

void put(Doubles* field, const std::vector<double>& scalars) { field->Assign(scalars.begin(), scalars.end()); }

template <int D>
std::vector<Vector<D>> get_vectors(const Doubles& field) {
  assert(field.size() % D == 0);
  std::vector<Vector<D>> vectors(static_cast<std::size_t>(field.size() / D));
  if (!vectors.empty()) std::memcpy(vectors.data()->data(), field.data(), vectors.size() * sizeof(Vector<D>));
  return vectors;
}

template <class T>
std::vector<T> get(const google::protobuf::RepeatedField<T>& field) {
  return {field.data(), field.data() + field.size()};
}

}  // namespace

wire::SurfaceProperties to_wire(const SurfaceProperties& properties) {
  wire::SurfaceProperties message;
  message.mutable_body()->Assign(properties.body.begin(), properties.body.end());
  put(message.mutable_section_mass(), properties.section_mass);
  put(message.mutable_impedance(), properties.impedance);
  put(message.mutable_least_mass(), properties.least_mass);
  return message;
}

SurfaceProperties from_wire(const wire::SurfaceProperties& message) {
  return {get(message.body()), get(message.section_mass()), get(message.impedance()), get(message.least_mass())};
}

template <int D>
wire::Surface to_wire(const Surface<D>& surface) {
  wire::Surface message;
  put<D>(message.mutable_position(), surface.position);
  put<D>(message.mutable_velocity(), surface.velocity);
  put<D>(message.mutable_normal(), surface.normal);
  put(message.mutable_area(), surface.area);
  return message;
}

template <int D>
Surface<D> from_wire(const wire::Surface& message) {
  return {get_vectors<D>(message.position()), get_vectors<D>(message.velocity()), get_vectors<D>(message.normal()), get(message.area())};
}

template <int D>
wire::InterfaceParticles to_wire(const InterfaceParticles<D>& particles) {
  wire::InterfaceParticles message;
  message.mutable_id()->Assign(particles.id.begin(), particles.id.end());
  put<D>(message.mutable_position(), particles.position);
  put<D>(message.mutable_velocity(), particles.velocity);
  put(message.mutable_mass(), particles.mass);
  put(message.mutable_volume(), particles.volume);
  put(message.mutable_divergence(), particles.divergence);
  message.mutable_image_of()->Assign(particles.image_of.begin(), particles.image_of.end());
  put<D>(message.mutable_image_position(), particles.image_position);
  message.mutable_covered()->Assign(particles.covered.begin(), particles.covered.end());
  message.set_is_enclosed(particles.is_enclosed);
  return message;
}

template <int D>
InterfaceParticles<D> from_wire(const wire::InterfaceParticles& message) {
  return {get(message.id()),
          get_vectors<D>(message.position()),
          get_vectors<D>(message.velocity()),
          get(message.mass()),
          get(message.volume()),
          get(message.divergence()),
          get(message.image_of()),
          get_vectors<D>(message.image_position()),
          get(message.covered()),
          message.is_enclosed()};
}

template <int D>
wire::InterfaceCondition to_wire(const InterfaceCondition<D>& load) {
  wire::InterfaceCondition message;
  put<D>(message.mutable_force(), load.force);
  put(message.mutable_reference_pressure(), load.reference_pressure);
  message.mutable_lump()->Assign(load.response.lump.begin(), load.response.lump.end());
  put(message.mutable_share(), load.response.share);
  put(message.mutable_lump_mass(), load.response.mass);
  put<D>(message.mutable_surface_velocity(), load.surface_velocity);
  message.set_repeats(load.repeats);
  put<D>(message.mutable_answered_change(), load.answered_change);
  message.set_answer_tolerance(load.answer_tolerance);
  return message;
}

template <int D>
InterfaceCondition<D> from_wire(const wire::InterfaceCondition& message) {
  return {get_vectors<D>(message.force()),
          get(message.reference_pressure()),
          {get(message.lump()), get(message.share()), get(message.lump_mass())},
          get_vectors<D>(message.surface_velocity()),
          message.repeats(),
          get_vectors<D>(message.answered_change()),
          message.answer_tolerance()};
}

template <int D>
wire::InterfacePressure to_wire(const InterfacePressure<D>& pressure) {
  wire::InterfacePressure message;
  put(message.mutable_pressure(), pressure.pressure);
  put<D>(message.mutable_velocity(), pressure.velocity);
  return message;
}

template <int D>
InterfacePressure<D> from_wire(const wire::InterfacePressure& message) {
  return {get(message.pressure()), get_vectors<D>(message.velocity())};
}

template <int D>
wire::InterfaceForce to_wire(const InterfaceForce<D>& force) {
  wire::InterfaceForce message;
  put<D>(message.mutable_force(), force.force);
  return message;
}

template <int D>
InterfaceForce<D> from_wire(const wire::InterfaceForce& message) {
  return {get_vectors<D>(message.force())};
}

template <int D>
wire::SurfaceLoad to_wire(const SurfaceLoad<D>& load) {
  wire::SurfaceLoad message;
  put<D>(message.mutable_force(), load.force);
  return message;
}

template <int D>
SurfaceLoad<D> from_wire(const wire::SurfaceLoad& message) {
  return {get_vectors<D>(message.force())};
}

template <int D>
wire::SurfaceVelocity to_wire(const std::vector<Vector<D>>& velocity) {
  wire::SurfaceVelocity message;
  put<D>(message.mutable_velocity(), velocity);
  return message;
}

template <int D>
std::vector<Vector<D>> from_wire(const wire::SurfaceVelocity& message) {
  return get_vectors<D>(message.velocity());
}

template <int D>
wire::Extent to_wire(const FluidExtent<D>& extent) {
  wire::Extent message;
  put<D>(message.mutable_low(), {extent.low});
  put<D>(message.mutable_high(), {extent.high});
  message.set_largest_speed(extent.largest_speed);
  message.set_reach(extent.reach);
  return message;
}

template <int D>
FluidExtent<D> from_wire(const wire::Extent& message) {
  return {get_vectors<D>(message.low()).at(0), get_vectors<D>(message.high()).at(0), message.largest_speed(), message.reach()};
}

#define TERN_INSTANTIATE(D)                                                     \
  template wire::Surface to_wire<D>(const Surface<D>&);                         \
  template wire::InterfaceParticles to_wire<D>(const InterfaceParticles<D>&);   \
  template wire::InterfaceCondition to_wire<D>(const InterfaceCondition<D>&);   \
  template wire::InterfacePressure to_wire<D>(const InterfacePressure<D>&);     \
  template wire::InterfaceForce to_wire<D>(const InterfaceForce<D>&);           \
  template wire::SurfaceLoad to_wire<D>(const SurfaceLoad<D>&);                 \
  template wire::SurfaceVelocity to_wire<D>(const std::vector<Vector<D>>&);     \
  template std::vector<Vector<D>> from_wire<D>(const wire::SurfaceVelocity&);   \
  template wire::Extent to_wire<D>(const FluidExtent<D>&);                      \
  template FluidExtent<D> from_wire<D>(const wire::Extent&);                    \
  template Surface<D> from_wire<D>(const wire::Surface&);                       \
  template InterfaceParticles<D> from_wire<D>(const wire::InterfaceParticles&); \
  template InterfaceCondition<D> from_wire<D>(const wire::InterfaceCondition&); \
  template InterfacePressure<D> from_wire<D>(const wire::InterfacePressure&);   \
  template InterfaceForce<D> from_wire<D>(const wire::InterfaceForce&);         \
  template SurfaceLoad<D> from_wire<D>(const wire::SurfaceLoad&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::proto
