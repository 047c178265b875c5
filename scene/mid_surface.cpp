#include "scene/mid_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace tern {

double thickness_of_box(const Shape& shape, int dimension) {
  double least = shape.max[0] - shape.min[0];
  for (int d = 1; d < dimension; ++d) least = std::min(least, shape.max[d] - shape.min[d]);
  return least;
}

template <int D>
MidSurface<D> mid_surface(const StructureBody& body) {
  const Shape& shape = body.shape;
  if (shape.kind != Shape::Kind::box)
    throw BadInput(
        fmt::format("The shell '{}' is not a box; only a box has a mid-surface here. Make it one, or model it as a solid.", body.name));
  MidSurface<D> surface;
  surface.thickness = thickness_of_box(shape, D);
  while (shape.max[surface.across] - shape.min[surface.across] > surface.thickness) ++surface.across;
  surface.middle = 0.5 * (shape.min[surface.across] + shape.max[surface.across]);
  for (int d = 0, n = 0; d < D; ++d)
    if (d != surface.across) surface.along[n++] = d;
  for (int n = 0; n < D - 1; ++n) {
    surface.low[n] = shape.min[surface.along[n]];
    surface.high[n] = shape.max[surface.along[n]];
  }
  for (const Shape& clamp : body.clamps) {
    int ends = 0, end = 0, direction = 0;
    const int across = surface.across;
    bool is_whole = clamp.kind == Shape::Kind::box && clamp.min[across] <= shape.min[across] && clamp.max[across] >= shape.max[across];
    for (int n = 0; n < D - 1 && is_whole; ++n) {
      const int d = surface.along[n];
      const bool low = clamp.min[d] <= shape.min[d], high = clamp.max[d] >= shape.max[d];
      if (low && high) continue;
      is_whole = low ? clamp.max[d] >= shape.min[d] : high && clamp.min[d] <= shape.max[d];
      ++ends;
      direction = n;
      end = low ? 0 : 1;
    }
    if (!is_whole || ends != 1)
      throw BadInput(
          fmt::format("The shell '{}' is held by a clamp that is not a box over one whole edge; let it reach across the thickness "
                      "and beyond both ends of the edge, or model the body as a solid.",
                      body.name));
    const int d = surface.along[direction];
    surface.clamped[direction][end] = true;
    if (end == 0)
      surface.low[direction] = std::max(surface.low[direction], clamp.max[d]);
    else
      surface.high[direction] = std::min(surface.high[direction], clamp.min[d]);
  }
  for (int n = 0; n < D - 1; ++n) {
    const double length = surface.high[n] - surface.low[n], held = 0.5 * (surface.clamped[n][0] + surface.clamped[n][1]);
    surface.count[n] = static_cast<int>(std::lround(length / body.spacing - held));
    if (surface.count[n] < 4)
      throw BadInput(
          fmt::format("The shell '{}' has {} free particles over {:.3g} m in direction {}, but needs at least 4 (15 for an error of "
                      "6 % in bending); use a spacing of at most {:.3g} m.",
                      body.name, std::max(surface.count[n], 0), length, "xyz"[surface.along[n]], std::max(length, 0.0) / (4 + held)));
  }
  return surface;
}

// Of a strip of length L under a uniform load, with the rigidity E' t^3/12 and the shear stiffness 5/6 G t: deflection by shear over that
// by bending is E'/G (t/L)^2 times 0.4 at the end of a cantilever, 4.8 halfway between two clamps, 0.96 halfway between two supports.
template <int D>
ShellFit shell_fit(const StructureBody& body) {
  const MidSurface<D> surface = mid_surface<D>(body);
  const double nu = body.poisson_ratio, modulus_over_shear = D == 2 && body.plane_stress ? 2 * (1 + nu) : 2 / (1 - nu);
  ShellFit worst;
  for (int n = 0; n < D - 1; ++n) {
    ShellFit fit;
    fit.thickness = surface.thickness;
    fit.length = surface.high[n] - surface.low[n];
    fit.clamped_ends = surface.clamped[n][0] + surface.clamped[n][1];
    fit.count = surface.count[n];
    constexpr double shear[] = {0.96, 4.8, 0.4};  // free at both ends, clamped at both, clamped at one
    constexpr double spacing[] = {0.4, 13, 0.4};  // measured, times the squared number of particles
    const int kind = fit.clamped_ends == 2 ? 1 : fit.clamped_ends == 1 ? 2 : 0;
    fit.without_shear = shear[kind] * modulus_over_shear * std::pow(fit.thickness / fit.length, 2);
    fit.by_spacing = spacing[kind] / std::pow(fit.count, 2);
    if (n == 0 || fit.without_shear + fit.by_spacing > worst.without_shear + worst.by_spacing) worst = fit;
  }
  return worst;
}

template <int D>
LatticePoints<D> fill_body(const StructureBody& body) {
  if (!body.is_shell) return fill_lattice<D>(body.shape, body.spacing);
  const MidSurface<D> surface = mid_surface<D>(body);
  Vector<D> low, step;
  std::array<long, 3> count{1, 1, 1};
  low[surface.across] = body.shape.min[surface.across];
  step[surface.across] = surface.thickness;
  for (int n = 0; n < D - 1; ++n) {
    const int d = surface.along[n], held = surface.clamped[n][0] + surface.clamped[n][1];
    step[d] = (surface.high[n] - surface.low[n]) / (surface.count[n] + 0.5 * held);
    low[d] = surface.low[n] - (surface.clamped[n][0] ? 0.5 * step[d] : 0);
    count[d] = surface.count[n] + held;
  }
  LatticePoints<D> points(low, step);
  for (long k = 0; k < count[2]; ++k)
    for (long j = 0; j < count[1]; ++j) points.add({{0, j, k}, count[0]});
  return points;
}

template <int D>
double free_length(const StructureBody& body) {
  double longest = 0;
  if (body.is_shell) {
    const MidSurface<D> surface = mid_surface<D>(body);
    for (int n = 0; n < D - 1; ++n) longest = std::max(longest, surface.high[n] - surface.low[n]);
    return longest;
  }
  const Vector<D> half = Vector<D>::Constant(0.5 * body.spacing);
  Vector<D> low = Vector<D>::Constant(1e300), high = -low;
  for (const Vector<D>& x : fill_lattice<D>(body.shape, body.spacing)) {
    if (std::any_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& clamp) { return contains<D>(clamp, x); })) continue;
    low = low.cwiseMin(x - half), high = high.cwiseMax(x + half);
  }
  return (high - low).maxCoeff();
}

#define TERN_INSTANTIATE(D)                                     \
  template MidSurface<D> mid_surface<D>(const StructureBody&);  \
  template ShellFit shell_fit<D>(const StructureBody&);         \
  template LatticePoints<D> fill_body<D>(const StructureBody&); \
  template double free_length<D>(const StructureBody&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern
