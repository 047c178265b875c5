// Walls that move as rigid bodies.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

WallCase rolling_tank() {
  WallCase wall = tank({-1, -0.5, 0}, {1, 0.5, 0}, {});
  wall.motion.emplace();
  wall.motion->rotation = Expression("0.3*t + 0.2*t^2");
  wall.motion->pivot = {0.2, -0.1, 0};
  wall.motion->displacement = {Expression("0.05*t^2"), Expression("0.1*t"), Expression()};
  return wall;
}

// Drops of four particles, and of one, against a wall in the longest windows, from twenty places. A particle moves by half a spacing in a
// window, and the contact distance is a quarter. Seen to fail: with contacts settled only where a particle is nearer than that (26 of 40
// drops go through the wall); with parts of the fluid asked for where all of it is spray (the program ends by a signal).
TEST(Walls, StopADropHoweverLongTheWindow) {
  const double dx = 0.01, speed = 2;
  int through = 0;
  for (int size : {1, 2})
    for (int place = 0; place < 20; ++place) {
      const double left = 0.3 + 0.0005 * place;
      Case c = scene(2, dx, {box({left, 0.1, 0}, {left + size * dx, 0.1 + size * dx, 0})}, {tank({0, 0, 0}, {0.4, 0.2, 0})});
      c.gravity = {};
      c.fluid->bodies[0].velocity = {Expression(speed), Expression(0.0), Expression(0.0)};
      Fluid<2> fluid(c);
      for (int n = 0; n < 30; ++n) step(fluid, 0.5 * dx / speed);
      bool inside = fluid.state().size() == static_cast<std::size_t>(size * size) && fluid.state().leaked == 0;
      for (const auto& x : fluid.state().position) inside = inside && x[0] < 0.4 - 0.1 * dx;
      through += !inside;
    }
  EXPECT_EQ(through, 0);
}

// Velocity and acceleration of each patch against those of a rigid body with angular velocity w = 0.3 + 0.4 t and angular
// acceleration 0.4. Walls stand at the middle of the window, and have the rates of its end. Seen to fail with an acceleration of 0, with
// the normals left unturned, and with the mean rates over the window.
TEST(Walls, ThatRollHaveTheVelocityAndAccelerationOfARigidBody) {
  const double dt = 1e-4;
  Walls<2> walls(scene(2, 0.1, {box({-1, -0.5, 0}, {1, 0, 0})}, {rolling_tank()}), 0.1, 0.3);
  const Faces<2> start = walls.faces();
  FollowedWalls<2> followed;
  const int last = 5000;
  for (int k = 0; k < last; ++k) walls.move_over(k * dt, dt, k == 0 ? 0 : dt, followed);
  const double t = (last - 0.5) * dt, angle = 0.3 * t + 0.2 * t * t, w = 0.3 + 0.4 * last * dt;
  Matrix<2> turn;
  turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  const Vector<2> pivot(0.2, -0.1), shift(0.05 * t * t, 0.1 * t), shift_rate(0.1 * last * dt, 0.1);
  const Faces<2>& faces = walls.faces();
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const Vector<2> arm = turn * (start.position[k] - pivot), tangent(-arm[1], arm[0]);
    EXPECT_LT((faces.position[k] - pivot - arm - shift).norm(), 1e-12);
    EXPECT_LT((faces.normal[k] - turn * start.normal[k]).norm(), 1e-12);
    EXPECT_LT((faces.velocity[k] - shift_rate - w * tangent).norm(), 1e-8);
    const Vector<2> acceleration = Vector<2>(0.1, 0) + 0.4 * tangent - w * w * arm;
    EXPECT_NEAR(faces.normal_acceleration[k], acceleration.dot(faces.normal[k]), 2e-4);
  }
}

// As gravity does. Seen to fail: without it (0.9 s, by the velocity), with which a cylinder of 10 spacings that swings in 1 s felt 0.90 of
// its added mass.
TEST(Walls, ThatAccelerateLimitTheWindow) {
  WallCase ram = obstacle({-0.5, -0.1, 0}, {0, 0.5, 0});
  ram.motion.emplace().displacement = {Expression("1.5*t^2"), Expression(), Expression()};
  Fluid<2> fluid(scene(2, 0.02, {box({0, 0, 0}, {0.4, 0.4, 0})}, {ram}, 0));
  for (int n = 0; n < 3; ++n) step(fluid, 1e-3);
  EXPECT_EQ(std::string(fluid.propose_step().limit), "walls");
  EXPECT_NEAR(fluid.propose_step().seconds, 0.1 * std::sqrt(0.02 / 3), 1e-8);
}

/// Largest difference between the velocity of a box that is full and shaken and that of its water at the end of a window, over the largest.
double lag_in_shaken_box(double dt) {
  constexpr double amplitude = 0.01, omega = 2 * std::numbers::pi;
  WallCase wall = tank({0, 0, 0}, {1, 0.5, 0}, {});
  wall.motion.emplace();
  wall.motion->displacement[0] = Expression("0.01*(1 - cos(2*pi*t))");
  Fluid<2> fluid(scene(2, 0.05, {box({0, 0, 0}, {1, 0.5, 0})}, {wall}, 0));
  double largest = 0;
  for (double time = dt; time < 1; time += dt) {
    step(fluid, dt);
    double mean = 0;
    for (const auto& u : fluid.state().velocity) mean += u[0] / static_cast<double>(fluid.state().size());
    largest = std::max(largest, std::abs(mean / (amplitude * omega) - std::sin(omega * time)));
  }
  return largest;
}

// Seen to fail: with the mean velocity of walls over a window (half a window of the acceleration, 0.13 and 0.063).
TEST(Walls, ThatAreShakenCarryTheFluidAlongToSecondOrder) {
  const double lag = lag_in_shaken_box(0.04), half = lag_in_shaken_box(0.02);
  std::printf("[ %.4f, with half the window %.4f ]\n", lag, half);
  EXPECT_LT(lag, 0.02);
  EXPECT_NEAR(lag / half, 4, 1);
}

// A wall that starts from rest with an acceleration has all of it from its first window on. Seen to fail: with the velocity at the begin of
// the motion for what was followed before (0.84 of it).
TEST(Walls, ThatStartWithAnAccelerationHaveItInTheirFirstWindow) {
  WallCase wall = tank({0, 0, 0}, {1, 0.5, 0}, {});
  wall.motion.emplace();
  wall.motion->displacement[0] = Expression("0.5*t^2");
  Walls<2> walls(scene(2, 0.05, {box({0, 0, 0}, {1, 0.5, 0})}, {wall}, 0), 0.05, 0.15);
  FollowedWalls<2> followed;
  for (int n = 0; n < 3; ++n) EXPECT_NEAR(walls.move_over(n * 1e-3, 1e-3, n == 0 ? 0 : 1e-3, followed).acceleration, 1, 1e-9) << n;
}

// A turning box has to enclose the same volume in every step, however long: sum A n.u = 0. Seen to fail with the normals left
// unturned.
TEST(Walls, ThatRollEncloseTheSameVolume) {
  Walls<2> walls(scene(2, 0.1, {box({-1, -0.5, 0}, {1, 0, 0})}, {rolling_tank()}), 0.1, 0.3);
  FollowedWalls<2> followed;
  walls.move_over(0.4, 0.1, 0, followed);
  double flux = 0;
  for (std::size_t k = 0; k < walls.faces().size(); ++k)
    flux += walls.faces().area[k] * walls.faces().normal[k].dot(walls.faces().velocity[k]);
  EXPECT_NEAR(flux, 0, 1e-12);
}

// A full closed box shaken along x: the fluid goes along as a whole, p falls along x as rho a. The band of the pressure is
// wide because floor and ceiling mirror no pressure gradient along themselves; measured: 5 % too steep, velocity within
// 1 %. Seen to fail with the acceleration of the walls left out.
TEST(Walls, ThatAccelerateCarryTheFluidAlong) {
  WallCase wall = tank({0, 0, 0}, {1, 0.5, 0}, {});
  wall.motion.emplace();
  wall.motion->displacement[0] = Expression("0.5*t^2");
  Fluid<2> fluid(scene(2, 0.05, {box({0, 0, 0}, {1, 0.5, 0})}, {wall}, 0));
  for (int k = 0; k < 100; ++k) step(fluid, 1e-3);
  Vector<2> mean = Vector<2>::Zero();
  for (const auto& u : fluid.state().velocity) mean += u / static_cast<double>(fluid.state().size());
  EXPECT_NEAR(mean[0], 0.1, 0.002);
  const double drop = fluid.pressure_at(Vector<2>(0.205, 0.25)).value() - fluid.pressure_at(Vector<2>(0.805, 0.25)).value();
  EXPECT_NEAR(drop, density * 1.0 * 0.6, 0.08 * density * 0.6);
  EXPECT_EQ(fluid.leaked(), 0u);
}

}  // namespace
}  // namespace tern::fluid::testing
