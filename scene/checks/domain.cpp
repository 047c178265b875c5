// The box of the fluid: set where the case gives none, and the directions in which it repeats itself.

#include "scene/checks/checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/scene_check.hpp"

namespace tern {

template <int D>
Shape swept_box(const WallCase& wall, double end_time) {
  constexpr int instants = 200;
  const Bounds<D> bounds = bounding_box<D>(wall.shape);
  Vector<D> low = bounds.min, high = bounds.max;
  for (int k = 0; k <= instants; ++k) {
    const Placement<D> place = placement<D>(wall, end_time * k / instants);
    for (int corner = 0; corner < (1 << D); ++corner) {
      Vector<D> x = bounds.min;
      for (int d = 0; d < D; ++d)
        if (corner & (1 << d)) x[d] = bounds.max[d];
      low = low.cwiseMin(place(x)), high = high.cwiseMax(place(x));
    }
  }
  Shape box;
  for (int d = 0; d < D; ++d) box.min[d] = low[d], box.max[d] = high[d];
  return box;
}

template <int D>
void set_default_domain(Case& scene, const Setting& settings) {
  if (settings.find("domain")) {
    for (const Setting& direction : settings.at("domain").at("periodic").items) {
      if (D == 2 && direction.text == "z") fail_at(direction.where, "there is no direction z in 2D that could be periodic; remove it.");
    }
    return;
  }
  std::vector<Shape> extent;
  for (const WallCase& wall : scene.walls) {
    extent.push_back(wall.shape);
    if (wall.motion) extent.push_back(swept_box<D>(wall, scene.end_time));
  }
  if (extent.empty()) {
    if (scene.fluid)
      for (const FluidBody& body : scene.fluid->bodies) extent.push_back(body.shape);
    if (scene.structure)
      for (const StructureBody& body : scene.structure->bodies) extent.push_back(body.shape);
  }
  Shape all;
  all.kind = Shape::Kind::union_of;
  all.parts = extent;
  const Bounds<D> bounds = bounding_box<D>(all);
  const double margin = 0.5 * (bounds.max - bounds.min).maxCoeff();
  for (int d = 0; d < D; ++d) {
    scene.domain_min[d] = bounds.min[d] - margin;
    scene.domain_max[d] = bounds.max[d] + margin;
  }
}

namespace {

bool rotates(const RigidMotion& motion) {
  return motion.table ? motion.table->rotates() : !(motion.rotation.is_constant() && motion.rotation(0) == 0);
}

// The fluid repeats itself in direction d: pairs have one nearest image, and walls have to repeat themselves as well.
template <int D>
void check_periodic(Case& scene, const Setting& settings, int d, const std::string& where) {
  const char axis = "xyz"[d];
  if (!scene.fluid) fail_at(where, "a periodic direction acts on the fluid only, but the case has no [fluid]; remove it.");
  if (scene.structure) {
    fail_at(where,
            "a periodic direction and [structure] exclude each other, because elastic bodies have no periodic images; "
            "remove one of them.");
  }
  const FluidCase& water = *scene.fluid;
  const double low = scene.domain_min[d], high = scene.domain_max[d], period = high - low;
  const double shortest = 4 * water.numerics.smoothing_length_ratio * water.spacing, slack = 1e-6 * water.spacing;
  if (period < shortest) {
    fail_at(where, fmt::format("the period in direction {} is {:.6g} m, but has to be at least two kernel supports, {:.6g} "
                               "m; enlarge [domain] or use a smaller fluid.spacing.",
                               axis, period, shortest));
  }
  const double count = period / water.spacing;
  if (std::abs(count - std::round(count)) > 1e-6 * count) {
    scene.warnings.push_back(
        fmt::format("{}: the period in direction {} is {:.6g} spacings, so a lattice that fills it does not fit; {:.9g} m would be "
                    "a whole number of spacings.",
                    where, axis, count, period / std::round(count)));
  }
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    WallCase& wall = scene.walls[i];
    const Bounds<D> bounds = bounding_box<D>(wall.shape);
    wall.continues[d] = wall.motion && wall.shape.kind == Shape::Kind::box && !rotates(*wall.motion) && bounds.min[d] <= low + slack &&
                        bounds.max[d] >= high - slack;
    const Shape swept = wall.motion ? swept_box<D>(wall, scene.end_time) : Shape{};
    if (wall.motion && (swept.min[d] < bounds.min[d] - slack || swept.max[d] > bounds.max[d] + slack)) {
      fail_at(settings.at("wall").items[i].where, fmt::format("the wall '{}' moves in the periodic direction {}, where it would leave its "
                                                              "period; let it move across that direction only, or be a box from end to "
                                                              "end of the period that does not turn.",
                                                              wall.name, axis));
    }
    if (bounds.min[d] < low - slack || bounds.max[d] > high + slack) {
      fail_at(settings.at("wall").items[i].where,
              fmt::format("the wall '{}' reaches from {:.6g} to {:.6g} m in the periodic direction {}, but the period goes "
                          "from {:.6g} to {:.6g} m; cut the wall there, its images continue it.",
                          wall.name, bounds.min[d], bounds.max[d], axis, low, high));
    }
    if (!wall.container || wall.shape.kind != Shape::Kind::box) continue;
    for (const char* end : {"_min", "_max"}) {
      const std::string face = axis + std::string(end);
      if (is_open(wall, face)) continue;
      fail_at(settings.at("wall").items[i].where,
              fmt::format("the container '{}' is closed at {}, but {} is a periodic direction; add \"{}\" to "
                          "its open faces.",
                          wall.name, face, axis, face));
    }
  }
}

}  // namespace

template <int D>
void check_domain(Case& scene, const Setting& settings) {
  const Setting* domain = settings.find("domain");
  if (!domain) return;
  for (int d = 0; d < D; ++d) {
    const double length = scene.domain_max[d] - scene.domain_min[d];
    if (length <= 0) {
      fail_at(domain->where, fmt::format("min {} is not less than max {} m of [domain] in direction {}; exchange them.",
                                         scene.domain_min[d], scene.domain_max[d], "xyz"[d]));
    }
    if (scene.periodic[d]) check_periodic<D>(scene, settings, d, domain->at("periodic").where);
  }
}

template Shape swept_box<2>(const WallCase&, double);
template Shape swept_box<3>(const WallCase&, double);
template void set_default_domain<2>(Case&, const Setting&);
template void set_default_domain<3>(Case&, const Setting&);
template void check_domain<2>(Case&, const Setting&);
template void check_domain<3>(Case&, const Setting&);

}  // namespace tern
