// Viscous acceleration: what it may never do, and what it does to a linear profile at a wall.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"
#include "fluid/motion/viscosity.hpp"

namespace tern::fluid::testing {
namespace {

constexpr unsigned seed = 20240124;

/// A channel along x of height 1 between walls at rest, n layers; kinematic viscosity nu.
Case channel(int dimension, int n, double nu, bool slip = false) {
  const double width = 0.5;
  WallCase walls = tank({0, 0, 0}, {width, 1, width}, {"x_min", "x_max"});
  if (dimension == 3) walls.open.insert(walls.open.end(), {"z_min", "z_max"});
  walls.slip = slip;
  Case c = scene(dimension, 1.0 / n, {box({0, 0, 0}, {width, 1, width})}, {walls}, 0);
  make_periodic(c, {0, -1, 0}, {width, 2, width}, dimension == 2 ? "x" : "xz");
  c.fluid->viscosity = nu * density;
  return c;
}

constexpr double dt = 1e-4;

/// What a step's viscosity adds to a velocity given at each particle of a fluid at rest.
template <int D>
struct ViscousChange {
  template <class Field>
  ViscousChange(Fluid<D>& fluid, Field&& field) {
    fluid.begin_window(0, to_ticks(dt));
    fluid.see_surface({});
    position = fluid.prediction().position;
    for (const auto& x : position) velocity.push_back(field(x));
    change.assign(position.size(), Vector<D>::Zero());
    ByAxis<D> packed;
    by_axis<D>(velocity, packed);
    add_viscosity<D>(fluid.constants(), dt, fluid.neighbours(), fluid.boundary(), position, packed, change);
  }
  std::vector<Vector<D>> position, velocity, change;
};

/// Over the sum of the sizes of its terms.
template <int D>
double power_of_viscosity(bool slip, std::mt19937& random) {
  Fluid<D> fluid(channel(D, D == 2 ? 20 : 12, 0.1, slip));
  jitter(fluid, 0.2, random);
  std::normal_distribution<double> normal(0, 1e-3);
  const ViscousChange<D> viscous(fluid, [&](const Vector<D>&) {
    Vector<D> u;
    for (int k = 0; k < D; ++k) u[k] = normal(random);
    return u;
  });
  double power = 0, size = 0;
  for (std::size_t i = 0; i < viscous.velocity.size(); ++i) {
    const double by_viscosity = viscous.change[i].dot(viscous.velocity[i]);
    power += by_viscosity, size += std::abs(by_viscosity);
  }
  return power / size;
}

// Seen to fail: with the sign of the pair term turned.
TEST(Viscosity, TakesEnergyFromAnyVelocity) {
  std::mt19937 random(seed);
  for (int draw = 0; draw < 5; ++draw)
    for (bool slip : {false, true}) {
      EXPECT_LT(power_of_viscosity<2>(slip, random), -0.1);
      EXPECT_LT(power_of_viscosity<3>(slip, random), -0.1);
    }
}

/// Largest acceleration of a linear profile u = y along the channel, over nu/dx^2 times the difference between two layers.
template <int D>
double residual_of_linear_profile(int n) {
  Fluid<D> fluid(channel(D, n, 0.1));
  const ViscousChange<D> viscous(fluid, [](const Vector<D>& x) { return Vector<D>(x[1] * Vector<D>::Unit(0)); });
  double largest = 0;
  for (std::size_t i = 0; i < viscous.position.size(); ++i)
    if (viscous.position[i][1] <= 0.6) largest = std::max(largest, std::abs(viscous.change[i][0]) / dt);  // the wall on top stands still
  return largest / (0.1 / fluid.constants().spacing);
}

// Couette's profile is steady: layers at the wall have no acceleration. Measured 8e-5. Seen to fail: with half of the wall
// term, with its sign turned, and without images of the patches.
TEST(Viscosity, LeavesALinearProfileAtAWallAlone) {
  const double two = residual_of_linear_profile<2>(20), three = residual_of_linear_profile<3>(12);
  std::printf("residual of a linear profile: 2D %.2e, 3D %.2e of nu du/dy / dx\n", two, three);
  EXPECT_LT(two, 1e-3);
  EXPECT_LT(three, 1e-3);
}

TEST(Viscosity, LimitsTheStep) {
  Fluid<2> fluid(channel(2, 20, 10.0));
  const StepProposal proposal = fluid.propose_step();
  EXPECT_EQ(proposal.limit, std::string("viscosity"));
  EXPECT_NEAR(proposal.seconds, 0.125 * 0.075 * 0.075 / 10, 1e-9);
}

}  // namespace
}  // namespace tern::fluid::testing
