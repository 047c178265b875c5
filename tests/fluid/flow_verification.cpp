// Verification of the fluid in motion against solutions of inviscid flow.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

constexpr unsigned seed = 20240121;

Vector<2> centroid(const Fluid<2>& fluid) {
  Vector<2> sum = Vector<2>::Zero();
  for (const auto& x : fluid.state().position) sum += x;
  return sum / static_cast<double>(fluid.state().size());
}

// Bands per unit of rho g H^2 L, rho g, rho g H and H. Measured: kinetic energy 1.7e-5, slope 0.998, noise 6e-4,
// centroid 7e-4 higher. Energy is taken from 1.5 s on, when the disorder has settled. Seen to fail: with the factor 2
// of the wall flux left out, with the hydrostatic part of the walls left out, and with the density source of the wrong
// sign. Blind to: the density source and theta set to 0.
TEST(HydrostaticTank, StaysAtRestForTwoSecondsFromTenPercentDisorder) {
  Fluid<2> fluid(scene(2, 0.05, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {1, 2, 0})}));
  std::mt19937 random(seed);
  jitter(fluid, 0.1, random);
  const double start = centroid(fluid)[1];
  double slope = 0, noise = 0, kinetic = 0;
  int samples = 0;
  run(fluid, 2.0, [&] {
    if (seconds(fluid.state().time) < 1.5) return;
    const PressureLine line = fit_pressure(fluid, 0.9);
    slope += line.slope / (-density * gravity);
    noise += line.noise / (density * gravity);
    kinetic = std::max(kinetic, fluid.energies().kinetic / (density * gravity));
    ++samples;
  });
  slope /= samples, noise /= samples;
  EXPECT_LT(kinetic, 5e-4);
  EXPECT_NEAR(slope, 1, 0.015);
  EXPECT_LT(noise, 0.01);
  EXPECT_NEAR(centroid(fluid)[1], start, 0.005);
  EXPECT_EQ(fluid.leaked() + fluid.removed(), 0u);
}

/// Energy per density of a column that collapses in a tank, in steps of 0.3 ms to 0.1 s; `flying`: a blob of water flies upwards at 25 m/s,
/// 1.6 m above it and more.
double energy_of_a_collapse(bool flying) {
  std::vector<Shape> bodies = {box({0, 0, 0}, {0.2, 0.4, 0})};
  if (flying) bodies.push_back(box({0.3, 2, 0}, {0.4, 2.1, 0}));
  Case c = scene(2, 0.02, bodies, {tank({0, 0, 0}, {0.8, 8, 0})});
  if (flying) c.fluid->bodies[1].velocity[1] = Expression("25");
  Fluid<2> fluid(c);
  const std::size_t column = 200;
  for (int n = 0; n < 333; ++n) step(fluid, 3e-4);
  double energy = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i)
    if (fluid.state().id[i] < column) energy += 0.5 * 4e-4 * fluid.state().velocity[i].squaredNorm();
  return energy;
}

// The same to what the pressure is solved to. Seen to fail: with the damping of noise, or the density source, at the rate of the
// largest speed of the scene.
TEST(Tank, IsTheSameUnderWaterThatFliesBy) {
  const double alone = energy_of_a_collapse(false), beside = energy_of_a_collapse(true);
  std::printf("[ energy %.6g and %.6g ]\n", alone, beside);
  EXPECT_NEAR(beside / alone, 1, 1e-4);
}

// Deep in particles: the regularising part of the gradient may not outweigh the projection where the pressure is high.
// Without its limit the run fails in its first steps. Measured with it: 12 times the static pressure in the first steps,
// then calm. Seen to fail: without the limit.
TEST(HydrostaticTank, StandsTenPercentDisorderOverHundredAndSixtyLayers) {
  Fluid<2> fluid(scene(2, 1.0 / 160, {box({0, 0, 0}, {0.125, 1, 0})}, {tank({0, 0, 0}, {0.125, 1.2, 0})}));
  std::mt19937 random(seed);
  jitter(fluid, 0.1, random);
  double largest = 0;
  run(fluid, 0.03, [&] {
    for (double p : fluid.state().pressure) largest = std::max(largest, p);
  });
  std::printf("[ largest pressure %.2f of the static one ]\n", largest / (density * gravity));
  EXPECT_LT(largest, 20 * density * gravity);
  EXPECT_LT(fluid.largest_speed(), 0.1 * std::sqrt(gravity));
}

// Linear theory: omega^2 = g k tanh(kH). Measured: half period 0.579 s, amplitudes of the following turns 0.848 and
// 0.825 of the first, height of the centroid within 0.0017 (the energy of the wave itself moves it by 0.0016). Seen to
// fail: with the density source of the wrong sign, and with a tenth of the missing part of a support in c_i.
// Blind to: the gradient uncorrected, the density source off.
TEST(StandingWave, KeepsItsPeriodAmplitudeAndVolume) {
  const double pi = std::numbers::pi;
  Fluid<2> fluid(scene(2, 0.04, {water_with_wave(1, 0.08)}, {tank({0, 0, 0}, {1, 2, 0})}));
  const Vector<2> start = centroid(fluid);
  const double omega = std::sqrt(gravity * pi * std::tanh(pi)), period = 2 * pi / omega;
  // The horizontal centroid swings about the middle; its turning points give half periods and amplitudes.
  std::vector<double> times{0}, x{start[0] - 0.5};
  double vertical = 0;
  run(fluid, 1.2 * period, [&] {
    times.push_back(seconds(fluid.state().time));
    x.push_back(centroid(fluid)[0] - 0.5);
    vertical = std::max(vertical, std::abs(centroid(fluid)[1] - start[1]));
  });
  std::vector<std::pair<double, double>> turns;
  const double sign = x[0] > 0 ? 1 : -1;
  for (int half = 1; half <= 2; ++half) {
    std::pair<double, double> best{0, 0};
    for (std::size_t k = 0; k < x.size(); ++k) {
      const double value = x[k] * sign * (half == 1 ? -1 : 1);
      if (std::abs(times[k] - half * period / 2) < 0.25 * period && value > best.second) best = {times[k], value};
    }
    turns.push_back(best);
  }
  const double start_size = std::abs(x[0]);
  EXPECT_NEAR(turns[0].first, 0.567, 0.06 * 0.567);
  EXPECT_GT(turns[1].second / start_size, 0.8);
  EXPECT_LT(vertical, 0.01);
}

// At the start lap p = 2 rho omega^2 with p = 0 on the edge: p = -0.1473 rho omega^2 L^2 in the middle (torsion
// function of the square). Measured -0.1484. Seen to fail: with a tenth of the missing part of a support in c_i, and
// with edges 1.2 |w'|/r in place of 2 |w'|/r.
TEST(RotatingSquarePatch, HasTheCentrePressureOfTheTorsionFunction) {
  Case c = scene(2, 0.02, {box({-0.5, -0.5, 0}, {0.5, 0.5, 0})}, {}, 0);
  c.fluid->bodies[0].velocity = {Expression("2*y"), Expression("-2*x"), Expression()};
  Fluid<2> fluid(c);
  // The first step has only half a step behind it since the velocity was last solenoidal, hence half the pressure.
  step(fluid, 1e-4);
  solve(fluid, 1e-4);
  const double unit = density * 2 * 2;
  EXPECT_NEAR(fluid.pressure_at(Vector<2>::Zero()).value() / unit, -0.1473, 0.02 * 0.1473);
}

/// Prints an error at one spacing and the order since the one before.
struct Convergence {
  double spacing = 0, error = 0;
  void add(const char* what, double next_spacing, double next_error) {
    std::printf("[ %s at dx = %.4g m: %.3e", what, next_spacing, next_error);
    if (error > 0) std::printf(", order %.2f", std::log(error / next_error) / std::log(spacing / next_spacing));
    std::printf(" ]\n");
    spacing = next_spacing, error = next_error;
  }
};

// L2 error of the pressure over rho g H after two seconds from the lattice. Seen to fail: with the hydrostatic part of the
// walls left out.
TEST(HydrostaticTank, ConvergesWithTheSpacing) {
  Convergence convergence;
  double coarsest = 0;
  for (double dx : {0.1, 0.05, 0.025}) {
    Fluid<2> fluid(scene(2, dx, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {1, 1.5, 0})}));
    run(fluid, 2.0, [] {});
    double sum = 0;
    for (std::size_t i = 0; i < fluid.state().size(); ++i)
      sum += std::pow(fluid.state().pressure[i] / (density * gravity) - (1 - fluid.state().position[i][1]), 2);
    convergence.add("tank, L2 error of p over rho g H", dx, std::sqrt(sum / static_cast<double>(fluid.state().size())));
    if (coarsest == 0) coarsest = convergence.error;
  }
  EXPECT_LT(convergence.error, 0.4 * coarsest);
  EXPECT_LT(convergence.error, 0.01);
}

// The wave of cases/standing_wave: share of the first harmonic, sum y cos(kx), that is lost after two periods.
TEST(StandingWave, LosesLessWithTheSpacing) {
  const double k = std::numbers::pi;
  const double period = 1.0124 * 2 * std::numbers::pi / std::sqrt(gravity * k * std::tanh(k));
  Convergence convergence;
  for (double dx : {0.08, 0.04, 0.025}) {
    Fluid<2> fluid(scene(2, dx, {water_with_wave(2, 0.1)}, {tank({0, 0, 0}, {2, 2, 0})}));
    const auto harmonic = [&] {
      double sum = 0;
      for (const auto& x : fluid.state().position) sum += x[1] * std::cos(k * x[0]);
      return sum;
    };
    const double first = harmonic();
    double last = 0;
    run(fluid, 2.2 * period, [&] {
      if (seconds(fluid.state().time) > 1.8 * period) last = std::max(last, harmonic());
    });
    convergence.add("standing wave, share lost in two periods", dx, 1 - last / first);
  }
  EXPECT_LT(convergence.error, 0.06);
}

// 8 000 particles in 2D, 3 500 in 3D, in the collapse; the small one in pressure_solve_test.cpp goes through the impact, and
// bench/fluid_step through larger ones: 5.3 on the mean and 6 at most for 20 000 to 0.30 s. The count hardly grows with the
// number of particles.
TEST(PressureSolve, TakesFewIterationsInALargeDamBreakOnABlock) {
  const auto expect_few = [](const std::string& dimensions, auto fluid, double until) {
    const Iterations iterations = count_iterations(fluid, until);
    RecordProperty(dimensions + "_mean", std::to_string(iterations.mean()));
    RecordProperty(dimensions + "_most", iterations.most);
    EXPECT_LE(iterations.mean(), 8);
    EXPECT_LE(iterations.most, 12);
    EXPECT_EQ(fluid.fallback_solves(), 0);
  };
  expect_few("in_2d", Fluid<2>(solved_to(1e-6, dam_break_on_block(2, 0.2 / 63))), 0.05);
  expect_few("in_3d", Fluid<3>(solved_to(1e-6, dam_break_on_block(3, 0.2 / 12))), 0.05);
}

}  // namespace
}  // namespace tern::fluid::testing
