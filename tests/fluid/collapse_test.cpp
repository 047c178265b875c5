// A step that has collapsed because of one particle.

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

/// Windows a drop in free flight is let run for, after which it is stopped; its speed is a multiple of the reference speed that
/// the rest of the scene has, water of 0.1 m at rest. 0: not stopped in twenty.
int windows_until_stopped(double multiple, std::string& message) {
  Fluid<2> fluid(scene(2, 0.01, {box({0, 0, 0}, {0.1, 0.1, 0})}, {tank({0, 0, 0}, {0.1, 0.1, 0})}));
  State<2> state = fluid.state();
  const double reference = std::sqrt(gravity * 0.1);
  for (std::size_t i = 0; i < state.size(); ++i)
    if (state.position[i][1] > 0.094 && state.position[i][0] > 0.094) {
      state.position[i] = {0.05, 10};
      state.velocity[i] = {0, multiple * reference};
    }
  fluid.set_state(state);
  for (int n = 1; n <= 20; ++n) {
    try {
      step(fluid, fluid.propose_step().seconds);
    } catch (const NumericalFailure& failure) {
      message = failure.what();
      return n;
    }
  }
  return 0;
}

TEST(Collapse, OfTheStepIsNamedWithTheParticleThatAsksForIt) {
  std::string message;
  EXPECT_EQ(windows_until_stopped(20, message), 0) << message;
  EXPECT_EQ(windows_until_stopped(150, message), 10);
  for (const char* part : {"fluid particle 99 at (0.05, 10", "hundred times", "collapsed to", "t = ", "fluid.numerics.courant"})
    EXPECT_NE(message.find(part), std::string::npos) << part << " in: " << message;
  EXPECT_EQ(windows_until_stopped(1500, message), 1);
}

// Without gravity a clamp that starts from rest drives the scene. Seen to fail: without the speed of clamps (0), with which a run whose
// clamp is displaced by t^2/2 was stopped when it had become a hundred times as fast as in its first window.
TEST(Collapse, ReckonsWithTheSpeedOfClamps) {
  Case c = scene(2, 0.01, {box({0, 0, 0}, {0.1, 0.1, 0})}, {tank({0, 0, 0}, {0.1, 0.1, 0})}, 0);
  c.end_time = 0.2;
  c.structure.emplace();
  ClampCase clamp;
  clamp.region = box({0.2, 0, 0}, {0.3, 0.1, 0});
  clamp.motion.emplace();
  clamp.motion->displacement[0] = Expression("0.5*t^2");
  c.structure->clamps.push_back(clamp);
  EXPECT_NEAR(Fluid<2>(c).state().reference_speed, 0.2, 0.002);
}

// A body that a load sets moving drives the scene too. Seen to fail: with the speed of bodies in the first window alone (1e-6).
TEST(Collapse, ReckonsWithBodiesThatAreSetMoving) {
  Fluid<2> fluid(scene(2, 0.01, {box({0, 0, 0}, {0.1, 0.1, 0})}, {tank({0, 0, 0}, {0.1, 0.1, 0})}, 0));
  for (const double speed : {1e-6, 0.5, 0.1}) {
    fluid.begin_window(fluid.state().time, to_ticks(1e-3));
    const InterfaceParticles<2> particles = fluid.see_surface({{{0.105, 0.05}}, {{speed, 0}}, {{1, 0}}, {0.1}});
    InterfaceCondition<2> condition;
    condition.force.assign(particles.id.size(), Vector<2>::Zero());
    condition.reference_pressure = {0};
    fluid.solve_pressure(condition);
    fluid.end_window({std::vector<Vector<2>>(particles.id.size(), Vector<2>::Zero())});
  }
  EXPECT_EQ(fluid.state().reference_speed, 0.5);
}

// A body that slides through still water goes as far in a window as water may, one that flies above it as far as it likes. Seen to fail:
// with the speed of the fluid alone (1 s), and with that of all bodies (0.4 ms).
TEST(Collapse, OfWindowsIsPreventedByTheSpeedOfWetBodies) {
  Fluid<2> fluid(scene(2, 0.01, {box({0, 0, 0}, {0.1, 0.1, 0})}, {tank({0, 0, 0}, {0.1, 0.1, 0})}, 0));
  fluid.begin_window(0, to_ticks(1e-4));
  const InterfaceParticles<2> particles =
      fluid.see_surface({{{0.05, 0.1}, {0.05, 0.3}}, {{3, 0}, {9, 0}}, {{0, -1}, {0, -1}}, {0.02, 0.02}});
  InterfaceCondition<2> condition;
  condition.force.assign(particles.id.size(), Vector<2>::Zero());
  condition.reference_pressure = {0, 0};
  fluid.solve_pressure(condition);
  fluid.end_window({std::vector<Vector<2>>(particles.id.size(), Vector<2>::Zero())});
  const StepProposal proposal = fluid.propose_step();
  EXPECT_NEAR(proposal.seconds, fluid.constants().numerics.courant * fluid.constants().spacing / 3, 1e-9);
  EXPECT_STREQ(proposal.limit, "velocity");
}

/// The window after the third of a scene in which the tank, or nothing, goes along with its water at `speed`.
StepProposal window_of(double speed, bool in_tank, bool beside_a_post, double g = gravity) {
  std::vector<WallCase> walls;
  if (in_tank) {
    walls.push_back(tank({0, 0, 0}, {0.2, 0.2, 0}));
    walls[0].motion.emplace().displacement[0] = Expression(fmt::format("{}*t", speed));
  }
  if (beside_a_post) walls.push_back(obstacle({5, 0, 0}, {6, 1, 0}));
  Case c = scene(2, 0.01, {box({0, 0, 0}, {0.1, 0.1, 0})}, walls, g);
  c.fluid->bodies[0].velocity[0] = Expression(fmt::format("{}{}", speed, in_tank ? "" : "+x"));
  Fluid<2> fluid(c);
  for (int n = 0; n < 3; ++n) step(fluid, 1e-4);
  return fluid.propose_step();
}

// Windows are what motions in the scene ask for, to an observer who goes along with it, as long as all of it does. Seen to fail: with the
// speeds to an observer at rest (windows a fiftieth as long).
TEST(Collapse, OfWindowsIsPreventedForScenesThatMoveAsAWhole) {
  for (const bool in_tank : {true, false}) {
    const StepProposal rest = window_of(0, in_tank, false), moving = window_of(50, in_tank, false);
    EXPECT_NEAR(moving.seconds, rest.seconds, 1e-6 * rest.seconds) << in_tank;
    EXPECT_STREQ(moving.limit, rest.limit);
  }
  EXPECT_NEAR(window_of(50, true, true).seconds, 0.4 * 0.01 / 50, 1e-6) << "it may run against the post";
  const StepProposal without = window_of(50, true, false, 0);
  EXPECT_STREQ(without.limit, "rest");
  EXPECT_EQ(without.seconds, 0.01) << "a hundredth of the run: nothing happens in it";
}

// Gravity that sets in after the start drives the scene, limits its windows and keeps its density. Seen to fail: with gravity at t = 0
// alone (0 for all three, and such a run was stopped in its first windows for its speed).
TEST(Collapse, ReckonsWithGravityThatSetsIn) {
  Case c = scene(2, 0.01, {box({0, 0, 0}, {0.1, 0.1, 0})}, {tank({0, 0, 0}, {0.1, 0.1, 0})}, 0);
  c.end_time = 1;
  c.gravity[0] = Expression("5*sin(10*pi*t)^2");
  const Fluid<2> fluid(c);
  const double fall = std::sqrt(5 * 0.1);
  EXPECT_NEAR(fluid.reference().gravity_size, 5, 0.01);
  EXPECT_NEAR(fluid.state().reference_speed, fall, 0.01 * fall);
  EXPECT_NEAR(fluid.propose_step().seconds, fluid.constants().numerics.gravity_courant * std::sqrt(0.01 / 5), 1e-5);
}

}  // namespace
}  // namespace tern::fluid::testing
