#include "coupler/stability/surface_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scene/geometry.hpp"

namespace tern::coupler {
namespace {

/// Factor by which the area of a point may change from one window to the next: an element that is stretched or squeezed tenfold in the
/// time in which the fluid moves by a part of its spacing does not exist.
constexpr double largest_stretch = 10;
/// Cosine between a normal and the way out of the body, or the normal of the window before. It is -1 for a normal that points inward, 0
/// for a point within a sheet.
constexpr double least_cosine = -0.5;
/// Area of a body's points over that of its shape. A surface may be a part of it, for example one face; units that are wrong are wrong by
/// a factor of 1000 or more.
constexpr double least_area = 0.01, largest_area = 2;

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

/// The surface of a body, and the part of it that no clamp holds [m^(D-1)].
template <int D>
std::pair<double, double> areas(const StructureBody& body) {
  const SurfacePoints<D> points = sample_surface<D>(body.shape, body.spacing);
  double all = 0, unheld = 0;
  for (std::size_t k = 0; k < points.area.size(); ++k) {
    all += points.area[k];
    if (std::none_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& c) { return contains<D>(c, points.position[k]); }))
      unheld += points.area[k];
  }
  return {all, unheld};
}

}  // namespace

template <int D>
SurfaceCheck<D>::SurfaceCheck(const Case& scene, const SurfaceProperties& properties, bool from_start)
    : bodies_(scene.structure->bodies),
      body_(properties.body),
      scene_(bounds_of<D>(scene)),
      margin_(Vector<D>::Constant((scene_.max - scene_.min).norm())),
      moves_as_sent_(scene.coupling.algorithm != CouplingAlgorithm::explicit_staggering),
      first_(from_start),
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
  for (std::size_t k = 0; fault.empty() && k < area_.size(); ++k) {
    const double stretch = surface.area[k] / area_[k];
    if (stretch > largest_stretch || stretch < 1 / largest_stretch)
      fault = fmt::format("area[{}] is {:.6g}, {:.3g} times what it was in the window before; it must be between {:g} and {:g} times that",
                          k, surface.area[k], stretch, 1 / largest_stretch, largest_stretch);
  }
  for (std::size_t k = 0; fault.empty() && k < normal_.size(); ++k)
    if (const double cosine = surface.normal[k].dot(normal_[k]); cosine < least_cosine)
      fault = fmt::format(
          "normal[{}] = {} has turned round since the window before, when it was {} (its cosine with that is {:.3g}; it must "
          "be {:g} or more)",
          k, written<D>(surface.normal[k]), written<D>(normal_[k]), cosine, least_cosine);
  area_ = surface.area;
  normal_ = surface.normal;
  if (fault.empty() && moves_as_sent_) fault = motion_.surface(duration_, surface);
  return fault;
}

template <int D>
std::string SurfaceCheck<D>::answer(const SurfaceLoad<D>& load, const std::vector<Vector<D>>& velocity) {
  if (moves_as_sent_) motion_.answer(load, velocity);
  return fast(duration_, velocity);
}

template <int D>
std::string SurfaceCheck<D>::particles(Ticks ticks, const InterfaceParticles<D>& particles) const {
  std::string fault = far(particles.position);
  return fault.empty() ? fast(seconds(ticks), particles.velocity) : fault;
}

template <int D>
std::string SurfaceCheck<D>::first(double duration, const Surface<D>& surface) const {
  std::vector<double> area(bodies_.size(), 0);
  for (std::size_t k = 0; k < body_.size(); ++k) {
    const StructureBody& body = bodies_[body_[k]];
    const Vector<D>& x = surface.position[k];
    const Vector<D>& n = surface.normal[k];
    area[body_[k]] += surface.area[k];
    // Half a window of motion, and faces of elements or particles that stand for the shape to a spacing.
    const double distance = signed_distance<D>(body.shape, x), limit = body.spacing + duration * surface.velocity[k].norm();
    if (std::abs(distance) > limit)
      return fmt::format("position[{}] = {} is {:.3g} m {} the shape of the body '{}'; at the start it must lie on it to {:.3g} m", k,
                         written<D>(x), std::abs(distance), distance > 0 ? "outside" : "inside", body.name, limit);
    const double step = 0.01 * body.spacing;
    const Vector<D> out = x + step * n, in = x - step * n;
    const double cosine = (signed_distance<D>(body.shape, out) - signed_distance<D>(body.shape, in)) / (2 * step);
    if (cosine < least_cosine)
      return fmt::format("normal[{}] = {} points into the body '{}' (its cosine with the way out is {:.3g}; it must be {:g} or more)", k,
                         written<D>(n), body.name, cosine, least_cosine);
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (area[b] == 0) continue;  // nothing of it can be wet
    const auto [all, unheld] = areas<D>(bodies_[b]);
    if (area[b] > largest_area * all || area[b] < least_area * unheld)
      return fmt::format("the sum of area over the body '{}' is {:.3g}; it must be between {:.3g} and {:.3g}, by the surface of its shape",
                         bodies_[b].name, area[b], least_area * unheld, largest_area * all);
  }
  return {};
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
