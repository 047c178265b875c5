// CPU time of the process.

#include "base/timing.hpp"

#include <sys/resource.h>

namespace tern {

double cpu_seconds() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  const auto in_seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return in_seconds(usage.ru_utime) + in_seconds(usage.ru_stime);
}

}  // namespace tern
