// The projection: second order in the step, nothing thrown back by an impact, and what one solve leaves behind.

#include <gtest/gtest.h>

#include "base/step_control.hpp"
#include "fixtures/fluid_scenes.hpp"
#include "fluid/pressure/divergence.hpp"
#include "fluid/pressure/pressure_gradient.hpp"

namespace tern::fluid::testing {
namespace {

/// Kinetic energy of inviscid vortices after 0.1 of a unit of time in so many equal steps, without what is not the projection.
double energy_of_vortices(int steps) {
  Case c = vortices(2, 48);
  c.fluid->numerics.noise_damping = 0;
  c.fluid->numerics.density_relaxation = 0;
  c.fluid->numerics.shifting = 0;
  Fluid<2> fluid(c);
  for (int n = 0; n < steps; ++n) step(fluid, 0.1 / steps);
  return fluid.energies().kinetic;
}

// 32 steps lose 6e-6 more than 128. Seen to fail: without tr(L L) in the target (4.4e-3 more), without the correction for what is left
// behind (2.1e-4 more).
TEST(Projection, TakesHardlyAnythingOfATurningMotion) {
  const double coarse = energy_of_vortices(32), fine = energy_of_vortices(128);
  std::printf("[ energy %.6f %.6f ]\n", coarse, fine);
  EXPECT_NEAR(coarse / fine, 1, 5e-5);
}

/// What is left of the energy of a slab of water that fills a tank from side to side and hits its end, or another slab.
double left_of_an_impact(double gap, bool two) {
  std::vector<Shape> slabs = {box({1 - gap, 0, 0}, {2 - gap, 0.5, 0})};
  if (two) slabs = {box({0.5 - gap, 0, 0}, {1.5 - gap, 0.5, 0}), box({1.5 + gap, 0, 0}, {2.5 + gap, 0.5, 0})};
  Case c = scene(2, 0.025, slabs, {tank({0, 0, 0}, {two ? 3.0 : 2.0, 0.5, 0}, {})}, 0);
  c.fluid->bodies[0].velocity = {Expression("1"), Expression(), Expression()};
  if (two) c.fluid->bodies[1].velocity = {Expression("-1"), Expression(), Expression()};
  Fluid<2> fluid(c);
  const double before = fluid.energies().kinetic;
  StepControl control;  // as the processes have it: windows grow by a tenth at most
  for (Ticks now = 0, end = to_ticks(gap + 0.1); now < end; now = fluid.state().time)
    step(fluid, seconds(control.next(fluid.propose_step().seconds, now, end)));
  return fluid.energies().kinetic / before;
}

// Up to 0.2 % is kept. Seen to fail: with the particles kept in order by up to twenty layers of the pressure's gradient, in place of what
// the window resolves (15 %; without any bound the run stops), and with the rate of div u measured from window to window in place of
// -tr(L L) (76 %).
TEST(Projection, GivesBackHardlyAnythingOfAnImpact) {
  for (const bool two : {false, true})
    for (const double gap : {0.1, 0.1017, 0.1035, 0.1043, 0.105, 0.1072}) {
      const double left = left_of_an_impact(gap, two);
      std::printf("[ %d, gap %g: kept %.5f ]\n", two, gap, left);
      EXPECT_LT(left, 0.01);
    }
}

/// Root mean square of div u that the pressure of a window leaves in a wave, over that which it met.
double left_in_a_wave(int particles) {
  Case c = scene(2, 1.0 / particles, {water_with_wave(1, 0.08)}, {tank({0, 0, 0}, {1, 2, 0})});
  c.fluid->numerics.density_relaxation = 0;
  Fluid<2> fluid(c);
  run(fluid, 0.25, [] {});
  const Ticks window = to_ticks(fluid.propose_step().seconds);
  ByAxis<2> packed;
  const auto divergence_of = [&](const std::vector<Vector<2>>& velocity) {
    std::vector<double> divergence;
    compute_divergence<2>(fluid.period(), fluid.neighbours(), fluid.boundary(), fluid.correction(), fluid.state().particle_class, velocity,
                          nullptr, packed, divergence);
    double sum = 0;
    for (double d : divergence) sum += d * d;
    return std::sqrt(sum);
  };
  fluid.begin_window(fluid.state().time, window);
  fluid.see_surface({});
  std::vector<Vector<2>> velocity = fluid.prediction().velocity;
  const double met = divergence_of(velocity);
  fluid.solve_pressure({});
  apply_pressure_gradient<2>(fluid.reference(), seconds(window), fluid.neighbours(), fluid.boundary(), fluid.correction(), fluid.state(),
                             nullptr, velocity, nullptr);
  return divergence_of(velocity) / met;
}

// Measured: 0.140. Seen to fail: without the correction for what is left behind (0.206).
TEST(Projection, LeavesLessOfTheDivergenceOfAWaveThanOneSolve) {
  const double left = left_in_a_wave(40);
  std::printf("[ left %.4f ]\n", left);
  EXPECT_LT(left, 0.17);
}

// The longest step that a case may ask for. Seen to fail: with the whole of the correction whatever it leaves (the run stops).
TEST(Projection, StaysBoundedAtTheLongestStep) {
  Case c = vortices(2, 50);
  c.fluid->numerics.noise_damping = 0;
  c.fluid->numerics.shifting = 4;
  c.fluid->numerics.courant = 0.5;
  Fluid<2> fluid(c);
  const double before = fluid.energies().kinetic;
  run(fluid, 0.25, [&] { EXPECT_LT(fluid.energies().kinetic, 1.02 * before); });
}

// 0.7 on the mean. Seen to fail: started from the pressure with what answers another source (2.0), and solved to a residual of 1e-3 (1.7).
TEST(Projection, SolvesForThePressureOfAWaveInOneIteration) {
  Fluid<2> fluid(scene(2, 1.0 / 40, {water_with_wave(1, 0.08)}, {tank({0, 0, 0}, {1, 2, 0})}));
  step(fluid, fluid.propose_step().seconds);
  int windows = 0, iterations = 0;
  run(fluid, 0.5, [&] { ++windows, iterations += fluid.last_solve().iterations; });
  std::printf("[ %d windows, %d iterations ]\n", windows, iterations);
  EXPECT_LT(iterations, 1.3 * windows);
}

}  // namespace
}  // namespace tern::fluid::testing
