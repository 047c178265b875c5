// What separates and what is alone: thin obstacles between two waters, and spray.

#include <gtest/gtest.h>

#include <map>

#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

constexpr unsigned seed = 20240120;
constexpr double spacing = 0.05;

/// Water 0.8 m deep left and `right` m deep right of an obstacle one spacing thick that divides a tank.
Fluid<2> divided_tank(double right, double size_of_jitter, bool divided = true) {
  std::vector<Shape> water = {box({0, 0, 0}, {0.5, 0.8, 0})};
  if (right > 0) water.push_back(box({0.55, 0, 0}, {1.05, right, 0}));
  std::vector<WallCase> walls = {tank({0, 0, 0}, {1.05, 2, 0})};
  if (divided) walls.push_back(obstacle({0.5, -0.1, 0}, {0.55, 1.5, 0}));
  Case c = scene(2, spacing, water, walls);
  c.fluid->numerics.density_relaxation = 0;
  Fluid<2> fluid(c);
  std::mt19937 random(seed);
  // The left water comes first and gets the same random numbers for any depth on the right.
  jitter(fluid, size_of_jitter, random);
  solve(fluid, 1e-3);
  return fluid;
}

int crossing_pairs(const Fluid<2>& fluid) {
  const auto& x = fluid.state().position;
  const auto& pairs = fluid.neighbours();
  int crossing = 0;
  for (std::size_t i = 0; i < x.size(); ++i) pairs.for_each(i, [&](int j, float) { crossing += (x[i][0] < 0.525) != (x[j][0] < 0.525); });
  return crossing;
}

// Seen to fail: with pairs through the faces of walls not cut.
TEST(ThinObstacle, LetsNoPairOfParticlesSeeEachOther) {
  EXPECT_GT(crossing_pairs(divided_tank(0.8, 0.1, false)), 50);
  EXPECT_EQ(crossing_pairs(divided_tank(0.8, 0)), 0);
  EXPECT_EQ(crossing_pairs(divided_tank(0.8, 0.1)), 0);
  EXPECT_EQ(crossing_pairs(divided_tank(0.4, 0.1)), 0);
}

// Measured difference: 1e-11 of rho g H. Seen to fail: as above, and with patches behind the obstacle still seen.
TEST(ThinObstacle, KeepsThePressureOfOneSideFromTheOther) {
  for (double size_of_jitter : {0.0, 0.1}) {
    std::map<std::uint32_t, double> alone;
    const Fluid<2> reference = divided_tank(0, size_of_jitter);
    const auto left = static_cast<std::uint32_t>(reference.state().size());
    for (std::size_t i = 0; i < reference.state().size(); ++i) alone[reference.state().id[i]] = reference.state().pressure[i];
    for (double right : {0.4, 0.8}) {
      const Fluid<2> fluid = divided_tank(right, size_of_jitter);
      double largest = 0, right_bottom = 0;
      for (std::size_t i = 0; i < fluid.state().size(); ++i) {
        const auto id = fluid.state().id[i];
        if (id < left)
          largest = std::max(largest, std::abs(fluid.state().pressure[i] - alone[id]));
        else
          right_bottom = std::max(right_bottom, fluid.state().pressure[i]);
      }
      EXPECT_LT(largest, 0.01 * density * gravity * 0.8);
      if (size_of_jitter == 0) {
        EXPECT_NEAR(right_bottom, density * gravity * (right - 0.5 * spacing), 0.05 * density * gravity * right);
      }
    }
  }
}

/// A block of ten by ten particles and others at the places given, without walls.
Case block_and(std::vector<std::array<double, 2>> others) {
  std::vector<Shape> bodies = {box({0, 0, 0}, {0.5, 0.5, 0})};
  const double half = 0.5 * spacing;
  for (const auto& at : others) bodies.push_back(box({at[0] - half, at[1] - half, 0}, {at[0] + half, at[1] + half, 0}));
  return scene(2, spacing, bodies);
}

// Seen to fail: with the row of a particle left out of the unknowns empty, and with positions advanced by the old
// velocity.
TEST(Spray, FliesBallisticallyAndLeavesNoZeroDiagonal) {
  Case c = block_and({{2, 3}});
  c.fluid->bodies[1].velocity = {Expression(1.5), Expression(2.5), Expression()};
  Fluid<2> fluid(c);
  const std::uint32_t label = 100;
  ASSERT_EQ(fluid.state().size(), 101u);
  const double dt = seconds(Ticks{1} << 22);  // 2^-10 s
  for (int n = 1; n <= 60; ++n) {
    step(fluid, dt);
    for (int i = 0; i < fluid.pressure_matrix().rows(); ++i) ASSERT_GT(fluid.pressure_matrix().diagonal()[i], 0);
    ASSERT_TRUE(fluid.last_solve().converged);
    const auto& ids = fluid.state().id;
    const auto at = static_cast<std::size_t>(std::find(ids.begin(), ids.end(), label) - ids.begin());
    ASSERT_TRUE(fluid.state().particle_class[at].spray());
    EXPECT_EQ(fluid.state().pressure[at], 0);
    // Drift, kick, drift follows a parabola exactly.
    const Vector<2> u(1.5, 2.5 - gravity * n * dt);
    const Vector<2> x(2 + 1.5 * n * dt, 3 + 2.5 * n * dt - gravity * dt * dt * n * n / 2);
    EXPECT_LT((fluid.state().velocity[at] - u).norm(), 1e-12);
    EXPECT_LT((fluid.state().position[at] - x).norm(), 1e-12);
  }
}

// Spray within reach of others counts as a neighbour at p = 0. Seen to fail: without sum_spray a_ij in c_i; without the
// missing part of the support; with the deficit counted from 0 instead of 0.08.
TEST(Spray, IsANeighbourAtZeroPressureLikeTheMissingPartOfASupport) {
  Case c = block_and({{0.5 + 1.5 * spacing, 0.275}});
  Fluid<2> fluid(c);
  std::mt19937 random(seed);
  jitter(fluid, 0.05, random);
  solve(fluid, 1e-3);
  const auto& k = fluid.constants();
  const auto& pairs = fluid.neighbours();
  ASSERT_EQ(fluid.spray_particles(), 1u);
  const double full = k.lattice.laplacian_weight / k.lattice.gradient_moment;
  int beside_spray = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    if (fluid.state().particle_class[i].spray()) continue;
    const double deficit = 1 - pairs.moment[i].trace() / 2;
    double expected = deficit > 0.08 ? k.volume * deficit * full : 0;
    pairs.for_each(i, [&](int j, float weight) {
      if (fluid.state().particle_class[j].spray()) expected += 2 * k.volume * weight, ++beside_spray;
    });
    EXPECT_NEAR(fluid.pressure_matrix().constant()[i], expected, 1e-6 * (expected + k.volume));
  }
  EXPECT_GE(beside_spray, 3);
}

}  // namespace
}  // namespace tern::fluid::testing
