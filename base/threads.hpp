#pragma once
// How many threads a process works with.

#include <cstddef>
#include <string>

namespace tern {

/// Cores that a line of cgroup v2's cpu.max grants ("150000 100000": the microseconds of every 100000 that all threads have together), at
/// least one. Zero for "max" and for what is no such line: no limit.
int cores_of_quota(const std::string& line);

/// Cores that this process has: those that the system lets it run on or, if it is set, OMP_NUM_THREADS, but no more than the quota of its
/// control group. To be asked before the first change of the number of threads.
int cores_at_hand();

/// Threads that pay for loops over `items`: half of parallel_threshold for each, as where two begin to pay; from 1 to `cores`.
int threads_worth(std::ptrdiff_t items, int cores);

}  // namespace tern
