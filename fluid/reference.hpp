#pragma once
// What stays the same over a run.

#include <array>
#include <vector>

#include "base/vector.hpp"
#include "fluid/initial_state.hpp"
#include "fluid/period.hpp"
#include "scene/case_file.hpp"
#include "scene/gauges.hpp"
#include "sph/face_kernel.hpp"
#include "sph/lattice_sums.hpp"

namespace tern::fluid {

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

template <int D>
class Gravity {
 public:
  explicit Gravity(const Case& scene);

  bool uniform() const { return uniform_; }
  /// [m/s^2]. An expression cannot be evaluated by two threads at a time.
  Vector<D> at(double t, const Vector<D>& x) const;

 private:
  std::array<Expression, 3> expression_;
  bool uniform_;
};

template <int D>
struct Reference {
  Reference(const Case& scene, const StartParticles<D>& start);

  Constants<D> constants;
  Gravity<D> gravity;
  Period<D> period;
  Vector<D> domain_min, domain_max;    ///< corners of the domain [m]
  std::size_t particles;               ///< at the start: labels are below
  double gravity_size = 0;             ///< largest of the run, where the fluid is at the start [m/s^2]
  Upward up;                           ///< for elevations
  bool has_bodies = false;             ///< there is a structure
  double window_at_rest = 0;           ///< where nothing moves and nothing acts yet [s]
  double window_at_rest_in_frame = 0;  ///< the same to the observer who goes along [s]
  double speed_floor = 0;              ///< half the fall through the height of the fluid: bounds the first steps from rest [m/s]
};

}  // namespace tern::fluid
