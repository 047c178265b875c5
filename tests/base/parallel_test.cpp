// Reductions must not depend on the number of threads, to the last bit.

#include "base/parallel.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include <bit>
#include <cstdint>
#include <limits>
#include <random>

#include "base/vector.hpp"

namespace tern {
namespace {

// Numbers of very different size and both signs: any other order of additions shows in the last bits.
std::vector<double> uneven_numbers(std::size_t n) {
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> exponent(-12, 12), sign(-1, 1);
  std::vector<double> values(n);
  for (double& v : values) v = std::copysign(std::exp(exponent(generator)), sign(generator));
  return values;
}

template <class Reduction>
void expect_same_bits_for_any_thread_count(Reduction&& reduce) {
  omp_set_num_threads(1);
  const auto one = std::bit_cast<std::uint64_t>(reduce());
  for (const int threads : {2, 3, 4}) {
    omp_set_num_threads(threads);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(reduce()), one) << threads << " threads";
  }
  omp_set_num_threads(1);
}

// Seen to fail with `#pragma omp parallel for reduction(+)` in place of the ordered block sums.
TEST(OrderedReductions, GiveTheSameBitsForAnyThreadCount) {
  const auto values = uneven_numbers(100'003);
  const auto n = std::ssize(values);
  expect_same_bits_for_any_thread_count([&] { return ordered_sum(values); });
  expect_same_bits_for_any_thread_count([&] { return ordered_dot(values, values); });
  const auto term = [&](std::ptrdiff_t i) { return values[static_cast<std::size_t>(i)]; };
  expect_same_bits_for_any_thread_count([&] { return ordered_reduce(n, 0.0, term); });
  expect_same_bits_for_any_thread_count([&] { return ordered_max(n, 0.0, term); });
}

// Seen to fail with `end = (block + 1) * reduction_block - 1`, which drops the last index of every block.
TEST(OrderedReductions, CountEveryIndexOnceAroundTheBlockAndThreadLimits) {
  for (const std::ptrdiff_t n : {std::ptrdiff_t{0}, std::ptrdiff_t{1}, reduction_block - 1, reduction_block, reduction_block + 1,
                                 parallel_threshold - 1, parallel_threshold, parallel_threshold + 1, std::ptrdiff_t{50'001}}) {
    std::vector<double> index(static_cast<std::size_t>(n));
    for (std::size_t i = 0; i < index.size(); ++i) index[i] = static_cast<double>(i);
    const double expected = 0.5 * static_cast<double>(n) * static_cast<double>(n - 1);  // exact in a double
    EXPECT_EQ(ordered_sum(index), n > 0 ? expected : 0.0) << n;
    EXPECT_EQ(ordered_reduce(n, 0.0, [](std::ptrdiff_t i) { return static_cast<double>(i); }), n > 0 ? expected : 0.0);
    EXPECT_EQ(ordered_dot(index, std::vector<double>(index.size(), 2.0)), n > 0 ? 2 * expected : 0.0);
    EXPECT_EQ(ordered_max(n, -1.0, [](std::ptrdiff_t i) { return static_cast<double>(i); }), static_cast<double>(n) - 1);
  }
}

// Seen to fail with the block results added from the second block on.
TEST(OrderedReductions, AddVectors) {
  const Vector<3> sum =
      ordered_reduce(20'000, Vector<3>(Vector<3>::Zero()), [](std::ptrdiff_t i) { return Vector<3>(1.0, static_cast<double>(i), -2.0); });
  EXPECT_EQ(sum, Vector<3>(20'000, 20'000.0 * 19'999.0 / 2, -40'000));
}

// Seen to fail with std::max as the combination: it drops a not-a-number on one of its sides.
TEST(OrderedReductions, MaximumShowsANotANumberWhereverItStands) {
  for (const std::ptrdiff_t bad : {0, 500, 1023, 1024, 29'999}) {
    const double largest = ordered_max(
        30'000, 0.0, [bad](std::ptrdiff_t i) { return i == bad ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(i); });
    EXPECT_TRUE(std::isnan(largest)) << bad;
  }
}

}  // namespace
}  // namespace tern
