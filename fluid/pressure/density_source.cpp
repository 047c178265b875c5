// Relaxation of the particle number density towards the lattice's (after Asai et al. 2012):
//   s_i = gamma (n_i - 1) / tau,   div u^{n+1} is driven to s_i.
// tau is the time in which a particle passes 0.15 spacings of one that is 10 spacings away, by the gradient of the velocity, or in which it
// falls by 0.005 spacings: the same for every observer, and of what flows here alone. It does not depend on the step taken: with 1/dt one
// short step would turn the accumulated error into a pressure jump.
// Compression is relaxed everywhere, expansion only inside: one-sided it would inflate the fluid by 1 % per second.

#include "fluid/pressure/density_source.hpp"

#include <algorithm>

#include "base/parallel.hpp"

namespace tern::fluid {
namespace {

/// tr M / D above which missing density is a gap, not a surface: from the third layer below a flat surface on. With the
/// second layer (0.92) included, the source takes 2 % of the energy of a standing wave per period.
constexpr double interior_trace = 0.97;

/// Spacings to the particle that is passed. With gamma = 0.02 an error of the density falls to a quarter in the time in which the flow
/// turns or strains by 1.
constexpr double far = 10;

/// Of an error of the density, what a window drives out by the flow at most. Water that hits water overlaps within a window; driven out at
/// once, that would throw the water back.
constexpr double largest_share = 0.05;

}  // namespace

template <int D>
void compute_density_source(const Reference<D>& reference, double duration, const PackedVelocities<D>& packed,
                            const Neighbours<D>& neighbours, const Boundary<D>& boundary, const Corrections<D>& correction,
                            const std::vector<ParticleClass>& particle_class, std::vector<double>& source) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(neighbours.rows());
  source.resize(n);
  const Constants<D>& constants = reference.constants;
  const PassingRate passing(reference, far);
  const double gamma = constants.numerics.density_relaxation, by_gravity = gamma * passing.by_gravity, by_flow = gamma * passing.by_flow;
  parallel_for(n, [&](std::ptrdiff_t i) {
    const double excess = (neighbours.number_density[i] + boundary.sums.number_density[i]) / constants.lattice.density - 1;
    const bool applies = excess > 0 || (correction.trace[i] > interior_trace && particle_class[i].interior());
    source[i] = applies ? std::max(by_gravity, std::min(by_flow * packed.gradient_size[i], largest_share / duration)) * excess : 0;
  });
}

template void compute_density_source<2>(const Reference<2>&, double, const PackedVelocities<2>&, const Neighbours<2>&, const Boundary<2>&,
                                        const Corrections<2>&, const std::vector<ParticleClass>&, std::vector<double>&);
template void compute_density_source<3>(const Reference<3>&, double, const PackedVelocities<3>&, const Neighbours<3>&, const Boundary<3>&,
                                        const Corrections<3>&, const std::vector<ParticleClass>&, std::vector<double>&);

}  // namespace tern::fluid
