// Window lengths: targets are met exactly and no step is much shorter or longer than the one before.

#include "base/step_control.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace tern {
namespace {

constexpr unsigned seed = 20240117;

/// Steps taken from 0 through all targets, in ticks; `propose` gives the proposal of each step [s].
template <class Propose>
std::vector<Ticks> steps_through(const std::vector<Ticks>& targets, Propose&& propose) {
  StepControl control;
  std::vector<Ticks> steps;
  Ticks now = 0;
  for (Ticks target : targets) {
    while (now < target) {
      steps.push_back(control.next(propose(), now, target));
      now += steps.back();
      EXPECT_GT(steps.back(), 0);
      if (steps.size() > 100000) return steps;
    }
    EXPECT_EQ(now, target);
  }
  return steps;
}

std::vector<Ticks> random_targets(std::mt19937& random, int count, double least, double most) {
  std::uniform_real_distribution<double> interval(least, most);
  std::vector<Ticks> targets;
  double t = 0;
  for (int k = 0; k < count; ++k) targets.push_back(to_ticks(t += interval(random)));
  return targets;
}

// Seen to fail: with the last step rounded to a whole proposal instead of the remaining ticks.
TEST(StepControl, LandsExactlyOnEveryTargetForAnyProposals) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::lognormal_distribution<double> proposal(std::log(1e-3), 0.7);
  steps_through(random_targets(random, 300, 1e-4, 2e-2), [&] { return proposal(random); });
}

// Seen to fail: with the steps ahead of a target not stretched evenly (steps_ahead = 0), so that a sliver remains.
TEST(StepControl, NeverHalvesTheStepWhileProposalsAreSteady) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const auto steps = steps_through(random_targets(random, 500, 1e-3, 3e-2), [] { return 1e-3; });
  for (std::size_t k = 1; k < steps.size(); ++k) ASSERT_GE(seconds(steps[k]), (0.5 - 1e-5) * seconds(steps[k - 1])) << "step " << k;
}

// One proposal of next to nothing shortens a window to a tick. A tenth of that is none, and windows grow all the same.
// Seen to fail: with a tenth alone (windows of a tick for ever).
TEST(StepControl, GrowsFromASingleTick) {
  int step = 0;
  const auto steps = steps_through({to_ticks(0.1)}, [&] { return ++step == 5 ? 1e-12 : 1e-3; });
  EXPECT_LT(steps.size(), 400u);
  EXPECT_GT(seconds(*std::max_element(steps.begin(), steps.end() - 1)), 0.9e-3);
}

// Seen to fail: without the count, with which such a run goes on for years.
TEST(StepControl, KnowsThatItCrawls) {
  StepControl control;
  const auto windows_until_it_crawls = [&](auto&& proposal) {
    for (int k = 1; k <= 500; ++k) {
      control.next(proposal(k), 0, to_ticks(1));
      if (control.crawls()) return k;
    }
    return 0;
  };
  EXPECT_EQ(windows_until_it_crawls([](int k) { return k % 50 == 0 ? 1e-3 : 1e-12; }), 0);
  EXPECT_EQ(windows_until_it_crawls([](int) { return 1e-12; }), 100);
}

// From rest the first proposal counts alone; later ones may exceed the step before by 10 %, and by 10 % more to meet a
// target. Seen to fail: without the limit on growth.
TEST(StepControl, GrowsByNoMoreThanTenPercentTwice) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::lognormal_distribution<double> proposal(std::log(1e-3), 1.0);
  const auto steps = steps_through(random_targets(random, 300, 2e-3, 5e-2), [&] { return proposal(random); });
  ASSERT_GT(steps.size(), 1000u);
  for (std::size_t k = 1; k < steps.size(); ++k) ASSERT_LE(seconds(steps[k]), (1.21 + 1e-5) * seconds(steps[k - 1])) << "step " << k;
}

// Seen to fail: with the proposal stretched by 1.3 to meet a target.
TEST(StepControl, ExceedsAProposalByNoMoreThanTenPercent) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::lognormal_distribution<double> distribution(std::log(1e-3), 0.5);
  std::vector<double> proposals;
  const auto steps = steps_through(random_targets(random, 200, 1e-3, 2e-2), [&] {
    proposals.push_back(distribution(random));
    return proposals.back();
  });
  for (std::size_t k = 0; k < steps.size(); ++k) ASSERT_LE(seconds(steps[k]), 1.1 * proposals[k] + 2 / ticks_per_second) << "step " << k;
}

// Windows that are repeated: by and by to their length, which doubles when a hundred have gone well. Seen to fail: at once to that
// length; with a share of the proposal, which a window in a run that grows by a tenth each time never meets.
TEST(StepControl, ShortensByAndByAndDoublesAfterAHundred) {
  for (const double proposal : {1e-3, 1.0}) {
    StepControl control;
    const Ticks far = to_ticks(1e3), failed = to_ticks(0.01);
    EXPECT_EQ(control.next(1e-3, 0, far), to_ticks(1e-3));
    control.shorten(1, failed, 0.25e-3);
    std::vector<double> steps;
    for (int k = 0; k < 50; ++k) steps.push_back(seconds(control.next(proposal, 0, far)) / 1e-3);
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(steps[k], std::pow(0.8, k + 1), 1e-5) << k;
    for (int k = 7; k < 50; ++k) ASSERT_NEAR(steps[k], 0.25, 1e-5) << k;
    for (int k = 0; k < 100; ++k) ASSERT_NEAR(seconds(control.next(proposal, failed, far)) / 1e-3, 0.25, 1e-5) << k;
    EXPECT_EQ(control.halvings(), 1);
    ASSERT_NEAR(seconds(control.next(proposal, failed, far)) / 1e-3, 0.275, 1e-5);
    EXPECT_EQ(control.halvings(), 0);
  }
}

TEST(StepControl, ShortensAtOnceWhereByAndByHasNotHelped) {
  StepControl control;
  const Ticks far = to_ticks(1e3);
  control.next(1e-3, 0, far);
  control.shorten(2, 0, 0.25e-3);
  for (int k = 0; k < 100; ++k) ASSERT_EQ(control.next(1e-3, 0, far), to_ticks(0.25e-3)) << k;
  double step = 0;
  for (int k = 0; k < 100; ++k) step = seconds(control.next(1e-3, 0, far));
  EXPECT_NEAR(step, 0.5e-3, 1e-8);
  EXPECT_EQ(control.halvings(), 1);
}

TEST(StepControl, AShortenedFirstWindowIsShortAtOnce) {
  StepControl control;
  control.shorten(3, 0, 1e-3);
  EXPECT_EQ(control.next(8e-3, 0, to_ticks(1e3)), to_ticks(1e-3));
}

}  // namespace
}  // namespace tern
