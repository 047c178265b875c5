#include "coupler/acceleration/agreement.hpp"

#include <algorithm>
#include <cmath>

namespace tern::coupler {
namespace {

constexpr double accepted_share = 0.1;     ///< of the change of velocity
constexpr double least_of_fastest = 1e-3;  ///< of the fastest motion, as a change of velocity that counts
constexpr double least_of_window = 0.01;   ///< the same of the speed that the window is made for

}  // namespace

template <int D>
Disagreement disagreement(const Setup<D>& setup, const State<D>& state, const Workspace<D>& window, const SurfaceLoad<D>& answer,
                          const std::vector<Vector<D>>& velocity) {
  const Surface<D>& surface = window.surface;
  LumpMotion<D> answered(window.answer.lumps, window.answer.mass, window.duration);
  for (std::size_t k = 0; k < surface.position.size(); ++k) answered.push(k, answer.force[k] - window.assumed_load.force[k]);
  double size = 0, change = 0, fastest = 0, area = 0;
  for (std::size_t k = 0; k < surface.position.size(); ++k) {
    if (window.share[k] == 0) continue;  // dry
    const Vector<D>& n = surface.normal[k];
    const double a = surface.area[k], told = (surface.velocity[k] + answered.velocity(k)).dot(n);
    const double before = state.surface_velocity.empty() ? 0 : state.surface_velocity[k].dot(n);
    size += a * std::pow(told - velocity[k].dot(n), 2);
    change += a * std::pow(told - before, 2);
    area += a;
    fastest = std::max(fastest, velocity[k].norm());
  }
  const double floor = std::max(least_of_fastest * fastest, least_of_window * setup.courant * setup.spacing / window.duration);
  return {std::sqrt(size), accepted_share * std::max(std::sqrt(change), floor * std::sqrt(area))};
}

template Disagreement disagreement<2>(const Setup<2>&, const State<2>&, const Workspace<2>&, const SurfaceLoad<2>&,
                                      const std::vector<Vector<2>>&);
template Disagreement disagreement<3>(const Setup<3>&, const State<3>&, const Workspace<3>&, const SurfaceLoad<3>&,
                                      const std::vector<Vector<3>>&);

}  // namespace tern::coupler
