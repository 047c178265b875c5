// The instants at which rows are written.

#include "run/recorder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "fixtures/scratch_directory.hpp"

namespace tern {
namespace {

// The two other processes of a coupled run evaluate gauges by the same rule. Seen to fail with written() adding the
// interval to the last row's time: the rows then drift away from the multiples.
TEST(Recorder, WritesTheFirstInstantAtOrAfterEveryMultipleOfTheInterval) {
  const ScratchDirectory directory;
  std::vector<double> due;
  {
    Recorder recorder(directory.path(), {"p_Pa"}, {"kinetic_J"}, 0.1);
    for (int k = 0; k < 12; ++k) {
      const Ticks now = to_ticks(0.03 * k);
      if (recorder.due(now)) due.push_back(seconds(now));
      recorder.account(now, {0.0}, {0.0});
    }
  }
  const std::string table = text_of(directory / "gauges.csv");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 5) << table;
  ASSERT_EQ(due.size(), 4u);
  const std::array expected{0.0, 0.12, 0.21, 0.3};
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(due[k], expected[k], 1e-6);
}

// 0.001 s is no whole number of ticks. Seen to fail: with the instants compared in seconds, where 0.001 rounds down to a tick.
TEST(Recorder, WritesARowAtEveryMultipleThatAWindowEndsAt) {
  for (const double interval : {1e-3, 1.0 / 3, 0.0171}) {
    RowSchedule rows(interval);
    rows.written(0);
    for (int k = 1; k < 500; ++k) {
      const Ticks multiple = to_ticks(k * interval);
      ASSERT_FALSE(rows.due(multiple - 1)) << interval << " times " << k;
      ASSERT_TRUE(rows.due(multiple)) << interval << " times " << k;
      rows.written(multiple);
    }
  }
}

// Seen to fail: with every multiple before the end, of which the last is 0.0002 s before it.
// A run that ended a moment before a frame and goes on would begin with a window of a moment. Seen to fail: without the last window (the
// frame at 0.2 s).
TEST(FrameSchedule, LeavesOutAFrameRightAfterTheEndThatARunGoesOnFrom) {
  const FrameSchedule schedule(0.1, to_ticks(1));
  EXPECT_EQ(schedule.next(to_ticks(0.1999999), to_ticks(0.02)), to_ticks(0.3));
  EXPECT_EQ(schedule.next(to_ticks(0.18), to_ticks(0.02)), to_ticks(0.2));
  EXPECT_EQ(schedule.next(to_ticks(0.9999999), to_ticks(0.02)), to_ticks(1));
}

TEST(FrameSchedule, LeavesNoShortWindowBeforeTheEnd) {
  const Ticks end = to_ticks(3);
  const FrameSchedule schedule(0.00283, end);
  Ticks now = 0, shortest = end;
  while (now < end) {
    const Ticks next = schedule.next(now);
    shortest = std::min(shortest, next - now);
    now = next;
  }
  EXPECT_EQ(now, end);
  EXPECT_GE(shortest, to_ticks(0.00283) - 1);
  EXPECT_EQ(FrameSchedule(0.2, to_ticks(0.5)).next(to_ticks(0.2)), to_ticks(0.4));
  EXPECT_EQ(FrameSchedule(0, end).next(0), end);
}

}  // namespace
}  // namespace tern
