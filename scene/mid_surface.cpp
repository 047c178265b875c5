#include "scene/mid_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace tern {
namespace {

constexpr double round_off = 1e-6;  // of the spacing

/// The mid-surface of a box, halfway through its shortest side, without what holds it.
template <int D>
MidSurface<D> middle_of_box(const Shape& shape) {
  int across = 0;
  for (int d = 1; d < D; ++d)
    if (shape.max[d] - shape.min[d] < shape.max[across] - shape.min[across]) across = d;
  MidSurface<D> surface;
  surface.thickness = shape.max[across] - shape.min[across];
  surface.origin[across] = 0.5 * (shape.min[across] + shape.max[across]);
  surface.axes.setZero();
  for (int d = 0, n = 0; d < D; ++d) {
    if (d == across) continue;
    surface.low[n] = shape.min[d];
    surface.high[n] = shape.max[d];
    surface.axes(d, n++) = 1;
  }
  if constexpr (D == 2)
    surface.axes.col(1) << -surface.axes(1, 0), surface.axes(0, 0);
  else
    surface.axes.col(2) = surface.axes.col(0).cross(surface.axes.col(1));
  return surface;
}

/// Which coordinate an axis of the box is.
template <int D>
int axis_of(const MidSurface<D>& surface, int n) {
  int axis = 0;
  surface.axes.col(n).cwiseAbs().maxCoeff(&axis);
  return axis;
}

/// Ends the free part of a box at the face of a clamp.
template <int D>
void clamp_box(const StructureBody& body, const Shape& clamp, MidSurface<D>& surface) {
  const Shape& shape = body.shape;
  int ends = 0, end = 0, direction = 0;
  const int across = axis_of(surface, D - 1);
  bool is_whole = clamp.kind == Shape::Kind::box && clamp.min[across] <= shape.min[across] && clamp.max[across] >= shape.max[across];
  for (int n = 0; n < D - 1 && is_whole; ++n) {
    const int d = axis_of(surface, n);
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
  const int d = axis_of(surface, direction);
  surface.edges[direction][end] = EdgeKind::clamp;
  if (end == 0)
    surface.low[direction] = std::max(surface.low[direction], clamp.max[d]);
  else
    surface.high[direction] = std::min(surface.high[direction], clamp.min[d]);
}

/// Places on the line across the mid-surface where coordinate n has this value.
template <int D>
std::vector<Vector<D>> line_across(const MidSurface<D>& surface, int n, double value) {
  constexpr int pieces = 64;
  std::vector<Vector<D>> line;
  std::array<double, D - 1> s{};
  s[n] = value;
  for (int k = 0; k <= (D == 2 ? 0 : pieces); ++k) {
    const int other = D - 2 - n;
    if constexpr (D == 3) s[other] = surface.low[other] + k * surface.length(other) / pieces;
    line.push_back(surface.at(s).position);
  }
  return line;
}

/// Marks the edge that a hinge holds.
template <int D>
void hinge(const StructureBody& body, const Shape& region, MidSurface<D>& surface) {
  const auto holds = [&](const Vector<D>& x) { return signed_distance<D>(region, x) <= round_off * body.spacing; };
  int found = 0;
  for (int n = 0; n < D - 1; ++n)
    for (int end = 0; end < 2; ++end) {
      const double edge = end == 0 ? surface.low[n] : surface.high[n], inwards = end == 0 ? 1 : -1;
      const auto line = line_across(surface, n, edge);
      if (!std::all_of(line.begin(), line.end(), holds)) continue;
      ++found;
      const auto inner = line_across(surface, n, edge + inwards * surface.thickness * (1 + round_off));
      const bool deep = std::any_of(inner.begin() + (D == 3), inner.end() - (D == 3), holds);
      if (deep)
        throw BadInput(
            fmt::format("The shell '{}' has a hinge that reaches farther into it than its thickness, {:.3g} m; a hinge holds an edge only: "
                        "make it smaller, or a clamp.",
                        body.name, surface.thickness));
      EdgeKind& kind = surface.edges[n][end];
      kind = std::max(kind, EdgeKind::hinge);
    }
  if (found != 1)
    throw BadInput(fmt::format(
        "The shell '{}' has a hinge that holds {} of its edges as a whole; each hinge has to contain one edge of the mid-surface, "
        "from corner to corner.",
        body.name, found == 0 ? "none" : "several"));
}

}  // namespace

template <int D>
SurfacePlace<D> MidSurface<D>::at(const std::array<double, D - 1>& s) const {
  SurfacePlace<D> place{origin, axes};
  for (int n = 0; n < D - 1; ++n) place.position += s[n] * axes.col(n);
  return place;
}

template <int D>
double MidSurface<D>::height(const Vector<D>& x) const {
  return (x - origin).dot(axes.col(D - 1));
}

template <int D>
MidSurface<D> mid_surface(const StructureBody& body) {
  if (body.shape.kind != Shape::Kind::box)
    throw BadInput(
        fmt::format("The shell '{}' is not a box; only a box has a mid-surface here. Make it one, or model it as a solid.", body.name));
  MidSurface<D> surface = middle_of_box<D>(body.shape);
  for (const Shape& clamp : body.rigid_clamps()) clamp_box(body, clamp, surface);
  for (const Shape& region : body.hinges) hinge(body, region, surface);
  for (int n = 0; n < D - 1; ++n) {
    const double held = 0.5 * surface.held_ends(n);
    surface.count[n] = static_cast<int>(std::lround(surface.length(n) / body.spacing - held));
    if (surface.count[n] < 4)
      throw BadInput(
          fmt::format("The shell '{}' has {} free particles over {:.3g} m in direction {}, but needs at least 4 (15 for an error of "
                      "6 % in bending); use a spacing of at most {:.3g} m.",
                      body.name, std::max(surface.count[n], 0), surface.length(n), "xyz"[axis_of(surface, n)],
                      std::max(surface.length(n), 0.0) / (4 + held)));
  }
  return surface;
}

template <int D>
std::vector<SurfaceCell<D>> cells_of(const MidSurface<D>& surface) {
  std::array<int, 2> size{1, 1};
  for (int a = 0; a < D - 1; ++a) size[a] = surface.count[a] + surface.held_ends(a);
  std::vector<SurfaceCell<D>> cells;
  for (int n = 0; n < size[0] * size[1]; ++n) {
    const std::array<int, 2> index{n % size[0], n / size[0]};
    std::array<double, D - 1> s{};
    SurfaceCell<D> cell{{}, 1, EdgeKind::free};
    for (int a = 0; a < D - 1; ++a) {
      s[a] = surface.low[a] + (index[a] + (surface.edges[a][0] == EdgeKind::free ? 0.5 : 0)) * surface.spacing(a);
      cell.area *= surface.spacing(a);
      const int end = index[a] == 0 ? 0 : index[a] == size[a] - 1 ? 1 : -1;
      if (end < 0 || surface.edges[a][end] == EdgeKind::free) continue;
      cell.area *= 0.5;
      cell.edge = std::max(cell.edge, surface.edges[a][end]);
    }
    if (D == 2 && cell.edge == EdgeKind::hinge) cell.area = 0;
    cell.place = surface.at(s);
    cells.push_back(cell);
  }
  return cells;
}

namespace {

/// What is known of a strip by how its ends are held.
struct StripKind {
  const char* held;
  double shear;    ///< deflection by shear over that by bending, in E'/G (t/L)^2
  double spacing;  ///< deflection that the spacing adds, times the squared number of particles; measured
};

// Of a strip of length L under a uniform load, with the rigidity E' t^3/12 and the shear stiffness 5/6 G t, at the end of a cantilever or
// where it sags most. A strip that is free at one end, or both, and not clamped at the other bends as between supports.
StripKind strip_kind(const std::array<EdgeKind, 2>& edges) {
  const int clamps = (edges[0] == EdgeKind::clamp) + (edges[1] == EdgeKind::clamp);
  const int hinges = (edges[0] == EdgeKind::hinge) + (edges[1] == EdgeKind::hinge);
  if (clamps == 2) return {"between two clamps", 4.8, 13};
  if (clamps == 1 && hinges == 1) return {"between a clamp and a hinge", 2.65, 5};
  if (clamps == 1) return {"from its clamp on", 0.4, 0.4};
  if (hinges == 2) return {"between two hinges", 0.96, 2};
  return {hinges == 1 ? "from its hinge on" : "from edge to edge", 0.96, 0.4};
}

}  // namespace

template <int D>
ShellFit shell_fit(const StructureBody& body) {
  const MidSurface<D> surface = mid_surface<D>(body);
  const double nu = body.poisson_ratio, modulus_over_shear = D == 2 && body.plane_stress ? 2 * (1 + nu) : 2 / (1 - nu);
  ShellFit worst;
  for (int n = 0; n < D - 1; ++n) {
    const StripKind kind = strip_kind(surface.edges[n]);
    ShellFit fit;
    fit.thickness = surface.thickness;
    fit.length = surface.length(n);
    fit.held = kind.held;
    fit.count = surface.count[n];
    fit.without_shear = kind.shear * modulus_over_shear * std::pow(fit.thickness / fit.length, 2);
    fit.by_spacing = kind.spacing / std::pow(fit.count, 2);
    fit.wanted_particles = std::max(18.0, std::sqrt(kind.spacing / 0.015));
    if (n == 0 || fit.without_shear + fit.by_spacing > worst.without_shear + worst.by_spacing) worst = fit;
  }
  return worst;
}

template <int D>
LatticePoints<D> fill_body(const StructureBody& body) {
  if (!body.is_shell) return fill_lattice<D>(body.shape, body.spacing);
  LatticePoints<D> points(bounding_box<D>(body.shape).min, Vector<D>::Constant(body.spacing));
  for (const SurfaceCell<D>& cell : cells_of(mid_surface<D>(body))) points.add_off_lattice(cell.place.position);
  return points;
}

template <int D>
double free_length(const StructureBody& body) {
  double longest = 0;
  if (body.is_shell) {
    const MidSurface<D> surface = mid_surface<D>(body);
    for (int n = 0; n < D - 1; ++n) longest = std::max(longest, surface.length(n));
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

#define TERN_INSTANTIATE(D)                                               \
  template struct MidSurface<D>;                                          \
  template MidSurface<D> mid_surface<D>(const StructureBody&);            \
  template std::vector<SurfaceCell<D>> cells_of<D>(const MidSurface<D>&); \
  template ShellFit shell_fit<D>(const StructureBody&);                   \
  template LatticePoints<D> fill_body<D>(const StructureBody&);           \
  template double free_length<D>(const StructureBody&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern
