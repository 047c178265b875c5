#pragma once
// Whether fluid and structure agree: the velocity that the fluid takes the surface to have, as its pressure equation moves it under its
// answer, and the velocity that the surface has.

#include <vector>

#include "coupler/setup.hpp"
#include "coupler/state.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

/// Of the body with the largest: difference of the velocities of its surface, normal components over the root of the area, and what of it
/// is accepted [m/s m^((D-1)/2)]. The fluid makes up for a difference e in the next window, by the load m_a e / dt. So e is accepted as a
/// small share of the change of velocity in this window, for the load is the inertia of the fluid times that change; where it stands for
/// a small part of the load that there is; and where a place that is off by e dt is the same place for all that particles resolve.
struct Disagreement {
  double size = 0, accepted = 0;
  bool agrees() const { return size <= accepted; }
};

/// What the fluid takes the surface to have, u* and what the lumps make of f - x, against `velocity`; f answers the assumed load x.
template <int D>
Disagreement disagreement(const Setup<D>& setup, const State<D>& state, const Workspace<D>& window, const SurfaceLoad<D>& answer,
                          const std::vector<Vector<D>>& velocity);

}  // namespace tern::coupler
