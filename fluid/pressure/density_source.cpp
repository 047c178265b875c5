// Relaxation of the particle number density towards the lattice's (after Asai et al. 2012):
//   s_i = gamma (n_i - 1) / tau,   div u^{n+1} is driven to s_i.
// tau does not depend on the step taken: with 1/dt one short step would turn the accumulated error into a pressure jump.
// Compression is relaxed everywhere, expansion only inside: one-sided it would inflate the fluid by 1 % per second.

#include "base/parallel.hpp"
#include "fluid/fluid.hpp"

namespace tern::fluid {
namespace {

/// tr M / D above which missing density is a gap, not a surface: from the third layer below a flat surface on. With the
/// second layer (0.92) included, the source takes 2 % of the energy of a standing wave per period.
constexpr double interior_trace = 0.97;

}  // namespace

template <int D>
double Fluid<D>::density_time_scale() const {
  const double by_velocity = 0.15 * constants_.spacing / std::max(bulk_speed_, 1e-300);
  return gravity_size_ > 0 ? std::min(by_velocity, 0.1 * std::sqrt(constants_.spacing / gravity_size_)) : by_velocity;
}

template <int D>
void Fluid<D>::compute_density_source() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  density_source_.resize(n);
  evaluations_.density_source += n;
  const double rate = constants_.numerics.density_relaxation / density_time_scale();
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const double excess = (neighbours_.number_density[i] + boundary_.number_density[i]) / constants_.lattice.density - 1;
    const bool applies = excess > 0 || (trace_[i] > interior_trace && flag_[i] == Flag::interior);
    density_source_[i] = applies ? rate * excess : 0;
  }
}

template double Fluid<2>::density_time_scale() const;
template double Fluid<3>::density_time_scale() const;
template void Fluid<2>::compute_density_source();
template void Fluid<3>::compute_density_source();

}  // namespace tern::fluid
