#include "sph/lattice_sums.hpp"

namespace tern {

template <int D>
LatticeSums lattice_sums(const Kernel<D>& kernel, double spacing) {
  const int reach = static_cast<int>(std::ceil(kernel.support() / spacing));
  const double volume = std::pow(spacing, D);
  LatticeSums sums;
  for (int k = D == 3 ? -reach : 0; k <= (D == 3 ? reach : 0); ++k) {
    for (int j = -reach; j <= reach; ++j) {
      for (int i = -reach; i <= reach; ++i) {
        const double r = spacing * std::sqrt(double(i * i + j * j + k * k));
        sums.density += volume * kernel.value(r);
        if (i == 0 && j == 0 && k == 0) continue;
        const double weight = volume * kernel.gradient_weight(r);
        sums.gradient_moment += weight * (i * spacing) * (i * spacing);
        sums.laplacian_weight += 2 * weight;
      }
    }
  }
  return sums;
}

template LatticeSums lattice_sums<2>(const Kernel<2>&, double);
template LatticeSums lattice_sums<3>(const Kernel<3>&, double);

}  // namespace tern
