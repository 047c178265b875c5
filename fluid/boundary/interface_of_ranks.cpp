#include "fluid/boundary/interface_of_ranks.hpp"

#include <algorithm>
#include <numeric>

namespace tern::fluid {

std::vector<std::int64_t> interface_counts(const Ranks& ranks, std::size_t own) {
  std::vector<std::int64_t> counts(static_cast<std::size_t>(ranks.count()), 0);
  counts[static_cast<std::size_t>(ranks.own())] = static_cast<std::int64_t>(own);
  ranks.sum(std::span(counts));
  return counts;
}

std::ptrdiff_t first_interface_particle(const Ranks& ranks, const std::vector<std::int64_t>& counts) {
  return std::accumulate(counts.begin(), counts.begin() + ranks.own(), std::ptrdiff_t{0});
}

template <int D>
InterfaceParticles<D> gather(const Ranks& ranks, const std::vector<std::int64_t>& counts, InterfaceParticles<D> own) {
  if (ranks.alone()) return own;
  // All ranks whose particles see the surface know the same covered points.
  const auto speaker = std::find_if(counts.begin(), counts.end(), [](std::int64_t count) { return count > 0; });
  const bool speaks = speaker != counts.end() && speaker - counts.begin() == ranks.own();
  if (!speaks) own.covered.clear();
  for (std::uint32_t& particle : own.image_of) particle += static_cast<std::uint32_t>(first_interface_particle(ranks, counts));
  ranks.gather_together(own.id, own.position, own.velocity, own.mass, own.volume, own.divergence, own.image_of, own.image_position,
                        own.covered);
  return own;
}

template <int D>
InterfacePressure<D> gather(const Ranks& ranks, InterfacePressure<D> own) {
  ranks.gather_together(own.pressure, own.velocity);
  return own;
}

template <int D>
void tell(const Ranks& ranks, Surface<D>& surface) {
  ranks.tell_together(surface.position, surface.velocity, surface.normal, surface.area);
}

template <int D>
void tell(const Ranks& ranks, InterfaceCondition<D>& condition) {
  std::vector<std::uint8_t> repeats{condition.repeats};
  std::vector<double> tolerance{condition.answer_tolerance};
  ranks.tell_together(condition.force, condition.reference_pressure, condition.response.lump, condition.response.share,
                      condition.response.mass, condition.surface_velocity, condition.answered_change, repeats, tolerance);
  condition.repeats = repeats[0] != 0;
  condition.answer_tolerance = tolerance[0];
}

template <int D>
void tell(const Ranks& ranks, InterfaceForce<D>& force) {
  ranks.tell_together(force.force);
}

#define TERN_INSTANTIATE(D)                                                                                        \
  template InterfaceParticles<D> gather<D>(const Ranks&, const std::vector<std::int64_t>&, InterfaceParticles<D>); \
  template InterfacePressure<D> gather<D>(const Ranks&, InterfacePressure<D>);                                     \
  template void tell<D>(const Ranks&, Surface<D>&);                                                                \
  template void tell<D>(const Ranks&, InterfaceCondition<D>&);                                                     \
  template void tell<D>(const Ranks&, InterfaceForce<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
