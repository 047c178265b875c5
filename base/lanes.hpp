#pragma once
// Four consecutive particles worked on at once. A Lanes value is one AVX2 register; the same code compiles to two SSE2
// registers elsewhere, with the same bits: lanes never mix.

#include <cstddef>

#include <Eigen/Core>

#ifdef __SSE2__
#include <xmmintrin.h>
#endif

namespace tern {

inline constexpr int lane_count = 4;

using Lanes = double __attribute__((vector_size(lane_count * sizeof(double))));

/// The same at any alignment. (A copy by memcpy goes through the stack where registers are short.)
using LanesInMemory = double __attribute__((vector_size(lane_count * sizeof(double)), aligned(alignof(double)), may_alias));

/// Reads four consecutive doubles at any alignment.
inline Lanes load(const double* p) { return *reinterpret_cast<const LanesInMemory*>(p); }

inline void store(double* p, const Lanes& v) { *reinterpret_cast<LanesInMemory*>(p) = v; }

inline Lanes broadcast(double x) { return Lanes{x, x, x, x}; }

/// Natural logarithm and exponential of each lane.
inline Lanes log(const Lanes& x) {
  Lanes result;
  Eigen::Map<Eigen::Array4d>(reinterpret_cast<double*>(&result)) =
      Eigen::Map<const Eigen::Array4d>(reinterpret_cast<const double*>(&x)).log();
  return result;
}

inline Lanes exp(const Lanes& x) {
  Lanes result;
  Eigen::Map<Eigen::Array4d>(reinterpret_cast<double*>(&result)) =
      Eigen::Map<const Eigen::Array4d>(reinterpret_cast<const double*>(&x)).exp();
  return result;
}

/// function(x) of each lane, or of a plain number.
template <class Function>
inline Lanes each_lane(const Lanes& x, const Function& function) {
  Lanes result;
  for (int lane = 0; lane < lane_count; ++lane) result[lane] = function(x[lane]);
  return result;
}
template <class Function>
inline double each_lane(double x, const Function& function) {
  return function(x);
}

inline double sum(const Lanes& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

/// Fewer blocks than this are worked on by one thread: a parallel region would cost more than it saves.
inline constexpr std::ptrdiff_t parallel_blocks = 1024;

/// While it lives, numbers below 2e-308 count as zero in this thread. Ahead of a wave the fields of a body decay through
/// that range, where every operation would cost a hundred times more.
class SubnormalsAreZero {
 public:
#ifdef __SSE2__
  SubnormalsAreZero() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040); }
  ~SubnormalsAreZero() { _mm_setcsr(before_); }
#else
  SubnormalsAreZero() {}
#endif
  SubnormalsAreZero(const SubnormalsAreZero&) = delete;
  SubnormalsAreZero& operator=(const SubnormalsAreZero&) = delete;

 private:
  [[maybe_unused]] unsigned before_ = 0;
};

/// work(n) for every n in [0, count), in parallel when there are many. `work` must not throw.
template <class Work>
inline void for_each_block(std::ptrdiff_t count, const Work& work) {
  if (count < parallel_blocks) {
    const SubnormalsAreZero mode;
    for (std::ptrdiff_t n = 0; n < count; ++n) work(n);
    return;
  }
#pragma omp parallel
  {
    const SubnormalsAreZero mode;
#pragma omp for schedule(static)
    for (std::ptrdiff_t n = 0; n < count; ++n) work(n);
  }
}

}  // namespace tern
