// Viscous acceleration: what it may never do, and what it does to a linear profile at a wall.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"

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

template <int D>
double power_of_viscosity(bool slip, std::mt19937& random) {
  Case c = channel(D, D == 2 ? 20 : 12, 0.1, slip);
  c.fluid->numerics.pressure_tolerance = 1e30;  // no pressure: what changes the velocity is viscosity
  c.fluid->numerics.contact_distance = 0;
  c.fluid->numerics.shifting = 0;
  Fluid<D> fluid(c);
  jitter(fluid, 0.2, random);
  State<D> state = fluid.state();
  std::normal_distribution<double> normal(0, 1e-3);
  for (auto& u : state.velocity)
    for (int k = 0; k < D; ++k) u[k] = normal(random);
  fluid.set_state(state);
  const double dt = seconds(to_ticks(1e-4));
  step(fluid, dt);
  double power = 0, size = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    const Vector<D>& u = state.velocity[fluid.state().id[i]];
    const double by_viscosity = fluid.constants().mass / dt * (fluid.state().velocity[i] - u).dot(u);
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
  Case c = channel(D, n, 0.1);
  c.fluid->numerics.pressure_tolerance = 1e30;
  c.fluid->bodies[0].velocity = {Expression("1e-3*y"), Expression(), Expression()};
  Fluid<D> fluid(c);
  const double dt = seconds(to_ticks(1e-5)), dx = fluid.constants().spacing;
  step(fluid, dt);
  double largest = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    const double y = fluid.state().position[i][1];
    if (y > 0.6) continue;  // the wall on top does not move with the profile
    largest = std::max(largest, std::abs(fluid.state().velocity[i][0] - 1e-3 * y) / dt);
  }
  return largest / (0.1 / dx * 1e-3);
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
