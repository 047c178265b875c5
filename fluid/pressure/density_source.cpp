// Relaxation of the particle number density towards the lattice's (after Asai et al. 2012):
//   s_i = gamma (n_i - 1) / tau,   div u^{n+1} is driven to s_i.
// tau does not depend on the step taken: with 1/dt one short step would turn the accumulated error into a pressure jump.
// Compression is relaxed everywhere, expansion only inside: one-sided it would inflate the fluid by 1 % per second.

#include "fluid/pressure/density_source.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"

namespace tern::fluid {
namespace {

/// tr M / D above which missing density is a gap, not a surface: from the third layer below a flat surface on. With the
/// second layer (0.92) included, the source takes 2 % of the energy of a standing wave per period.
constexpr double interior_trace = 0.97;

}  // namespace

template <int D>
double density_time_scale(const Reference<D>& reference, double bulk_speed) {
  const double by_velocity = 0.15 * reference.constants.spacing / std::max(bulk_speed, 1e-300);
  return reference.gravity_size > 0 ? std::min(by_velocity, 0.1 * std::sqrt(reference.constants.spacing / reference.gravity_size))
                                    : by_velocity;
}

template <int D>
void compute_density_source(const Reference<D>& reference, double bulk_speed, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                            const Corrections<D>& correction, const std::vector<ParticleClass>& particle_class,
                            std::vector<double>& source) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(neighbours.rows());
  source.resize(n);
  const Constants<D>& constants = reference.constants;
  const double rate = constants.numerics.density_relaxation / density_time_scale(reference, bulk_speed);
  parallel_for(n, [&](std::ptrdiff_t i) {
    const double excess = (neighbours.number_density[i] + boundary.sums.number_density[i]) / constants.lattice.density - 1;
    const bool applies = excess > 0 || (correction.trace[i] > interior_trace && particle_class[i].interior());
    source[i] = applies ? rate * excess : 0;
  });
}

template double density_time_scale<2>(const Reference<2>&, double);
template double density_time_scale<3>(const Reference<3>&, double);
template void compute_density_source<2>(const Reference<2>&, double, const Neighbours<2>&, const Boundary<2>&, const Corrections<2>&,
                                        const std::vector<ParticleClass>&, std::vector<double>&);
template void compute_density_source<3>(const Reference<3>&, double, const Neighbours<3>&, const Boundary<3>&, const Corrections<3>&,
                                        const std::vector<ParticleClass>&, std::vector<double>&);

}  // namespace tern::fluid
