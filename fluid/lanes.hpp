#pragma once
// Sums over pairs read the neighbours of a particle four at a time: particles that lie one after the other, from arrays with one number a
// particle. What is written as one addition here is one instruction of the processor.

#include <array>
#include <cstddef>
#include <cstring>
#include <vector>

#ifdef __AVX__
#include <immintrin.h>
#endif

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "fluid/period.hpp"

namespace tern::fluid {

inline constexpr int lanes = 4;

typedef double Four __attribute__((vector_size(lanes * sizeof(double))));

/// The four numbers from `from` on.
inline Four load(const double* from) {
  Four four;
  std::memcpy(&four, from, sizeof four);
  return four;
}

inline Four load(const float* from) {
#ifdef __AVX__
  return reinterpret_cast<Four>(_mm256_cvtps_pd(_mm_loadu_ps(from)));  // g++ 12 makes four instructions of the conversion below
#else
  typedef float Single __attribute__((vector_size(lanes * sizeof(float))));
  Single four;
  std::memcpy(&four, from, sizeof four);
  return __builtin_convertvector(four, Four);
#endif
}

inline void store(const Four& four, double* to) { std::memcpy(to, &four, sizeof four); }

inline double sum(const Four& four) { return (four[0] + four[2]) + (four[1] + four[3]); }

/// A vector of each particle, by axis.
template <int D>
using ByAxis = std::array<std::vector<double>, D>;

template <int D>
void by_axis(const std::vector<Vector<D>>& vectors, ByAxis<D>& result) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(vectors.size());
  for (auto& values : result) values.resize(n);
  parallel_for(n, [&](std::ptrdiff_t i) {
    for (int c = 0; c < D; ++c) result[c][i] = vectors[i][c];
  });
}

/// Component c of the vectors between coordinates, as Period::between().
template <bool periodic, int D>
class LanePeriod {
 public:
  explicit LanePeriod(const Period<D>& period) {
    for (int c = 0; c < D; ++c)
      if (period.repeats(c)) length_[c] = period.length(c), inverse_length_[c] = 1 / period.length(c);
  }

  Four between(double from, const double* to, int c) const {
    Four d = load(to) - from;
    if constexpr (periodic) {
      constexpr double whole = 0x1.8p52;  // added to a number of less than 2^51 and taken off again it rounds to a whole number
      d -= length_[c] * ((d * inverse_length_[c] + whole) - whole);
    }
    return d;
  }

 private:
  std::array<double, D> length_{}, inverse_length_{};
};

}  // namespace tern::fluid
