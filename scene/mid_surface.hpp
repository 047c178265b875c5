#pragma once
// The mid-surface of a thin body that is modelled as a shell: a box, halfway through its thinnest direction.

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/case_file.hpp"
#include "scene/geometry.hpp"

namespace tern {

template <int D>
struct MidSurface {
  int across = 0;                                    ///< direction of the thickness
  double thickness = 0, middle = 0;                  ///< [m]; where along `across` the mid-surface is
  std::array<int, D - 1> along{};                    ///< the other directions
  std::array<double, D - 1> low{}, high{};           ///< between its clamps [m]
  std::array<std::array<bool, 2>, D - 1> clamped{};  ///< at both ends of each direction
  std::array<int, D - 1> count{};                    ///< free particles along each direction at the body's spacing
};

/// Throws BadInput where the body cannot be modelled as a shell: other than a box, or held by clamps that do not end at a whole edge.
template <int D>
MidSurface<D> mid_surface(const StructureBody& body);

/// How well one layer of particles stands for a body.
struct ShellFit {
  double length = 0, thickness = 0;  ///< of the free length in the direction that fits worst [m]
  int clamped_ends = 0;              ///< of that direction
  int count = 0;                     ///< free particles along it
  double without_shear = 0;          ///< share of its deflection under a uniform load that is missing without transverse shear
  double by_spacing = 0;             ///< share of its deflection that the spacing adds, about
};
inline constexpr double most_without_shear = 0.02;  ///< a body with more is better a solid

/// Throws as mid_surface() does. Of the direction with the largest error of both kinds.
template <int D>
ShellFit shell_fit(const StructureBody& body);

/// The particles of a body. Those of a shell are one layer on its mid-surface: the held ones stand on the edges of its clamps, the first
/// free one a whole spacing from a held edge, half a spacing from a free one. Throws as mid_surface() does.
template <int D>
LatticePoints<D> fill_body(const StructureBody& body);

/// Longest side [m] of what no clamp holds: of a solid the box around its free particles with their half spacings, of a shell its
/// mid-surface between clamps. Throws as mid_surface() does.
template <int D>
double free_length(const StructureBody& body);

/// Speed of waves along a plate, sqrt(E'/rho), E' = E/(1 - nu^2), or E in plane stress [m/s].
inline double shell_wave_speed(const StructureBody& body) {
  const double nu = body.poisson_ratio;
  return std::sqrt(body.young_modulus / ((body.plane_stress ? 1 : 1 - nu * nu) * body.density));
}

/// Stable explicit step [s]: `courant` spacing/c for waves in the mid-surface, and 2.3 (2D) or 2 (3D) times courant spacing^2/(c t)
/// in bending.
/// Critical are 0.64 spacing/c, and 1.7 or 1.5 spacing^2/(c t).
template <int D>
double shell_sub_step(double courant, double spacing, double thickness, double wave_speed) {
  return courant * spacing / wave_speed * std::min(1.0, (D == 2 ? 7.0 / 3 : 2.0) * spacing / thickness);
}

/// The shortest side of a box [m].
double thickness_of_box(const Shape& shape, int dimension);

}  // namespace tern
