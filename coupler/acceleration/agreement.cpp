#include "coupler/acceleration/agreement.hpp"

#include <algorithm>
#include <cmath>

namespace tern::coupler {
namespace {

constexpr double accepted_share = 0.1;  ///< of the change of velocity
constexpr double accepted_load = 0.03;  ///< of the load
/// Of the speed that the window is made for; a light body, which follows its load at once, and one that does not.
constexpr double least_of_light = 1e-5, least_of_heavy = 1e-3;

}  // namespace

template <int D>
Disagreement disagreement(const Setup<D>& setup, const State<D>& state, const Workspace<D>& window, const SurfaceLoad<D>& answer,
                          const std::vector<Vector<D>>& velocity) {
  struct Sums {
    double size = 0, change = 0, load = 0, area = 0;  // of squares, but for the area
  };
  const Surface<D>& surface = window.surface;
  LumpMotion<D> answered(window.answer.lumps, window.answer.mass, window.duration);
  for (std::size_t k = 0; k < surface.position.size(); ++k) answered.push(k, answer.force[k] - window.assumed_load.force[k]);
  std::vector<Sums> sums(setup.moved_mass.size());
  for (std::size_t k = 0; k < surface.position.size(); ++k) {
    if (window.share[k] == 0) continue;  // dry
    Sums& sum = sums[setup.properties.body[k]];
    const Vector<D>& n = surface.normal[k];
    const double a = surface.area[k], told = (surface.velocity[k] + answered.velocity(k)).dot(n);
    const double before = state.surface_velocity.empty() ? 0 : state.surface_velocity[k].dot(n);
    sum.size += a * std::pow(told - velocity[k].dot(n), 2);
    sum.change += a * std::pow(told - before, 2);
    sum.load += std::pow(answer.force[k].dot(n), 2) / a;
    sum.area += a;
  }
  Disagreement worst;
  for (std::size_t b = 0; b < sums.size(); ++b) {
    if (sums[b].area == 0) continue;  // dry
    const double of_load = accepted_load * window.duration / setup.moved_mass[b] * std::sqrt(sums[b].load);
    const double least =
        (setup.is_light[b] ? least_of_light : least_of_heavy) * setup.courant * setup.spacing / window.duration * std::sqrt(sums[b].area);
    const Disagreement here{std::sqrt(sums[b].size), std::max({accepted_share * std::sqrt(sums[b].change), of_load, least})};
    if (here.size * worst.accepted >= worst.size * here.accepted) worst = here;
  }
  return worst;
}

template Disagreement disagreement<2>(const Setup<2>&, const State<2>&, const Workspace<2>&, const SurfaceLoad<2>&,
                                      const std::vector<Vector<2>>&);
template Disagreement disagreement<3>(const Setup<3>&, const State<3>&, const Workspace<3>&, const SurfaceLoad<3>&,
                                      const std::vector<Vector<3>>&);

}  // namespace tern::coupler
