#pragma once
// What gauges read from the particles: pressure at points and on walls, elevation, flux, forces. It finds its own
// neighbours, so it costs nothing in steps without a row to write.

#include <optional>
#include <utility>
#include <vector>

#include "fluid/fluid.hpp"

namespace tern::fluid {

template <int D>
struct WallForce {
  Vector<D> force = Vector<D>::Zero();   ///< [N/m^(3-D)]
  Vector<3> moment = Vector<3>::Zero();  ///< [N m/m^(3-D)]; x and y are 0 in 2D
};

/// Where a probe finds the particles.
enum class Moment {
  end,    ///< where they are now
  middle  ///< where they were in the middle of the last window: with their pressure, and with walls and bodies as faces() has them
};

template <int D>
class Probe {
 public:
  /// Looks at the present state of `fluid`, which must outlive it.
  Probe(const Fluid<D>& fluid, Moment moment);
  Probe(const Probe&) = delete;
  Probe& operator=(const Probe&) = delete;

  /// Pressure at a point by a weighted linear fit; nothing where fewer than half a kernel of fluid is around [Pa].
  std::optional<double> pressure(const Vector<D>& x) const;

  /// Share of the kernel around x that is fluid, of the part that no wall or structure hides: 1 inside, 1/2 at the surface.
  double filling(const Vector<D>& x) const;

  /// Coordinate of the free surface on the vertical through x, along the axis of gravity (Upward), as a wire gauge measures it: the top of
  /// the lowest water, which ends where the filling passes 1/2, and on it the thickness of all water that flies above and of what is solid
  /// between; nothing where there is no fluid [m].
  std::optional<double> elevation(const Vector<D>& x) const;

  /// Volume flow through the line (2D) or the rectangle across an axis (3D) between two points [m^D/s]. Positive to the
  /// right of the way from `from` to `to` (2D), along the axis (3D).
  double flux(const Vector<D>& from, const Vector<D>& to) const;

  /// Mean pressure over a disc of `diameter` on the wall at the point that was at `at` at t = 0, with what contact takes from particles of
  /// the fluid there; 0 where it is dry, nothing where it is wet and there was no pressure solve yet [Pa].
  std::optional<double> sensor(const Wall<D>& wall, const Vector<D>& at, double diameter) const;

  /// Force of the fluid on the wall, by pressure, contact and friction, and its moment about the point of the wall that was at `at` at
  /// t = 0; nothing as for sensor().
  std::optional<WallForce<D>> force(const Wall<D>& wall, const Vector<D>& at) const;

  /// Largest x of the fluid, the thinnest sheet included, but not what has come off it: particles that no chain of neighbours joins to
  /// the bulk [m].
  double front() const;

 private:
  template <class Visit>
  void for_particles_around(const Vector<D>& x, Visit&& visit) const;
  /// A particle near a point x: the vector d from x to it, w = V w(|d|).
  struct Near {
    int i;
    Vector<D> d;
    double w;
  };
  /// Whether there may be particles within the support of x.
  bool any_around(const Vector<D>& x) const;
  /// The particles of the fluid that a wall sees from its point x; none where a body or another wall stands there.
  std::vector<Near> before_wall(const Vector<D>& x, const Vector<D>& normal) const;
  double hidden(const Vector<D>& x) const;
  double filling(const Vector<D>& x, double sum, const Vector<D>& centroid) const;
  /// On the wall at its point x, by the particles before it; 0 where there are none [Pa].
  double wall_pressure(const std::vector<Near>& before, const Vector<D>& x, const Vector<D>& normal, double normal_acceleration) const;
  /// Share of the patch before which nothing solid stands, and the middle of that part.
  std::pair<double, Vector<D>> open_part(const Faces<D>& faces, std::size_t k) const;
  /// Share of the wall that is wet, from 0 to 1, at a point with these particles and this space before it, a part of sum V w.
  double share_of_wall(const std::vector<Near>& before, double space) const;
  /// Before patch k of walls: what walls and bodies leave open of sum V w.
  double space_before(const Faces<D>& faces, std::size_t k) const;
  Vector<D> off_wall_at(const Vector<D>& x, const Vector<D>& normal) const;
  /// Calls visit(k, f) with the force f on patch k of this wall of each particle that contact with walls has stopped in the last window.
  /// `spray`: of single particles too.
  template <class Visit>
  void for_contacts(const Wall<D>& wall, bool spray, Visit&& visit) const;
  /// Of the fluid on the patch of a wall that it sticks to [N/m^(3-D)].
  Vector<D> friction(const std::vector<Near>& before, const Wall<D>& wall, const Faces<D>& faces, std::size_t k) const;
  /// A body of the structure stands at x, as far as its faces near there tell.
  bool covered(const Vector<D>& x) const;
  /// That, or an obstacle.
  bool obstructed(const Vector<D>& x) const;
  /// That, or x is outside the container.
  bool solid(const Vector<D>& x) const;

  const Fluid<D>& fluid_;
  double time_;                                               ///< of its moment [s]
  std::vector<Vector<D>> in_middle_;                          ///< [m]; of Moment::middle alone
  const std::vector<Vector<D>>& position_;                    ///< of the particles [m]
  std::vector<std::pair<const Wall<D>*, Shape>> containers_;  ///< where they are open they go on without end
  Vector<D> low_, high_;                                      ///< corners of the box around all particles
  CellGrid<D> grid_;
  CellContents contents_;
};

}  // namespace tern::fluid
