#pragma once
// The surface in lumps: parts of a body that are pushed and move as a whole. Lumps overlap: they are the hat functions of a lattice of
// some width in the body at the start, and the shares of a point are their values there. A point counts by half the width inside the
// body, or by half its section where that is less. So opposite faces of a plate that is thinner than the width have lumps in common, and
// those of a thick body have none.

#include <cstdint>
#include <span>
#include <vector>

#include "base/vector.hpp"
#include "proto/interface.hpp"

namespace tern::coupler {

/// A partition of unity: the shares of each point sum to 1.
struct SurfaceLumps {
  std::size_t per_point = 0, count = 0;
  std::vector<std::uint32_t> lump;  ///< per_point of each point, point by point
  std::vector<double> share;        ///< in each of these
};

/// How the surface is taken to answer in one window.
struct SurfaceAnswer {
  SurfaceLumps lumps;
  std::vector<double> mass;  ///< of each [kg/m^(3-D)]
  double gain = 1;           ///< how many times an error of the load may come back: the largest mass over the guessed one, at least 1
};

/// Where the points are at the start of the run.
template <int D>
struct SurfaceAtStart {
  std::vector<Vector<D>> position, normal;
  std::vector<double> area;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("position", all.position...);
    visit("normal", all.normal...);
    visit("area", all.area...);
  }
};

/// Every point its own lump.
SurfaceLumps lumps_of_points(std::size_t points);

/// Lumps of this width [m]; a point with `depth` 0 is its own, others count by `depth`, half a section, inside the body [m]. Bodies have
/// no lump in common.
template <int D>
SurfaceLumps lumps_of_width(double width, const SurfaceAtStart<D>& start, const std::vector<std::uint32_t>& body,
                            const std::vector<double>& depth);

/// Forces of points gathered by lumps, and the velocities that follow.
template <int D>
class LumpMotion {
 public:
  /// `mass`: of every lump [kg/m^(3-D)]; `duration`: of the push [s].
  LumpMotion(const SurfaceLumps& lumps, std::span<const double> mass, double duration)
      : lumps_(lumps), duration_(duration), quickness_(lumps.count), force_(lumps.count, Vector<D>::Zero()) {
    for (std::size_t a = 0; a < lumps.count; ++a) quickness_[a] = duration / mass[a];
  }

  void push(std::size_t k, const Vector<D>& force) {
    for (std::size_t s = k * lumps_.per_point; s < (k + 1) * lumps_.per_point; ++s) force_[lumps_.lump[s]] += lumps_.share[s] * force;
  }

  /// How much faster point k is by all pushes [m/s].
  Vector<D> velocity(std::size_t k) const {
    Vector<D> sum = Vector<D>::Zero();
    for (std::size_t s = k * lumps_.per_point; s < (k + 1) * lumps_.per_point; ++s)
      if (lumps_.share[s] > 0) sum += lumps_.share[s] * quickness_[lumps_.lump[s]] * force_[lumps_.lump[s]];
    return sum;
  }

  /// Mass with which point k answers a force on it alone [kg/m^(3-D)].
  double mass(std::size_t k) const {
    double inverse = 0;
    for (std::size_t s = k * lumps_.per_point; s < (k + 1) * lumps_.per_point; ++s)
      inverse += lumps_.share[s] * lumps_.share[s] * quickness_[lumps_.lump[s]];
    return duration_ / inverse;
  }

 private:
  const SurfaceLumps& lumps_;
  double duration_;
  std::vector<double> quickness_;  ///< of each lump: duration over mass [s/kg m^(D-3)]
  std::vector<Vector<D>> force_;
};

/// Mass of every lump, each point with `mass_per_area` behind its `area` [kg/m^(3-D)].
std::vector<double> lump_masses(const SurfaceLumps& lumps, const std::vector<double>& mass_per_area, const std::vector<double>& area);

}  // namespace tern::coupler
