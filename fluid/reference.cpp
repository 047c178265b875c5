#include "fluid/reference.hpp"

#include <algorithm>
#include <cmath>

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
Reference<D>::Reference(const Case& scene, const std::vector<Vector<D>>& start)
    : constants(scene.fluid.value()), gravity(scene), period(scene), particles(start.size()), up(upward(scene)) {
  for (int c = 0; c < D; ++c) {
    domain_min[c] = scene.domain_min[c];
    domain_max[c] = scene.domain_max[c];
  }
  Vector<D> mean = Vector<D>::Zero();
  for (const auto& x : start) mean += x / static_cast<double>(start.size());
  const Vector<D> g = gravity.at(0, mean);
  gravity_size = g.norm();
  if (gravity_size > 0 && gravity.uniform()) {
    double low = 1e300, high = -1e300;
    for (const auto& x : start) {
      const double height = -x.dot(g) / gravity_size;
      low = std::min(low, height), high = std::max(high, height);
    }
    speed_floor = 0.5 * std::sqrt(gravity_size * (high - low + constants.spacing));
  }
  if (!gravity.uniform()) {
    // Of a field that varies (about a centre, it vanishes in the middle) the strongest place and the widest extent count.
    Vector<D> low = start[0], high = low;
    for (const auto& x : start) {
      gravity_size = std::max(gravity_size, gravity.at(0, x).norm());
      low = low.cwiseMin(x), high = high.cwiseMax(x);
    }
    speed_floor = 0.5 * std::sqrt(gravity_size * ((high - low).maxCoeff() + constants.spacing));
  }
}

template class Gravity<2>;
template class Gravity<3>;
template struct Reference<2>;
template struct Reference<3>;

}  // namespace tern::fluid
