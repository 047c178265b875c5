// Free surface and spray. tr M / D falls from 1 inside to 0.62 at a flat surface (Lee et al. 2008: div r). The mark only
// chooses the form of the pressure gradient and of the shifting; the condition p = 0 itself is soft (pressure_poisson.cpp).

#include "fluid/free_surface.hpp"

#include "base/parallel.hpp"
#include "fluid/eigenvalue.hpp"

namespace tern::fluid {
namespace {

constexpr double mark_below = 0.78, unmark_above = 0.82;  ///< of tr M / D; two thresholds keep marks from flickering
constexpr double spray_eigenvalue = 0.2;                  ///< of M: below, too few neighbours to hold a pressure
constexpr double symmetric_eigenvalue = 0.6;              ///< of M: below, the corrected gradient is not trusted

}  // namespace

template <int D>
void classify_particles(const Constants<D>& constants, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                        const Corrections<D>& correction, State<D>& state) {
  using Mark = ParticleClass;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state.size());
  std::vector<ParticleClass>& particle_class = state.particle_class;
  const bool always = constants.numerics.gradient == GradientForm::sum;
  parallel_for(n, [&](std::ptrdiff_t i) {
    const bool at_structure = boundary.sees_structure(i);
    const Matrix<D> m = neighbours.moment[i] + boundary.sums.moment[i];
    ParticleClass& own = particle_class[i];
    own.keep(Mark::thin_support | Mark::corrected_gradient);
    own.set(Mark::too_few_neighbours, neighbours.count[i] == 0 || (!at_structure && !eigenvalues_reach<D>(m, spray_eigenvalue)));
    if (correction.trace[i] < mark_below && !state.fills_enclosure) own.set(Mark::thin_support, true);
    if (correction.trace[i] > unmark_above) own.set(Mark::thin_support, false);
    // At the structure the coupler supplies the other half of a pair force, so this half must be symmetric too.
    own.set(Mark::symmetric_gradient, always || at_structure || !own.interior() || !eigenvalues_reach<D>(m, symmetric_eigenvalue));
  });
  // From the few marked particles to their neighbours, rather than asking all neighbours of every particle.
  parallel_for(n, [&](std::ptrdiff_t i) {
    std::uint8_t own;
#pragma omp atomic read
    own = particle_class[i].marks();
    if ((own & (Mark::thin_support | Mark::too_few_neighbours)) == 0) return;
    const std::uint8_t marks = Mark::beside_surface | Mark::symmetric_gradient | (own & Mark::too_few_neighbours ? Mark::beside_spray : 0);
    neighbours.for_each(i, [&](int j, float) {
      std::uint8_t& other = particle_class[j].marks();
#pragma omp atomic update
      other |= marks;
    });
  });
}

#define TERN_INSTANTIATE(D) \
  template void classify_particles<D>(const Constants<D>&, const Neighbours<D>&, const Boundary<D>&, const Corrections<D>&, State<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
