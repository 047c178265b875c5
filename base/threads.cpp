#include "base/threads.hpp"

#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "base/parallel.hpp"

namespace tern {

int cores_of_quota(const std::string& line) {
  long granted = 0, period = 0;
  if (std::sscanf(line.c_str(), "%ld %ld", &granted, &period) != 2 || granted <= 0 || period <= 0) return 0;
  return static_cast<int>(std::clamp<long>(granted / period, 1, 1 << 16));
}

int cores_at_hand() {
  int cores = std::max(omp_get_max_threads(), 1);
  std::string group;
  std::ifstream groups("/proc/self/cgroup");
  while (std::getline(groups, group) && !group.starts_with("0::")) {}
  std::string place = group.starts_with("0::/") && group != "0::/" ? group.substr(3) : "";
  for (;; place.resize(place.rfind('/'))) {  // a limit of a group holds for all groups in it
    std::string line;
    std::ifstream quota("/sys/fs/cgroup" + place + "/cpu.max");
    if (std::getline(quota, line))
      if (const int granted = cores_of_quota(line); granted > 0) cores = std::min(cores, granted);
    if (place.empty()) return cores;
  }
}

int threads_worth(std::ptrdiff_t items, int cores) {
  return static_cast<int>(std::clamp<std::ptrdiff_t>(items / (parallel_threshold / 2), 1, std::max(cores, 1)));
}

}  // namespace tern
