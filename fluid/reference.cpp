#include "fluid/reference.hpp"

#include <algorithm>
#include <cmath>

#include "scene/estimate.hpp"
#include "scene/gravity.hpp"

namespace tern::fluid {

template <int D>
Gravity<D>::Gravity(const Case& scene)
    : expression_(scene.gravity), uniform_(std::all_of(scene.gravity.begin(), scene.gravity.end(), [](const Expression& e) {
        return !e.depends_on('x') && !e.depends_on('y') && !e.depends_on('z');
      })) {}

template <int D>
Vector<D> Gravity<D>::at(double t, const Vector<D>& x) const {
  Vector<D> g;
  for (int c = 0; c < D; ++c) g[c] = expression_[c](t, x[0], x[1], D == 3 ? x[D - 1] : 0);
  return g;
}

template <int D>
Reference<D>::Reference(const Case& scene, const StartParticles<D>& start)
    : constants(scene.fluid.value()), gravity(scene), period(scene), particles(start.size()), up(upward(scene)) {
  for (int c = 0; c < D; ++c) {
    domain_min[c] = scene.domain_min[c];
    domain_max[c] = scene.domain_max[c];
  }
  const auto for_each_place = [&](auto&& visit) { start.for_each(0, start.size(), [&](std::size_t, const Vector<D>& x) { visit(x); }); };
  std::vector<Vector<D>> places;  // where gravity may differ
  start.for_each(0, gravity.uniform() ? 1 : start.size(), [&](std::size_t, const Vector<D>& x) { places.push_back(x); });
  gravity_size = largest_gravity<D>(scene, places);
  window_at_rest = tern::window_at_rest(scene);
  window_at_rest_in_frame = tern::window_at_rest(scene, true);
  has_bodies = scene.structure.has_value();
  Vector<D> mean = Vector<D>::Zero(), low = places[0], high = low;
  for_each_place([&](const Vector<D>& x) {
    mean += x / static_cast<double>(start.size());
    low = low.cwiseMin(x), high = high.cwiseMax(x);
  });
  const Vector<D> g = gravity.at(0, mean);
  // Where gravity is not the same everywhere (about a centre, it vanishes in the middle), or sets in later, the widest extent counts.
  double height = (high - low).maxCoeff();
  if (gravity.uniform() && g.norm() > 0.5 * gravity_size) {
    double bottom = 1e300, top = -1e300;
    for_each_place([&](const Vector<D>& x) {
      const double along = -x.dot(g) / g.norm();
      bottom = std::min(bottom, along), top = std::max(top, along);
    });
    height = top - bottom;
  }
  if (gravity_size > 0) speed_floor = 0.5 * std::sqrt(gravity_size * (height + constants.spacing));
}

template class Gravity<2>;
template class Gravity<3>;
template struct Reference<2>;
template struct Reference<3>;

}  // namespace tern::fluid
