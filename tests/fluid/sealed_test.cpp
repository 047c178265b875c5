// Fluid that is enclosed all round: its pressure has no level, and it cannot give way.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

constexpr unsigned seed = 20240123;

double mean_pressure(const Fluid<2>& fluid, double from, double to) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    const double x = fluid.state().position[i][0];
    if (x > from && x < to) sum += fluid.state().pressure[i], ++count;
  }
  return sum / count;
}

// A plate as high as the box moves in at 1 m/s. Seen to fail: with the factor 2 of the wall flux left out of the
// divergence, and out of the account.
TEST(SealedFluid, ReportsTheVolumeThatAWallPushesIn) {
  WallCase piston = obstacle({1, -0.2, 0}, {1.1, 1.2, 0});
  piston.motion.emplace().displacement = {Expression("-1*t"), Expression(), Expression()};
  Fluid<2> fluid(scene(2, 0.025, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {1, 1, 0}, {"x_max"}), piston}, 0));
  step(fluid, 1e-3);
  ASSERT_TRUE(fluid.sealed().any);
  EXPECT_TRUE(fluid.last_solve().converged);
  EXPECT_NEAR(fluid.sealed().largest_flux, -1, 0.02);
  EXPECT_NEAR(fluid.sealed().volume_error, 1e-3, 2e-5);
  EXPECT_TRUE(fluid.sealed().warned == (fluid.sealed().volume_error >= 1e-3));
  step(fluid, 1e-3);
  EXPECT_NEAR(fluid.sealed().volume_error, 2e-3, 4e-5);
  EXPECT_TRUE(fluid.sealed().warned);
}

/// Two pools 1 m x 1 m left and right of an obstacle one spacing thick, each open at the top or under a lid.
Case two_pools(bool left_open, bool right_open) {
  std::vector<WallCase> walls = {tank({0, 0, 0}, {2.05, 2, 0}), obstacle({1, -0.1, 0}, {1.05, 2, 0})};
  if (!left_open) walls.push_back(obstacle({-0.2, 1, 0}, {1.025, 1.2, 0}));
  if (!right_open) walls.push_back(obstacle({1.025, 1, 0}, {2.25, 1.2, 0}));
  Case c = scene(2, 0.05, {box({0, 0, 0}, {1, 1, 0}), box({1.05, 0, 0}, {2.05, 1, 0})}, walls);
  c.fluid->numerics.density_relaxation = 0;
  return c;
}

// Seen to fail: with one mean over both pools, with the means left in the pressure, and with pools only looked for where no
// row at all is tied.
TEST(SealedFluid, HasAMeanPressureOfZeroInEachPool) {
  for (const auto& [left_open, right_open] : {std::pair{false, false}, std::pair{false, true}, std::pair{true, false}}) {
    Fluid<2> fluid(two_pools(left_open, right_open));
    std::mt19937 random(seed);
    jitter(fluid, 0.02, random);
    State<2> state = fluid.state();
    for (std::size_t i = 0; i < state.size(); ++i) state.pressure[i] = state.position[i][0] < 1 ? 5e4 : -3e4;
    fluid.set_state(std::move(state));
    for (int k = 0; k < 3; ++k) {
      step(fluid, 1e-3);
      EXPECT_TRUE(fluid.last_solve().converged);
      EXPECT_LE(fluid.last_solve().iterations, 10);
    }
    EXPECT_EQ(fluid.fallback_solves(), 0);
    EXPECT_TRUE(fluid.sealed().any);
    const double left = mean_pressure(fluid, 0, 1), right = mean_pressure(fluid, 1.05, 3), weight = density * gravity;
    std::printf("pools %s, %s: mean pressures %.3g, %.3g rho g H, %d iterations\n", left_open ? "open" : "sealed",
                right_open ? "open" : "sealed", left / weight, right / weight, fluid.last_solve().iterations);
    EXPECT_NEAR(left / weight, left_open ? 0.5 : 0, left_open ? 0.05 : 1e-9);
    EXPECT_NEAR(right / weight, right_open ? 0.5 : 0, right_open ? 0.05 : 1e-9);
  }
}

// What moves into one pool does nothing in the other. Seen to fail: with the source of both pools balanced together.
TEST(SealedFluid, DoesNotFeelAnotherPool) {
  Case c = two_pools(false, false);
  c.gravity[1] = Expression(0.0);
  WallCase piston = obstacle({2.05, -0.2, 0}, {2.2, 1.2, 0});
  piston.motion.emplace().displacement = {Expression("-0.1*t"), Expression(), Expression()};
  c.walls[0].shape.max[0] = 2.2;
  c.walls.push_back(piston);
  Fluid<2> fluid(c);
  solve(fluid, 1e-3);
  double left = 0, right = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    double& largest = fluid.state().position[i][0] < 1 ? left : right;
    largest = std::max(largest, std::abs(fluid.state().pressure[i]));
  }
  EXPECT_GT(right, 1e3);
  EXPECT_LT(left, 1e-6 * right);
  EXPECT_NEAR(fluid.sealed().largest_flux, -0.1, 0.004);  // 20 particles a side; the corners lose some
}

// Seen to fail: with the mean left in the pressure.
TEST(SealedFluid, HasAPressureThatDoesNotDependOnAnAddedConstant) {
  std::vector<double> pressure[2];
  for (int k = 0; k < 2; ++k) {
    Case c = scene(2, 0.05, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {1, 1, 0}, {})});
    c.fluid->numerics.pressure_tolerance = 1e-14;
    Fluid<2> fluid(c);
    std::mt19937 random(seed);
    jitter(fluid, 0.1, random);
    State<2> state = fluid.state();
    for (double& p : state.pressure) p = k * 7e5;
    fluid.set_state(std::move(state));
    solve(fluid, 1e-3);
    pressure[k] = fluid.state().pressure;
    EXPECT_LT(std::abs(ordered_sum(pressure[k])) / static_cast<double>(pressure[k].size()), 1e-9 * density * gravity);
  }
  for (std::size_t i = 0; i < pressure[0].size(); ++i) ASSERT_NEAR(pressure[0][i], pressure[1][i], 1e-6 * density * gravity);
}

// A lattice that is cut by a circle starts with a particle a hundredth of a spacing from the wall. Nothing may pass through the wall, and
// the water stays enclosed; the tank takes it along as it is.
// Seen to fail: without the way back to the contact distance (a particle is beside the wall's plane after 18 windows, and 38 windows later
// at 3 km/s).
TEST(SealedFluid, StaysInARoundTankThatIsShaken) {
  Shape circle;
  circle.kind = Shape::Kind::ball;
  circle.radius = 0.5;
  WallCase wall = tank({}, {}, {});
  wall.shape = circle;
  wall.motion.emplace().displacement = {Expression("0.05*(1-cos(2*pi*t))"), Expression(), Expression()};
  Fluid<2> fluid(scene(2, 0.02, {circle}, {wall}));
  for (int n = 0; n < 60; ++n) {
    step(fluid, 0.00383);
    for (const ParticleClass own : fluid.state().particle_class) ASSERT_TRUE(own.has(ParticleClass::enclosed)) << "window " << n;
  }
  EXPECT_EQ(fluid.state().leaked, 0);
  EXPECT_LT(fluid.largest_speed(), 0.5);  // the tank moves at 0.31 m/s at most
}

}  // namespace
}  // namespace tern::fluid::testing
