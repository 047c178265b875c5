// What staggering makes is found by name within a few windows, and nothing sound is taken for it.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "coupler/stability/interface_energy.hpp"
#include "coupler/stability/load_alternation.hpp"
#include "fixtures/coupled_scenes.hpp"

namespace tern::coupler::testing {
namespace {

/// Window in which a load of sixty points is found to alternate; 0: in none of two hundred.
int found(const std::function<double(int, int)>& load) {
  LoadAlternation alternation;
  for (int n = 1; n <= 200; ++n) {
    Eigen::VectorXd values(60);
    for (int k = 0; k < values.size(); ++k) values[k] = load(n, k);
    if (alternation.add(values, 1e-3)) return n;
  }
  return 0;
}

double sign(int n) { return n % 2 ? -1 : 1; }

// Seen to fail: with the cosine at -0.6 (noise), without the mean (small ripple), with the mean of two windows (load that passes through
// zero), without the growth (ring that dies out); of vibrations: without them, without their growth (steady one), without the sign of p
// (what windows resolve), without the halves (blow), with the product of a kink and the last one in place of that with the second last.
TEST(LoadAlternation, IsFoundOnlyWhereTheLoadTurnsRoundAgainAndAgain) {
  EXPECT_EQ(found([](int n, int k) { return 1 + 0.01 * std::pow(1.5, n) * sign(n) * std::sin(0.1 * k + 0.2); }), 11);
  EXPECT_EQ(found([](int n, int) { return n > 20 ? 2 * sign(n) : 0; }), 25);
  // A vibration of 2.67 windows that grows by half in seven, and stays below what it is laid on until then; the same, not growing.
  const auto vibration = [](int n, double growth) { return std::pow(growth, n) * std::cos(n * 2 * std::numbers::pi / 2.67); };
  const int grown = found([&](int n, int k) { return 1 + 0.05 * vibration(n, 1.06) * std::sin(0.1 * k + 0.2); });
  EXPECT_GT(grown, 40);
  EXPECT_LT(grown, 80);
  EXPECT_EQ(found([&](int n, int k) { return 2 * vibration(n, 1) * std::sin(0.1 * k + 0.2); }), 0);
  // What windows resolve, six to a period, as violent as may be; and hardly five.
  EXPECT_EQ(found([](int n, int k) { return std::pow(1.1, n) * std::sin(n * std::numbers::pi / 3) * (k + 1); }), 0);
  EXPECT_EQ(found([](int n, int k) { return std::pow(1.1, n) * std::sin(n * std::numbers::pi / 2.4) * (k + 1); }), 0);
  // A ripple that is smaller than what it is laid on, also where that passes through zero.
  EXPECT_EQ(found([](int n, int) { return n - 100 + 2 * sign(n); }), 0);
  EXPECT_EQ(found([](int n, int) { return 1 + 0.5 * sign(n); }), 0);
  // A blow, and the ring after it, of which the interface keeps 0.8 per window.
  EXPECT_EQ(found([](int n, int) { return n == 50 ? 100 : 0; }), 0);
  EXPECT_EQ(found([](int n, int) { return n < 50 ? 0 : 100 * sign(n) * std::pow(0.8, n - 50); }), 0);
  std::mt19937 random(7);
  std::normal_distribution<double> noise;
  EXPECT_EQ(found([&](int, int) { return noise(random); }), 0);
}

// Seen to fail: with all that was made since the start, and without the least.
TEST(InterfaceEnergy, IsFoundWhereTheLastWindowsMadeATenthOfWhatIsThere) {
  InterfaceEnergy steady, sudden, nothing;
  for (int n = 1; n <= 100; ++n) EXPECT_FALSE(steady.add(0.019 * n, 1, 0.01)) << n;  // 0.095 in five windows
  EXPECT_FALSE(sudden.add(-3, 1, 0.01));
  EXPECT_TRUE(sudden.add(-2.8, 1, 0.01));
  EXPECT_NEAR(sudden.made(), 0.2, 1e-12);
  EXPECT_FALSE(nothing.add(0, 1e-4, 0.01));
  EXPECT_FALSE(nothing.add(1e-3, 1e-4, 0.01));
}

void expect_named(const CoupledScene& scene, double healthy_speed, std::vector<std::string> parts, double until = 0.06) {
  SCOPED_TRACE(describe(scene));
  const CoupledOutcome outcome = run(scene, until);
  EXPECT_EQ(outcome.verdict, CoupledOutcome::Verdict::stopped);
  EXPECT_LT(outcome.largest_speed, 10 * healthy_speed);
  for (const auto& part : parts) EXPECT_NE(outcome.message.find(part), std::string::npos) << part << " in: " << outcome.message;
}

// Seen to fail without watch_load() (the first two; bounded speeds, no message), without watch_energy() (the third; the structure
// bursts at two hundred times the speed). Speeds over sqrt(gH) in one pass: 0.12, 0.46, 0.23.
TEST(EarlyStop, NamesExplicitStaggeringWhileTheMotionIsStillSound) {
  const auto staggered = Coupling::explicit_staggering;
  expect_named({10, 4, 3e5, 2, staggered}, 0.12,
               {"'plate' turns round from window to window at t = 0.0", "limit", "coupling.algorithm = \"auto\""});
  expect_named({10, 2, 1e7, 1, staggered}, 0.46, {"'plate' turns round from window to window at t = 0.0", "most near ("});
  // An implicit step, which damps what a window does not resolve, would hold it.
  expect_named({3, 8, 1e9, 2, staggered, 1, false, Integrator::explicit_steps}, 0.1,
               {"'plate' turns round from window to window at t = 0.2", "vibrates faster than the windows"}, 0.4);
  expect_named({0.1, 4, 1e7, 1, staggered}, 0.23, {"The interface has made", "up to t = 0.0", "limit", "coupling.algorithm = \"auto\""});
}

}  // namespace
}  // namespace tern::coupler::testing
