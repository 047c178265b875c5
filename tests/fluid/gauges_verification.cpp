// Forces and levels as the running fluid gives them.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"
#include "fluid/gauges/probe.hpp"

namespace tern::fluid::testing {
namespace {

// Mean over 1 to 2 s of water that settles from 10 % disorder: the weight on the tank to 1 %, no net force across, rho g H^2/2
// on a side that is a wall of its own, the level. Seen to fail without the hydrostatic part of the mirrored
// pressure, and with the floor under the side counted.
TEST(StillTank, CarriesTheWeightOfItsWater) {
  WallCase side = obstacle({1, 0, 0}, {1.2, 1.5, 0});
  side.name = "side";
  Fluid<2> fluid(scene(2, 0.025, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {1.2, 1.5, 0}), side}));
  std::mt19937 random(20240121);
  jitter(fluid, 0.1, random);
  Vector<2> on_tank = Vector<2>::Zero(), on_side = Vector<2>::Zero();
  double level = 0;
  int samples = 0, steps = 0;
  run(fluid, 2.0, [&] {
    if (seconds(fluid.state().time) < 1 || ++steps % 10) return;
    const Probe<2> probe(fluid, Moment::middle);
    on_tank += probe.force(fluid.walls().find("tank"), Vector<2>::Zero()).value().force;
    on_side += probe.force(fluid.walls().find("side"), Vector<2>::Zero()).value().force;
    level += Probe<2>(fluid, Moment::end).elevation(Vector<2>(0.5, 0)).value();
    ++samples;
  });
  const double weight = density * gravity;
  EXPECT_NEAR(on_tank[1] / samples / weight, -1, 0.01);
  EXPECT_NEAR(on_side[0] / samples / weight, 0.5, 0.01 * 0.5);
  EXPECT_NEAR((on_tank[0] + on_side[0]) / samples / weight, 0, 0.002);
  EXPECT_NEAR(on_side[1] / samples / weight, 0, 0.002);
  EXPECT_NEAR(level / samples, 1, 0.1 * 0.025);
}

/// Mean force on a fence in a tank of still water, 0.3 m deep, which it reaches 0.2 m into; all move with `speed` [N/m].
Vector<2> mean_force_on_fence(double speed) {
  Case c = scene(2, 0.02, {box({0, 0, 0}, {1, 0.3, 0})}, {tank({0, 0, 0}, {1, 0.7, 0}), obstacle({0.48, -0.04, 0}, {0.52, 0.2, 0})});
  c.walls[1].name = "fence";
  Shape water;
  water.kind = Shape::Kind::difference;
  water.parts = {c.fluid->bodies[0].shape, c.walls[1].shape};
  c.fluid->bodies[0].shape = water;
  c.fluid->bodies[0].velocity = {Expression(speed), Expression(0.0), Expression(0.0)};
  for (WallCase& wall : c.walls) {
    wall.motion.emplace();
    wall.motion->displacement = {Expression(fmt::format("{}*t", speed)), Expression(0.0), Expression(0.0)};
  }
  Fluid<2> fluid(c);
  Vector<2> sum = Vector<2>::Zero();
  int samples = 0;
  run(fluid, 1, [&] {
    if (seconds(fluid.state().time) < 0.5) return;
    ++samples;
    sum += Probe<2>(fluid, Moment::middle).force(fluid.walls().find("fence"), Vector<2>::Zero()).value().force;
  });
  return sum / samples;
}

// Water at rest, as seen by who moves with it, pushes a wall by as much to both sides. Seen to fail with the particles where they are at
// the end of the window and the walls where they were in its middle: 6 N/m of 392 on each side.
TEST(WallForce, InATankThatMovesEvenlyIsThatInOneAtRest) {
  const double side = 0.5 * density * gravity * (0.3 * 0.3 - 0.1 * 0.1);
  const Vector<2> rest = mean_force_on_fence(0), moving = mean_force_on_fence(3);
  std::printf("[ force on the fence over that on one side: %.4f %.4f at rest, %.4f %.4f at 3 m/s ]\n", rest[0] / side, rest[1] / side,
              moving[0] / side, moving[1] / side);
  EXPECT_LT((moving - rest).norm(), 0.005 * side);
}

// A plate fixed in still water, 0.2 m long and 4 spacings thick, feels Archimedes' lift in every window. Seen to fail: with pairs cut at
// its corners and infinite cones behind its faces (70 to 91 N/m); without back-facing faces alone (52 to 89).
TEST(WallForce, OnAPlateInStillWaterDoesNotJump) {
  const Shape plate = box({0.2, 0.03, 0}, {0.4, 0.07, 0});
  Case c = scene(2, 0.01, {box({0, 0, 0}, {0.6, 0.3, 0})}, {tank({0, 0, 0}, {0.6, 0.5, 0}), obstacle(plate.min, plate.max)});
  Shape water;
  water.kind = Shape::Kind::difference;
  water.parts = {c.fluid->bodies[0].shape, plate};
  c.fluid->bodies[0].shape = water;
  Fluid<2> fluid(c);
  double least = 1e300, most = -1e300;
  run(fluid, 1, [&] {
    if (seconds(fluid.state().time) < 0.3) return;
    const double lift = Probe<2>(fluid, Moment::middle).force(fluid.walls().find("obstacle"), Vector<2>::Zero()).value().force[1];
    least = std::min(least, lift), most = std::max(most, lift);
  });
  std::printf("[ lift %.2f to %.2f N/m for %.2f ]\n", least, most, density * gravity * 0.2 * 0.04);
  EXPECT_NEAR(least, density * gravity * 0.2 * 0.04, 1);
  EXPECT_NEAR(most, density * gravity * 0.2 * 0.04, 1);
}

/// Momentum that a jet gives to a wall across it, by the force on the wall, over what it loses.
double momentum_given(double courant, double dx) {
  constexpr double speed = 5, duration = 0.1;
  WallCase wall = obstacle({0, -0.3, 0}, {0.04, 0.3, 0});
  Case c = scene(2, dx, {box({-0.8, -0.05, 0}, {-0.02, 0.05, 0})}, {wall}, 0);
  c.fluid->bodies[0].velocity = {Expression("5"), Expression("0"), Expression()};
  Fluid<2> fluid(c);
  const double before = fluid.momentum()[0], dt = courant * dx / speed;
  double impulse = 0;
  for (int n = 0; n < duration / dt; ++n) {
    step(fluid, dt);
    impulse += dt * Probe<2>(fluid, Moment::middle).force(fluid.walls().all()[0], Vector<2>::Zero()).value().force[0];
  }
  return impulse / (before - fluid.momentum()[0]);
}

// Where a flow is compressed towards a wall, its first layer stands at the distance of contact, and contact takes its approach away window
// after window: the more, the shorter they are. What is left is an error of the gauge's pressure, of first order in the spacing. Seen to
// fail: without what contact takes (0.94 and 0.54); with particles where they are at the end of the window (1.043, and 1.022 at half the
// spacing).
TEST(Jet, GivesTheWallTheMomentumThatItLosesWhateverTheWindows) {
  const double given = momentum_given(0.4, 0.01), in_short_windows = momentum_given(0.05, 0.01), fine = momentum_given(0.4, 0.005);
  std::printf("[ courant 0.4: %.4f, 0.05: %.4f; half the spacing: %.4f ]\n", given, in_short_windows, fine);
  EXPECT_NEAR(given, 1, 0.03);
  EXPECT_NEAR(in_short_windows, 1, 0.06);
  EXPECT_NEAR(fine, 1, 0.015);
}

/// Largest | Int F dt - (M g t - P(t)) | over the collapse of a column `nx` particles wide and its impact on the end wall,
/// per unit of M sqrt(g H); the impulse itself is 2.7.
double lost_impulse(int nx) {
  Fluid<2> fluid(dam_break(nx, 2 * nx));
  const double mass = density * 0.2 * 0.4, unit = mass * std::sqrt(gravity * 0.4);
  Vector<2> impulse = Vector<2>::Zero();
  double last = 0, difference = 0;
  run(fluid, 0.5, [&] {
    const double now = seconds(fluid.state().time);
    impulse += (now - last) * Probe<2>(fluid, Moment::middle).force(fluid.walls().find("tank"), Vector<2>::Zero()).value().force;
    last = now;
    const Vector<2> lost = mass * now * Vector<2>(0, -gravity) - fluid.momentum();
    difference = std::max(difference, (impulse - lost).norm() / unit);
  });
  EXPECT_GT(impulse.norm() / unit, 2);
  return difference;
}

// What the force on the tank adds up to is at all times the momentum that the water did not keep, to the order of the
// blended pressure gradient, which is not antisymmetric. Measured: 0.019 at 20 columns, 0.009 at 40, that is 0.7 and 0.3 % of
// the impulse. Seen to fail with the pressure of the particles alone, without its hydrostatic part, and without what contact takes (0.11).
TEST(DamBreak, GivesTheTankTheMomentumThatTheWaterLoses) {
  const double coarse = lost_impulse(20), fine = lost_impulse(40);
  EXPECT_LT(fine, 0.8 * coarse);
  EXPECT_LT(fine, 0.01 * 2.7);
  std::printf("[ momentum lost: %.3f of M sqrt(g H) at 20 columns, %.3f at 40 ]\n", coarse, fine);
}

// A closed tank rolls by 0.15 rad about a point below it at the first resonance of its water: no particle is lost, the volume
// stays, and until the wave reaches the ceiling at 0.6 s (where it loses energy) the moment about the pivot does the work that
// the water gains, -Int M dangle = K + P. Measured: within 3 % of the kinetic energy, volume 0.6 %. Seen to fail with the
// normals of the walls left unturned, and with the moment about the origin.
TEST(RollingTank, KeepsItsWaterAndDoesItsWork) {
  const auto angle = [](double t) { return 0.075 * (1 - std::cos(5.17 * t)); };
  WallCase wall = tank({-0.45, 0, 0}, {0.45, 0.4, 0}, {});
  wall.motion.emplace();
  wall.motion->rotation = Expression("0.075*(1-cos(5.17*t))");
  wall.motion->pivot = {0, -0.2, 0};
  Fluid<2> fluid(scene(2, 0.02, {box({-0.45, 0, 0}, {0.45, 0.3, 0})}, {wall}));
  double work = 0, last = 0, drift = 0, kinetic = 0, difference = 0;
  run(fluid, 1.6, [&] {
    const double now = seconds(fluid.state().time);
    drift = std::max(drift, std::abs(fluid.volume_drift().inside));
    if (now > 0.55) return;
    work -= Probe<2>(fluid, Moment::middle).force(fluid.walls().find("tank"), Vector<2>(0, -0.2)).value().moment[2] *
            (angle(now) - angle(last));
    last = now;
    const Energies energies = fluid.energies();
    kinetic = std::max(kinetic, energies.kinetic);
    difference = std::max(difference, std::abs(work - energies.kinetic - energies.potential));
  });
  EXPECT_EQ(fluid.leaked() + fluid.removed(), 0u);
  EXPECT_LT(drift, 0.01);
  EXPECT_GT(kinetic, 8);
  EXPECT_LT(difference / kinetic, 0.06);
}

}  // namespace
}  // namespace tern::fluid::testing
