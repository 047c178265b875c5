// Lists of neighbours against all pairs of particles.

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

/// Pairs nearer than the support that a list lacks or has twice, and others that it has. Pairs as far from each other as the support
/// reaches may be in it or not.
template <int D>
int wrong_pairs(const Fluid<D>& fluid) {
  const std::vector<Vector<D>>& x = fluid.prediction().position;
  const double support = fluid.constants().kernel.support();
  int wrong = 0;
  std::vector<int> listed(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    std::fill(listed.begin(), listed.end(), 0);
    fluid.neighbours().for_each(static_cast<std::ptrdiff_t>(i), [&](int j, float) { ++listed[j]; });
    for (std::size_t j = 0; j < x.size(); ++j) {
      const double distance = (x[j] - x[i]).norm() / support;
      if (i == j || std::abs(distance - 1) > 1e-3) wrong += listed[j] != (i != j && distance < 1);
    }
  }
  return wrong;
}

/// Of water in disorder, this many spacings long and twelve thick.
template <int D>
int wrong_pairs_of_water(int length) {
  constexpr double dx = 0.01;
  Fluid<D> fluid(scene(D, dx, {box({0, 0, 0}, {length * dx, 12 * dx, D == 3 ? 12 * dx : 0})}, {tank({-1, -1, -1}, {2, 1, 1})}));
  std::mt19937 random(3);
  jitter(fluid, 1, random);
  fluid.begin_window(0, to_ticks(1e-6));
  return wrong_pairs(fluid);
}

// A row has more candidates than are tested at a time, in 3D at all times. Seen red: with groups that end with what was found among these
// though they reach further (3D).
TEST(Pairs, AreAllWithinTheSupport) {
  EXPECT_EQ(wrong_pairs_of_water<2>(60), 0);
  EXPECT_EQ(wrong_pairs_of_water<3>(30), 0);
}

// The first points of a row come right after the last of the row before. Seen red: with groups that keep what lies beyond the end of a row.
TEST(Pairs, OfAColumnNarrowerThanTheSupportAreFoundOnce) {
  EXPECT_EQ(wrong_pairs_of_water<2>(2), 0);
  EXPECT_EQ(wrong_pairs_of_water<3>(2), 0);
}

}  // namespace
}  // namespace tern::fluid::testing
