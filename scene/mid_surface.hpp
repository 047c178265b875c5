#pragma once
// The mid-surface of a thin body that is modelled as a shell, and its particles.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "scene/case_file.hpp"
#include "scene/geometry.hpp"
#include "scene/plane_polygon.hpp"

namespace tern {

/// How an edge is held: a hinge holds the place, a clamp the slope as well.
enum class EdgeKind { free, hinge, clamp };

/// A place on a mid-surface.
template <int D>
struct SurfacePlace {
  Vector<D> position;
  Matrix<D> frame;  ///< columns: the directions of the coordinates, then the normal
};

/// A rectangle of its coordinates s, which are lengths along it, laid into space: flat; rolled up about the axis of a circle or of a tube,
/// where the last coordinate goes round; or along a path in the plane. Of a plate only what is inside its outline. A ball has no such
/// coordinates, but the corners of an icosahedron and of the triangles into which its faces are cut (cells_of()).
template <int D>
struct MidSurface {
  enum class Kind { flat, plate, round, path, ball } kind = Kind::flat;
  double thickness = 0;                                ///< [m]
  std::array<double, D - 1> low{}, high{};             ///< of s, between its clamps; plate: of the outline [m]
  std::array<std::array<EdgeKind, 2>, D - 1> edges{};  ///< at both ends of each coordinate; plate: where the outline reaches it
  std::array<int, D - 1> count{};                      ///< free particles along each coordinate; ball: round it; plate: of its lattice
  std::array<bool, D - 1> closed{};                    ///< the end of a coordinate is its beginning
  Vector<D> origin = Vector<D>::Zero();                ///< flat, plate: where s = 0; round, ball: the centre, of a tube where it begins
  Matrix<D> axes = Matrix<D>::Identity();  ///< flat, plate: directions of s, then the normal; round: axis, and where angles are 0
  double radius = 0, begin = 0;            ///< round, ball: its radius [m]; round: its angle where s = 0
  int parts = 0;                           ///< ball: into which each edge of the icosahedron is cut
  std::vector<Vector<D>> corners;          ///< path: closed, the last is the first again
  std::vector<double> corner_at;           ///< their s [m]
  Outline outline;                         ///< plate: in s, anticlockwise about the normal
  std::vector<EdgeKind> sides;             ///< plate: of the side from each corner of the outline to the next
  double reach = 0;                        ///< path: its direction is that from `reach` before to `reach` after a place [m]

  /// Not of a ball.
  SurfacePlace<D> at(const std::array<double, D - 1>& s) const;
  /// The place on it that is nearest to x.
  Vector<D> foot(const Vector<D>& x) const;
  /// Distance of x from it [m].
  double height(const Vector<D>& x) const { return (x - foot(x)).norm(); }

  double length(int n) const { return high[n] - low[n]; }
  int held_ends(int n) const { return (edges[n][0] != EdgeKind::free) + (edges[n][1] != EdgeKind::free); }
  /// The first free particle is a whole spacing from a held edge, half a spacing from a free one [m]. On a ball: from a particle to the six
  /// beside it, in the mean.
  double spacing(int n) const {
    if (kind == Kind::ball) return radius * std::sqrt(8 * std::numbers::pi / (std::numbers::sqrt3 * (10.0 * parts * parts + 2)));
    return length(n) / (count[n] + 0.5 * held_ends(n));
  }
};

/// Whether particles have neighbours by rows: those of a plate have them where a straight line in it leads, on a ball they are all.
template <int D>
bool is_in_rows(const MidSurface<D>& surface) {
  return surface.kind != MidSurface<D>::Kind::ball && surface.kind != MidSurface<D>::Kind::plate;
}

/// Throws BadInput where the body cannot be modelled as a shell: of another shape, with a sharp corner, held by clamps that do not end at a
/// whole edge, or by hinges that do not hold one.
template <int D>
MidSurface<D> mid_surface(const StructureBody& body);

/// The cell of a particle on a mid-surface.
template <int D>
struct SurfaceCell {
  SurfacePlace<D> place;
  double area;    ///< half of a cell on a held edge; 2D: a hinge has none [m^(D-1)]
  EdgeKind edge;  ///< that the particle stands on; where two meet, a clamp comes before a hinge
};

/// The first coordinate runs fastest. On a plate those of its held sides come first, evenly along them; then what of a lattice is inside,
/// but for places nearer to a held side than half a spacing. Each has the part of the plate that is nearer to it than to the others; a free
/// particle with less than a quarter of a spacing squared is left out. On a ball the corners of triangles: nearly even everywhere, six
/// of them beside each but the twelve of the icosahedron, which have five. Each has a third of the triangles around it.
template <int D>
std::vector<SurfaceCell<D>> cells_of(const MidSurface<D>& surface);

/// How well one layer of particles stands for a body.
struct ShellFit {
  double length = 0, thickness = 0;  ///< of the free length in the direction that fits worst [m]
  std::string held;                  ///< in words: how its ends in that direction are held
  int count = 0;                     ///< free particles along it
  double without_shear = 0;          ///< share of its deflection under a uniform load that is missing without transverse shear
  double by_spacing = 0;             ///< share of its deflection that the spacing adds, about; negative: takes away
  double wanted_particles = 0;       ///< along it, for a spacing that adds 1.5 %
};
inline constexpr double most_without_shear = 0.02;  ///< a body with more is better a solid

/// Throws as mid_surface() does. Of the direction with the largest error of both kinds.
template <int D>
ShellFit shell_fit(const StructureBody& body);

/// The particles of a body. Those of a shell are one layer on its mid-surface: the held ones stand on its held edges. Throws as
/// mid_surface() does.
template <int D>
LatticePoints<D> fill_body(const StructureBody& body);

/// Longest side [m] of what no clamp holds: of a solid the box around its free particles with their half spacings, of a shell its
/// mid-surface between clamps; a quarter of the way round a ring, half a wave of its first motion. Throws as mid_surface() does.
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

}  // namespace tern
