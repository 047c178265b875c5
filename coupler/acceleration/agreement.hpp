#pragma once
// Whether fluid and structure agree: the velocity that the fluid takes the surface to have, as its pressure equation moves it under its
// answer, and the velocity that the surface has.

#include <vector>

#include "coupler/setup.hpp"
#include "coupler/state.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

/// A difference of velocities of the surface that is small, normal components over the root of the area: a share of the change of
/// velocity in this window, since the load is the inertia of the fluid times that change; but at least a small share of the fastest motion
/// [m/s m^((D-1)/2)].
struct Disagreement {
  double size = 0, accepted = 0;
  bool agrees() const { return size <= accepted; }
};

/// What the fluid takes the surface to have, u* and the answer of the lumps to f - x, against `velocity`; f answers the assumed load x.
template <int D>
Disagreement disagreement(const Setup<D>& setup, const State<D>& state, const Workspace<D>& window, const SurfaceLoad<D>& answer,
                          const std::vector<Vector<D>>& velocity);

}  // namespace tern::coupler
