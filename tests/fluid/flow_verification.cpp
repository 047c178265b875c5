// Verification of the fluid in motion against solutions of inviscid flow.

#include <gtest/gtest.h>

#include "tests/fluid/scenes.hpp"

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

// Linear theory: omega^2 = g k tanh(kH). Measured: half period 0.579 s, amplitudes of the following turns 0.848 and
// 0.825 of the first, height of the centroid within 0.0017 (the energy of the wave itself moves it by 0.0016). Seen to
// fail: with the density source of the wrong sign, and with a tenth of the missing part of a support in c_i.
// Blind to: the gradient uncorrected, the density source off.
TEST(StandingWave, KeepsItsPeriodAmplitudeAndVolume) {
  constexpr double amplitude = 0.08;
  const double pi = std::numbers::pi;
  Shape water;
  water.kind = Shape::Kind::polygon;
  water.vertices = {{0, 0}, {1, 0}};
  for (int k = 200; k >= 0; --k) water.vertices.push_back({k / 200.0, 1 + amplitude * std::cos(pi * k / 200.0)});
  Fluid<2> fluid(scene(2, 0.04, {water}, {tank({0, 0, 0}, {1, 2, 0})}));
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

// At the first instant lap p = 2 rho omega^2 with p = 0 on the edge: p = -0.1473 rho omega^2 L^2 in the middle (torsion
// function of the square). Measured -0.1484. Seen to fail: with a tenth of the missing part of a support in c_i, and
// with edges 1.2 |w'|/r in place of 2 |w'|/r.
TEST(RotatingSquarePatch, HasTheCentrePressureOfTheTorsionFunction) {
  Case c = scene(2, 0.02, {box({-0.5, -0.5, 0}, {0.5, 0.5, 0})}, {}, 0);
  c.fluid->bodies[0].velocity = {Expression("2*y"), Expression("-2*x"), Expression()};
  Fluid<2> fluid(c);
  solve(fluid, 1e-4);
  const double unit = density * 2 * 2;
  EXPECT_NEAR(fluid.pressure_at(Vector<2>::Zero()).value() / unit, -0.1473, 0.02 * 0.1473);
}

}  // namespace
}  // namespace tern::fluid::testing
