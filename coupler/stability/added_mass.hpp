#pragma once
// What decides whether explicit staggering can work, known before the first step (Causin, Gerbeau & Nobile 2005): the fluid
// that has to move with the structure, m_a per area, over the mass behind the face, m_s. It multiplies an error of the
// interface velocity by -m_a/m_s per window, whatever its length.
//   m_a = rho_F min(H, 1/k),   k = 1.875/L the wave number of the first bending mode of a cantilever of the body's free
//                              length L,   H the least extent of the fluid at the start
//   m_s   half of the faces have more: the median of rho_S T/N_wet, all exposed faces taken as wet

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "proto/interface.hpp"
#include "scene/case_file.hpp"

namespace tern::coupler {

/// Above this, explicit coupling is taken as unstable: the onset is at 1 for a lumped mass, and the estimate of m_a is rough.
inline constexpr double explicit_limit = 0.8;

struct AddedMass {
  std::string body;       ///< the one with the largest ratio
  double ratio = 0;       ///< m_a/m_s
  double length = 0;      ///< min(H, 1/k) [m]
  bool by_depth = false;  ///< H is the smaller
};

/// Mass behind the faces of a body, the median over its points [kg/m^2]; 0 when it has none.
double section_mass(const SurfaceProperties& properties, std::size_t body);

template <int D>
AddedMass predict_added_mass(const Case& scene, const SurfaceProperties& properties);

/// The fluid as it stands at the start, by its weight.
struct FluidWeight {
  double pressure = 0, height = 0, volume = 0;                    ///< rho g H/2 [Pa]; H along gravity [m]; [m^D]
  double least_extent = std::numeric_limits<double>::infinity();  ///< [m]

  /// What it can set in motion beside a surface of this area: of the fluid that stands over it, or of all there is when that is less
  /// [J/m^(3-D)].
  double energy(double area) const { return pressure * std::min(volume, area * height); }
};
template <int D>
FluidWeight weight_of_fluid(const Case& scene);

/// min(H, 1/k) of every body, H the least extent of the fluid [m].
template <int D>
std::vector<double> moved_depths(const Case& scene, const FluidWeight& weight);

std::string describe(const AddedMass& added_mass);

}  // namespace tern::coupler
