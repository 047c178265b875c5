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

}  // namespace
}  // namespace tern::fluid::testing
