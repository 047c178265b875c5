#include "fluid/boundary/interface_of_ranks.hpp"

#include <algorithm>
#include <numeric>

namespace tern::fluid {
namespace {

std::vector<std::int64_t> counts_of_ranks(const Ranks& ranks, std::size_t own) {
  std::vector<std::int64_t> counts(static_cast<std::size_t>(ranks.count()), 0);
  counts[static_cast<std::size_t>(ranks.own())] = static_cast<std::int64_t>(own);
  ranks.sum(std::span(counts));
  return counts;
}

}  // namespace

std::ptrdiff_t first_interface_particle(const Ranks& ranks, std::size_t own) {
  if (ranks.alone()) return 0;
  const std::vector<std::int64_t> counts = counts_of_ranks(ranks, own);
  return std::accumulate(counts.begin(), counts.begin() + ranks.own(), std::ptrdiff_t{0});
}

template <int D>
InterfaceParticles<D> gather(const Ranks& ranks, InterfaceParticles<D> own) {
  if (ranks.alone()) return own;
  // All ranks whose particles see the surface know the same covered points.
  const std::vector<std::int64_t> counts = counts_of_ranks(ranks, own.id.size());
  const auto speaker = std::find_if(counts.begin(), counts.end(), [](std::int64_t count) { return count > 0; });
  const bool speaks = speaker != counts.end() && speaker - counts.begin() == ranks.own();
  for (std::uint32_t& particle : own.image_of)
    particle += static_cast<std::uint32_t>(std::accumulate(counts.begin(), counts.begin() + ranks.own(), std::int64_t{0}));
  return {ranks.gather(own.id),       ranks.gather(own.position),       ranks.gather(own.velocity),
          ranks.gather(own.mass),     ranks.gather(own.volume),         ranks.gather(own.divergence),
          ranks.gather(own.image_of), ranks.gather(own.image_position), ranks.gather(speaks ? own.covered : std::vector<std::uint32_t>{})};
}

template <int D>
InterfacePressure<D> gather(const Ranks& ranks, InterfacePressure<D> own) {
  if (ranks.alone()) return own;
  return {ranks.gather(own.pressure), ranks.gather(own.velocity)};
}

template <int D>
void tell(const Ranks& ranks, Surface<D>& surface) {
  Surface<D>::for_each_field([&](const char*, auto& values) { ranks.tell(values); }, surface);
}

template <int D>
void tell(const Ranks& ranks, InterfaceCondition<D>& condition) {
  ranks.tell(condition.force);
  ranks.tell(condition.reference_pressure);
  ranks.tell(condition.response.lump);
  ranks.tell(condition.response.share);
  ranks.tell(condition.response.mass);
  ranks.tell(condition.surface_velocity);
  ranks.tell(&condition.repeats, sizeof condition.repeats);
}

template <int D>
void tell(const Ranks& ranks, InterfaceForce<D>& force) {
  ranks.tell(force.force);
}

#define TERN_INSTANTIATE(D)                                                      \
  template InterfaceParticles<D> gather<D>(const Ranks&, InterfaceParticles<D>); \
  template InterfacePressure<D> gather<D>(const Ranks&, InterfacePressure<D>);   \
  template void tell<D>(const Ranks&, Surface<D>&);                              \
  template void tell<D>(const Ranks&, InterfaceCondition<D>&);                   \
  template void tell<D>(const Ranks&, InterfaceForce<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
