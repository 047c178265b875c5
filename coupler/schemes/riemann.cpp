// "riemann", pairs with dissipation (seed paper eq. 6): before the pressure solve the dissipative part of a Riemann problem between both
// sides (riemann.hpp) acts on the pairs. The pressure of a pair is that of its particle. A point has the mean of them, as with "pi":
// what particles fill of the half space before it is 1 only where they are in order, and the level of the pressure times what it differs
// from that would be a load.

#include "coupler/schemes/riemann.hpp"

#include "coupler/schemes/scheme.hpp"
#include "coupler/state.hpp"
#include "coupler/workspace.hpp"
#include "sph/wet_share.hpp"

namespace tern::coupler {
namespace {

template <int D>
void add_dissipation(const Setup<D>& setup, Workspace<D>& window, Evaluations& evaluations) {
  if (!(setup.coupling.riemann_limiter > 0)) return;
  const auto& pairs = window.pairs.pairs();
  double fastest = 0;
  for (const auto& u : window.particles.velocity) fastest = std::max(fastest, u.norm());
  for (const auto& pair : pairs) fastest = std::max(fastest, window.surface.velocity[pair.point].norm());
  const double sound_speed = 10 * fastest;
  if (sound_speed == 0) return;
  evaluations.riemann_dissipation += static_cast<long>(pairs.size());
  for (const auto& pair : pairs) {
    const Vector<D>& n = window.surface.normal[pair.point];
    const double approach = (window.surface.velocity[pair.point] - window.particles.velocity[pair.particle]).dot(n);
    const double body = setup.body_density[setup.properties.body[pair.point]];
    const double mean = mean_density(setup.density, body);
    const double pressure = riemann_pressure(setup.coupling.riemann_limiter, mean, sound_speed, approach);
    if (pressure == 0) continue;
    add_pair_force(pair, Vector<D>(pressure * pair.b), window.load, window.condition.force);
    window.audit.riemann_dissipation += pressure * -pair.b.dot(n) * approach * window.duration;
  }
}

}  // namespace

template <int D>
Scheme<D> riemann() {
  return {wet_share, take_means<D>, add_dissipation<D>};
}

template Scheme<2> riemann<2>();
template Scheme<3> riemann<3>();

}  // namespace tern::coupler
