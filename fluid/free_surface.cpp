// Free surface and spray. tr M / D falls from 1 inside to 0.62 at a flat surface (Lee et al. 2008: div r). The mark only
// chooses the form of the pressure gradient and of the shifting; the condition p = 0 itself is soft (pressure_poisson.cpp).

#include "base/parallel.hpp"
#include "fluid/eigenvalue.hpp"
#include "fluid/fluid.hpp"

namespace tern::fluid {
namespace {

constexpr double mark_below = 0.78, unmark_above = 0.82;  ///< of tr M / D; two thresholds keep marks from flickering
constexpr double spray_eigenvalue = 0.2;                  ///< of M: below, too few neighbours to hold a pressure
constexpr double sum_form_eigenvalue = 0.6;               ///< of M: below, the corrected gradient is not trusted

}  // namespace

template <int D>
void Fluid<D>::mark_free_surface() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  flag_.resize(n);
  active_.resize(n);
  sum_form_.resize(n);
  const bool always = constants_.numerics.gradient == GradientForm::sum;
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const bool at_structure = surface_rows_.count[i] > 0;
    const Matrix<D> m = neighbours_.moment[i] + boundary_.moment[i];
    const bool spray = neighbours_.count[i] == 0 || (!at_structure && !eigenvalues_reach<D>(m, spray_eigenvalue));
    if (trace_[i] < mark_below && !enclosed_) state_.free_surface[i] = 1;
    if (trace_[i] > unmark_above) state_.free_surface[i] = 0;
    flag_[i] = spray ? Flag::spray : state_.free_surface[i] ? Flag::free_surface : Flag::interior;
    active_[i] = !spray;
    // At the structure the coupler supplies the other half of a pair force, so this half must be in sum form too.
    sum_form_[i] = always || at_structure || flag_[i] != Flag::interior || !eigenvalues_reach<D>(m, sum_form_eigenvalue);
  }
  // From the few marked particles to their neighbours, rather than asking all neighbours of every particle.
  near_surface_.assign(n, 0);
  near_spray_.assign(n, 0);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (flag_[i] == Flag::interior) continue;
    for (int k = neighbours_.begin[i]; k < neighbours_.begin[i] + neighbours_.count[i]; ++k) {
      const int j = neighbours_.column[k];
#pragma omp atomic write
      near_surface_[j] = 1;
      if (active_[i]) continue;
#pragma omp atomic write
      near_spray_[j] = 1;
    }
  }
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) sum_form_[i] |= near_surface_[i];
}

template void Fluid<2>::mark_free_surface();
template void Fluid<3>::mark_free_surface();

}  // namespace tern::fluid
