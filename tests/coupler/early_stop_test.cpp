// What staggering makes is found by name within a few windows, and nothing sound is taken for it.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "coupler/interface_energy.hpp"
#include "coupler/load_alternation.hpp"
#include "tests/coupler/coupled_scenes.hpp"

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

// Seen to fail: with the cosine at -0.6 (noise), without the mean (small ripple), without the growth (ring that dies out), with -1.1
// (nothing is found).
TEST(LoadAlternation, IsFoundOnlyWhereTheLoadTurnsRoundAgainAndAgain) {
  EXPECT_EQ(found([](int n, int k) { return 1 + 0.01 * std::pow(1.5, n) * sign(n) * std::sin(0.1 * k + 0.2); }), 11);
  EXPECT_EQ(found([](int n, int) { return n > 20 ? 2 * sign(n) : 0; }), 26);
  // What windows resolve, six to a period, as violent as may be.
  EXPECT_EQ(found([](int n, int k) { return std::pow(1.1, n) * std::sin(n * std::numbers::pi / 3) * (k + 1); }), 0);
  // A ripple that is smaller than what it is laid on.
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

/// What a plate in a tank stops with, and how fast anything was until then, over sqrt(g H).
CoupledOutcome explicitly(double density_ratio) { return run({density_ratio, 4, 1e7, 1, CouplingAlgorithm::cm0}, 0.06); }

// Seen to fail without check_alternation() (bounded speeds up to 8 sqrt(gH), no message).
TEST(EarlyStop, NamesExplicitStaggeringThatMakesItsOwnLoad) {
  const CoupledOutcome outcome = explicitly(1);
  EXPECT_EQ(outcome.verdict, CoupledOutcome::Verdict::stopped);
  for (const char* part : {"turns round from window to window", "'plate'", "t = 0.0", "limit", "coupling.algorithm = \"CM2\""})
    EXPECT_NE(outcome.message.find(part), std::string::npos) << part << " in: " << outcome.message;
  EXPECT_LT(outcome.largest_speed, 10 * 0.22);  // 0.22 with CM2
}

}  // namespace
}  // namespace tern::coupler::testing
