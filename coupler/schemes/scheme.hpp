#pragma once
// Interface schemes: how the pressures of fluid particles become forces on faces and on the particles. One file each, one line in
// scene/interface_schemes.hpp.

#include <vector>

#include "coupler/schemes/interface_pairs.hpp"
#include "coupler/setup.hpp"
#include "proto/interface.hpp"

namespace tern::coupler {

template <int D>
struct Workspace;
struct Evaluations;

/// What a scheme sees of the pairs whose pressures it changes.
template <int D>
struct PairView {
  const Kernel<D>& kernel;
  PairRange<D> pairs;
  const Surface<D>& surface;
  const InterfaceParticles<D>& particles;
  const std::vector<double>& weighed_area;  ///< of every surface point (InterfacePairs)
};

template <int D>
struct Scheme {
  /// Load of a surface point under a uniform pressure p, over p A, where particles fill this part of its half space (1: all of it).
  double (*load_share)(double filled);
  /// Replaces the carried pressures q_i [Pa] of all pairs by those which, times b_ik, are the pair forces. Null: they are already.
  void (*pair_pressures)(const PairView<D>&, std::vector<double>& carried);
  /// Adds forces that are known before the pressure solve to load and condition of the window, and what they dissipate to its audit. Null:
  /// there are none.
  void (*add_explicit_forces)(const Setup<D>&, Workspace<D>&, Evaluations&);
};

template <int D>
const Scheme<D>& scheme_of(InterfaceScheme name);  ///< from registry.cpp

/// Makes the carried pressures up for what the particles before every point fill: under a uniform pressure p the point has s_k p A_k.
template <int D>
void mean_pair_pressures(const PairView<D>& view, std::vector<double>& carried);

/// Load of every surface point under a uniform pressure, over that pressure times its area.
template <int D>
std::vector<double> uniform_load(const Scheme<D>& scheme, const InterfacePairs<D>& pairs);

}  // namespace tern::coupler
