#pragma once
// Sums over pairs at surface points by all threads, with the same bits for any number of them: the particles are cut into parts, whose
// number follows from that of the particles alone. Each part is added up by itself, and then part after part.

#include <algorithm>
#include <cstddef>
#include <vector>

#include <omp.h>

namespace tern::coupler {

/// Into how many parts so many particles are cut. A part has the room of a number for every point, so there are not more than these.
inline int particle_parts(std::ptrdiff_t particles) { return static_cast<int>(std::clamp<std::ptrdiff_t>(particles / 512, 1, 16)); }

/// work(part, first, last) for equal parts of 0 .. n - 1. `work` must not throw.
template <class Work>
void run_parts(std::ptrdiff_t n, int parts, const Work& work) {
  const auto do_part = [&](int part) { work(part, n * part / parts, n * (part + 1) / parts); };
  if (parts == 1 || omp_get_max_threads() == 1) {
    for (int part = 0; part < parts; ++part) do_part(part);
    return;
  }
#pragma omp parallel for schedule(static, 1)
  for (int part = 0; part < parts; ++part) do_part(part);
}

/// One number for every surface point and part, kept so that a window allocates nothing.
class PointSums {
 public:
  void reset(int parts, std::size_t points) {
    if (of_part_.size() < static_cast<std::size_t>(parts)) of_part_.resize(parts);
    parts_ = parts;
    points_ = points;
  }
  /// Those of a part at all points, 0. Each thread asks for its own.
  double* start(int part) {
    of_part_[part].assign(points_, 0);
    return of_part_[part].data();
  }
  double sum(std::size_t point) const {
    double sum = of_part_[0][point];
    for (int part = 1; part < parts_; ++part) sum += of_part_[part][point];
    return sum;
  }

 private:
  std::vector<std::vector<double>> of_part_;
  int parts_ = 0;
  std::size_t points_ = 0;
};

}  // namespace tern::coupler
