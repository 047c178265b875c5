#pragma once
// The state of the fluid: everything a later step needs. All else is rebuilt from it every step.

#include <cstdint>
#include <vector>

#include "base/time.hpp"
#include "base/vector.hpp"
#include "scene/case_file.hpp"
#include "sph/face_kernel.hpp"
#include "sph/lattice_sums.hpp"

namespace tern::fluid {

template <int D>
struct State {
  Ticks time = 0;
  std::vector<std::uint32_t> id;           ///< label, stable over the run
  std::vector<Vector<D>> position;         ///< [m]
  std::vector<Vector<D>> velocity;         ///< [m/s]
  std::vector<double> pressure;            ///< [Pa]
  std::vector<std::uint8_t> free_surface;  ///< 1: marked as free surface; kept for the hysteresis of the mark

  std::size_t size() const { return id.size(); }
};

/// What stays the same over a run.
template <int D>
struct Constants {
  explicit Constants(const FluidCase& fluid)
      : numerics(fluid.numerics),
        spacing(fluid.spacing),
        density(fluid.density),
        viscosity(fluid.viscosity.value_or(0) / fluid.density),
        volume(std::pow(fluid.spacing, D)),
        mass(density * volume),
        kernel(fluid.numerics.smoothing_length_ratio * fluid.spacing),
        faces(kernel, fluid.spacing),
        lattice(lattice_sums<D>(kernel, fluid.spacing)) {}

  FluidNumerics numerics;
  double spacing;       ///< dx [m]
  double density;       ///< rho [kg/m^3]
  double viscosity;     ///< kinematic, nu = mu/rho; 0 = inviscid [m^2/s]
  double volume, mass;  ///< per particle [m^D], [kg/m^(3-D)]
  Kernel<D> kernel;
  FaceKernel<D> faces;
  LatticeSums lattice;
};

}  // namespace tern::fluid
