// How many threads a process takes where nobody says it.

#include "base/threads.hpp"

#include <gtest/gtest.h>
#include <omp.h>

#include "base/parallel.hpp"

namespace tern {
namespace {

// Seen to fail without the lower bound of one core.
TEST(Threads, ReadTheQuotaOfAControlGroup) {
  EXPECT_EQ(cores_of_quota("200000 100000"), 2);
  EXPECT_EQ(cores_of_quota("250000 100000"), 2);  // a third one would have to pause
  EXPECT_EQ(cores_of_quota("50000 100000"), 1);
  EXPECT_EQ(cores_of_quota("max 100000"), 0);
  EXPECT_EQ(cores_of_quota(""), 0);
  EXPECT_EQ(cores_of_quota("-1 100000"), 0);
  EXPECT_EQ(cores_of_quota("100000 0"), 0);
}

// Seen to fail with the whole threshold for each thread: two would then begin to pay at twice of it.
TEST(Threads, AreAsManyAsTheirLoopsAreWorth) {
  EXPECT_EQ(threads_worth(0, 16), 1);
  EXPECT_EQ(threads_worth(parallel_threshold - 1, 16), 1);
  EXPECT_EQ(threads_worth(parallel_threshold, 16), 2);
  EXPECT_EQ(threads_worth(parallel_threshold, 1), 1);
  EXPECT_EQ(threads_worth(1'000'000, 16), 16);
}

// Seen to fail with a quota of 0 cores taken as a limit.
TEST(Threads, FindAtLeastOneCoreAndNoMoreThanTheSystemGives) {
  const int cores = cores_at_hand();
  EXPECT_GE(cores, 1);
  EXPECT_LE(cores, omp_get_max_threads());
}

}  // namespace
}  // namespace tern
