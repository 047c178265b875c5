#pragma once
// Sums of the kernel over a full square or cubic lattice: the constants by which discrete operators are calibrated, so
// that on an undisturbed lattice a uniform pressure is transferred exactly and the Laplacian of x^2 is exactly 2.

#include "sph/kernel.hpp"

namespace tern {

struct LatticeSums {
  double density = 0;           ///< sum V w, the particle itself included [-]
  double gradient_moment = 0;   ///< M_xx = sum V |w'| x^2/r [-]; 1 for a continuum
  double laplacian_weight = 0;  ///< sum V K with K = -2 w'/r, uncalibrated [1/m^2]
};

template <int D>
LatticeSums lattice_sums(const Kernel<D>& kernel, double spacing);

}  // namespace tern
