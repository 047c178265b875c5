#pragma once
// The fluid's side of the interface where several ranks compute it: the first one speaks for all.

#include "proto/interface.hpp"
#include "ranks/ranks.hpp"

namespace tern::fluid {

/// How many interface particles each rank has.
std::vector<std::int64_t> interface_counts(const Ranks& ranks, std::size_t own);
/// Number of the first interface particle of this rank among those of all, which come in the order of the ranks.
std::ptrdiff_t first_interface_particle(const Ranks& ranks, const std::vector<std::int64_t>& counts);

/// On the first rank those of all ranks; on the others nothing.
template <int D>
InterfaceParticles<D> gather(const Ranks& ranks, const std::vector<std::int64_t>& counts, InterfaceParticles<D> own);
template <int D>
InterfacePressure<D> gather(const Ranks& ranks, InterfacePressure<D> own);

/// From the first rank to all.
template <int D>
void tell(const Ranks& ranks, Surface<D>& surface);
template <int D>
void tell(const Ranks& ranks, InterfaceCondition<D>& condition);
template <int D>
void tell(const Ranks& ranks, InterfaceForce<D>& force);

}  // namespace tern::fluid
