#include "coupler/stability/surface_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scene/geometry.hpp"

namespace tern::coupler {
namespace {

/// Factor by which the area of a point may change from one window to the next: `resting_stretch` where the body moves as a whole, more by
/// `stretch_by_way` times the ways that its points go beyond that over the width of the point, and `largest_stretch` at the most. To
/// stretch a face by an eighth, its ends have to part by an eighth of its width.
constexpr double resting_stretch = 1.25, stretch_by_way = 4, largest_stretch = 10;
/// Cosine between a normal and the way out of the body, or the normal of the window before. It is -1 for a normal that points inward, 0
/// for a point within a sheet.
constexpr double least_cosine = -0.5;
/// Of the mass of a particle.
constexpr double mass_tolerance = 0.1;
/// Area of a body's points over that of the surface that they stand on.
constexpr double least_area = 0.75, largest_area = 1 / least_area;

template <int D>
std::string written(const Vector<D>& v) {
  return fmt::format("({:.6g})", fmt::join(v.data(), v.data() + D, ", "));
}

template <int D>
Bounds<D> bounds_of(const Case& scene) {
  Bounds<D> bounds;
  for (int d = 0; d < D; ++d) bounds.min[d] = scene.domain_min[d], bounds.max[d] = scene.domain_max[d];
  for (const StructureBody& body : scene.structure->bodies) {
    const Bounds<D> own = bounding_box<D>(body.shape);
    bounds.min = bounds.min.cwiseMin(own.min);
    bounds.max = bounds.max.cwiseMax(own.max);
  }
  return bounds;
}

/// Every so many one of `count`, so that no more than `most` are looked at.
std::size_t stride(std::size_t count, std::size_t most) { return std::max<std::size_t>(1, count / most); }

/// Of the surface of a body's shape, what has one of these points beside it that looks the same way: no farther than the points are from
/// each other [m^(D-1)]. In parts of it, where these are many.
template <int D>
double area_beside(const StructureBody& body, const Surface<D>& surface, const std::vector<std::size_t>& points) {
  constexpr double same_way = 0.5;
  constexpr std::size_t most = 500;
  const auto nearest2 = [&](const Vector<D>& x, const Vector<D>& normal) {  // squared, of those that look the same way
    double nearest = std::numeric_limits<double>::infinity();
    for (const std::size_t k : points)
      if (const double here = (surface.position[k] - x).squaredNorm();
          here > 0 && here < nearest && surface.normal[k].dot(normal) > same_way)
        nearest = here;
    return nearest;
  };
  double reach2 = 0;
  for (std::size_t n = 0; n < points.size(); n += stride(points.size(), most))
    reach2 = std::max(reach2, nearest2(surface.position[points[n]], surface.normal[points[n]]));
  const SurfacePoints<D> shape = sample_surface<D>(body.shape, body.spacing);
  const std::size_t every = stride(shape.area.size(), 4 * most);
  double beside = 0, looked_at = 0, all = 0;
  for (const double area : shape.area) all += area;
  for (std::size_t k = 0; k < shape.area.size(); k += every) {
    looked_at += shape.area[k];
    if (nearest2(shape.position[k] + 1e-9 * body.spacing * shape.normal[k], shape.normal[k]) <= reach2) beside += shape.area[k];
  }
  return all * beside / looked_at;
}

}  // namespace

template <int D>
SurfaceCheck<D>::SurfaceCheck(const Case& scene, const SurfaceProperties& properties, bool from_start, bool own)
    : bodies_(scene.structure->bodies),
      body_(properties.body),
      density_(scene.fluid->density),
      scene_(bounds_of<D>(scene)),
      margin_(Vector<D>::Constant((scene_.max - scene_.min).norm())),
      moves_as_sent_(scene.coupling.algorithm != CouplingAlgorithm::explicit_staggering),
      first_(from_start),
      own_(own),
      motion_(properties, margin_[0], from_start) {
  for (int d = 0; d < D; ++d)
    if (scene.periodic[d]) margin_[d] = std::numeric_limits<double>::infinity();
}

template <int D>
std::string SurfaceCheck<D>::surface(Ticks ticks, const Surface<D>& surface) {
  duration_ = seconds(ticks);
  std::string fault = first_ ? first(duration_, surface) : std::string();
  first_ = false;
  if (fault.empty()) fault = far(surface.position);
  if (fault.empty()) fault = fast(duration_, surface.velocity);
  if (fault.empty() && !area_.empty()) fault = stretched(surface);
  for (std::size_t k = 0; fault.empty() && k < normal_.size(); ++k)
    if (const double cosine = surface.normal[k].dot(normal_[k]); cosine < least_cosine)
      fault = fmt::format(
          "normal[{}] = {} has turned round since the window before, when it was {} (its cosine with that is {:.3g}; it must "
          "be {:g} or more)",
          k, written<D>(surface.normal[k]), written<D>(normal_[k]), cosine, least_cosine);
  position_ = surface.position;
  area_ = surface.area;
  normal_ = surface.normal;
  if (fault.empty() && moves_as_sent_) fault = motion_.surface(duration_, surface);
  return fault;
}

template <int D>
std::string SurfaceCheck<D>::stretched(const Surface<D>& surface) const {
  std::vector<Vector<D>> mean(bodies_.size(), Vector<D>::Zero());
  std::vector<double> points(bodies_.size(), 0), way(bodies_.size(), 0);  // of each body
  for (std::size_t k = 0; k < area_.size(); ++k) mean[body_[k]] += surface.position[k] - position_[k], ++points[body_[k]];
  for (std::size_t k = 0; k < area_.size(); ++k)
    way[body_[k]] = std::max(way[body_[k]], (surface.position[k] - position_[k] - mean[body_[k]] / points[body_[k]]).norm());
  for (std::size_t k = 0; k < area_.size(); ++k) {
    const double width = std::pow(std::min(area_[k], surface.area[k]), 1.0 / (D - 1)), stretch = surface.area[k] / area_[k];
    const double most = std::min(largest_stretch, resting_stretch + stretch_by_way * way[body_[k]] / width);
    if (stretch > most || stretch < 1 / most)
      return fmt::format(
          "area[{}] is {:.6g}, {:.3g} times what it was in the window before; for the way that the points of its body have gone against "
          "each other ({:.3g} m) it must be between {:.3g} and {:.3g} times that",
          k, surface.area[k], stretch, way[body_[k]], 1 / most, most);
  }
  return {};
}

template <int D>
std::string SurfaceCheck<D>::answer(const SurfaceLoad<D>& load, const std::vector<Vector<D>>& velocity) {
  if (moves_as_sent_) motion_.answer(load, velocity);
  return fast(duration_, velocity);
}

template <int D>
std::string SurfaceCheck<D>::particles(Ticks ticks, const InterfaceParticles<D>& particles) const {
  std::string fault = far(particles.position);
  if (fault.empty()) fault = fast(seconds(ticks), particles.velocity);
  for (std::size_t i = 0; fault.empty() && i < particles.mass.size(); ++i) {
    const double whole = density_ * particles.volume[i];
    if (std::abs(particles.mass[i] - whole) > mass_tolerance * whole)
      fault = fmt::format("mass[{}] is {:.6g} kg/m^{}; with its volume and the density of the case ({:.6g} kg/m^3) it must be {:.6g}", i,
                          particles.mass[i], 3 - D, density_, whole);
  }
  return fault;
}

template <int D>
std::string SurfaceCheck<D>::first(double duration, const Surface<D>& surface) const {
  Surface<D> start = surface;  // half a window before
  for (std::size_t k = 0; k < body_.size(); ++k) start.position[k] -= 0.5 * duration * surface.velocity[k];
  for (std::size_t k = 0; k < body_.size(); ++k) {
    const StructureBody& body = bodies_[body_[k]];
    const Vector<D>& x = start.position[k];
    const Vector<D>& n = start.normal[k];
    // Faces of elements or particles stand for the shape to a spacing, and a surface may be that of the begin.
    const double distance = signed_distance<D>(body.shape, x), limit = body.spacing + duration * start.velocity[k].norm();
    if (std::abs(distance) > limit)
      return fmt::format("position[{}] = {} is {:.3g} m {} the shape of the body '{}'; at the start it must lie on it to {:.3g} m", k,
                         written<D>(surface.position[k]), std::abs(distance), distance > 0 ? "outside" : "inside", body.name, limit);
    const double step = 0.01 * body.spacing;
    const Vector<D> out = x + step * n, in = x - step * n;
    const double cosine = (signed_distance<D>(body.shape, out) - signed_distance<D>(body.shape, in)) / (2 * step);
    if (cosine < least_cosine)
      return fmt::format("normal[{}] = {} points into the body '{}' (its cosine with the way out is {:.3g}; it must be {:g} or more)", k,
                         written<D>(n), body.name, cosine, least_cosine);
  }
  std::string fault;
  for (std::size_t b = 0; fault.empty() && !own_ && b < bodies_.size(); ++b) fault = wrong_areas(b, start);
  return fault;
}

template <int D>
std::string SurfaceCheck<D>::wrong_areas(std::size_t body, const Surface<D>& surface) const {
  std::vector<std::size_t> points;
  double area = 0;
  for (std::size_t k = 0; k < body_.size(); ++k)
    if (body_[k] == body) points.push_back(k), area += surface.area[k];
  if (points.empty()) return {};  // nothing of it can be wet
  const double beside = area_beside<D>(bodies_[body], surface, points);
  if (area >= least_area * beside && area <= largest_area * beside) return {};
  return fmt::format(
      "the sum of area over the body '{}' is {:.3g}; it must be between {:.3g} and {:.3g}, by the surface of its shape beside them",
      bodies_[body].name, area, least_area * beside, largest_area * beside);
}

template <int D>
std::string SurfaceCheck<D>::far(const std::vector<Vector<D>>& position) const {
  for (std::size_t k = 0; k < position.size(); ++k)
    if (((scene_.min - position[k]).array() > margin_.array()).any() || ((position[k] - scene_.max).array() > margin_.array()).any())
      return fmt::format("position[{}] = {} is farther from the scene than its diagonal of {:.3g} m", k, written<D>(position[k]),
                         (scene_.max - scene_.min).norm());
  return {};
}

template <int D>
std::string SurfaceCheck<D>::fast(double duration, const std::vector<Vector<D>>& velocity) const {
  const double limit = (scene_.max - scene_.min).norm() / duration;
  for (std::size_t k = 0; k < velocity.size(); ++k)
    if (!(velocity[k].norm() <= limit))
      return fmt::format("velocity[{}] = {} is {:.3g} m/s; with {:.3g} m/s it would cross the scene in one window", k,
                         written<D>(velocity[k]), velocity[k].norm(), limit);
  return {};
}

template class SurfaceCheck<2>;
template class SurfaceCheck<3>;

}  // namespace tern::coupler
