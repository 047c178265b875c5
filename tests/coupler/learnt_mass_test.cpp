// The mass with which a surface answers, from changes of its load and of its acceleration.

#include "coupler/acceleration/learnt_mass.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tern::coupler::testing {
namespace {

constexpr double guess = 7.5;  // kg/m^2

// Seen to fail: with the inverse of the fit.
TEST(LearntMass, IsThatOfEachPointHoweverItsLoadChanges) {
  const std::vector<double> mass{5, 12, 0.9};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> change(-200, 200);
  LearntMass learnt;
  for (int window = 0; window < 10; ++window) {
    std::vector<double> load, acceleration;
    for (double m : mass) {
      load.push_back(change(random));
      acceleration.push_back(load.back() / m);
    }
    learnt.add(load, acceleration);
  }
  for (std::size_t k = 0; k < mass.size(); ++k) EXPECT_NEAR(learnt.at(k, guess), mass[k], 1e-12 * mass[k]);
}

// Seen to fail: with all of a window kept for ever (5.8 after twenty).
TEST(LearntMass, FollowsABodyWhoseAnswerChanges) {
  LearntMass learnt;
  for (int window = 0; window < 50; ++window) learnt.add({100}, {100 / 5.0});
  for (int window = 0; window < 20; ++window) learnt.add({100}, {100 / 10.0});
  EXPECT_NEAR(learnt.at(0, guess), 10, 0.2);
}

// A wall that does not yield, a face that answers against its load, a dry point, and a change that drowns in those of others.
// Seen to fail: without the bounds (infinite, negative); without the least change of a load that counts.
TEST(LearntMass, StaysNearTheGuessWhereNothingSoundIsKnown) {
  LearntMass learnt;
  EXPECT_EQ(learnt.at(0, guess), guess) << "before the first window";
  for (int window = 0; window < 3; ++window) learnt.add({100, 100, 0, 0.1, 100}, {0, -20, 0, 1e6, 1e9});
  EXPECT_EQ(learnt.at(0, guess), 4 * guess);
  EXPECT_EQ(learnt.at(1, guess), 4 * guess);
  EXPECT_EQ(learnt.at(2, guess), guess);
  EXPECT_EQ(learnt.at(3, guess), guess);
  EXPECT_EQ(learnt.at(4, guess), 0.05 * guess);
}

}  // namespace
}  // namespace tern::coupler::testing
