#include "scene/gravity.hpp"

#include <algorithm>

namespace tern {
namespace {

constexpr int instants = 200;             ///< in which gravity that changes in time is looked at
constexpr std::size_t samples = 1 << 20;  ///< of place and time, at most

}  // namespace

template <int D>
double largest_gravity(const Case& scene, const std::vector<Vector<D>>& places) {
  const auto depends_on = [&](char variable) {
    return std::any_of(scene.gravity.begin(), scene.gravity.end(), [&](const Expression& e) { return e.depends_on(variable); });
  };
  const int last = depends_on('t') ? instants : 0;
  const bool uniform = !depends_on('x') && !depends_on('y') && !depends_on('z');
  const std::size_t every =
      uniform ? std::max<std::size_t>(1, places.size()) : 1 + places.size() * static_cast<std::size_t>(last) / samples;
  double largest = 0;
  for (std::size_t i = 0; i < places.size(); i += every)
    for (int n = 0; n <= last; ++n) {
      const Vector<D>& x = places[i];
      Vector<D> g;
      for (int c = 0; c < D; ++c) g[c] = scene.gravity[c](n * scene.end_time / instants, x[0], x[1], D == 3 ? x[D - 1] : 0);
      largest = std::max(largest, g.norm());
    }
  return largest;
}

template double largest_gravity<2>(const Case&, const std::vector<Vector<2>>&);
template double largest_gravity<3>(const Case&, const std::vector<Vector<3>>&);

}  // namespace tern
