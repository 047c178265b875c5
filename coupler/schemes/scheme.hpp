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

/// The pressures of the particles, carried to the surface by the weight of the fluid between.
template <int D>
struct CarriedPressure {
  const std::vector<double>& pressure;  ///< of every particle [Pa]
  const InterfaceParticles<D>& particles;
  const Surface<D>& surface;
  Vector<D> weight;  ///< of the fluid, rho g [N/m^3]

  /// q of a pair of particle i and point k [Pa]. Behind a wall it goes on as before it: an image carries what its particle does.
  double operator()(int i, int k) const { return pressure[i] + weight.dot(surface.position[k] - particles.position[i]); }
};

/// What a scheme makes of the carried pressures: a pair has share_k (q - gradient_k . d), d the way from the point to the particle or to
/// its image; times b_ik its force.
template <int D>
struct PointPressures {
  std::vector<double> share;        ///< of every surface point
  std::vector<Vector<D>> gradient;  ///< of every surface point [Pa/m]; empty: 0

  double operator()(const InterfacePair<D>& pair, double carried) const {
    return share[pair.point] * (gradient.empty() ? carried : carried - gradient[pair.point].dot(pair.offset));
  }
};

template <int D>
struct Scheme {
  /// Load of a surface point under a uniform pressure p, over p A, where particles fill this part of its half space (1: all of it).
  double (*load_share)(double filled);
  /// Sets `points` from what they see.
  void (*weigh_pressures)(const Kernel<D>&, const InterfacePairs<D>&, const CarriedPressure<D>&, PointPressures<D>& points);
  /// Adds forces that are known before the pressure solve to load and condition of the window, and what they dissipate to its audit. Null:
  /// there are none.
  void (*add_explicit_forces)(const Setup<D>&, Workspace<D>&, Evaluations&);
};

template <int D>
const Scheme<D>& scheme_of(InterfaceScheme name);  ///< from registry.cpp

/// Makes the carried pressures up for what the particles before every point fill: under a uniform pressure p the point has s_k p A_k.
template <int D>
void take_means(const Kernel<D>& kernel, const InterfacePairs<D>& pairs, const CarriedPressure<D>& carried, PointPressures<D>& points);

/// Load of every surface point under a uniform pressure, over that pressure times its area.
template <int D>
std::vector<double> uniform_load(const Scheme<D>& scheme, const InterfacePairs<D>& pairs);

}  // namespace tern::coupler
