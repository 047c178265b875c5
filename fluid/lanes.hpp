#pragma once
// Sums over pairs read the neighbours of a particle four at a time: particles that lie one after the other, from arrays with one number a
// particle. What is written as one addition here is one instruction of the processor.

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
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

inline Four magnitude(const Four& four) {
  typedef std::int64_t Bits __attribute__((vector_size(lanes * sizeof(double))));
  return reinterpret_cast<Four>(reinterpret_cast<Bits>(four) & 0x7fffffffffffffff);
}

/// The larger of each two; the second where the first is not a number.
inline Four larger(const Four& a, const Four& b) {
#ifdef __AVX__
  return reinterpret_cast<Four>(_mm256_max_pd(reinterpret_cast<__m256d>(a), reinterpret_cast<__m256d>(b)));
#else
  return a > b ? a : b;
#endif
}

/// The smaller of each two; the second where the first is not a number.
inline Four smaller(const Four& a, const Four& b) {
#ifdef __AVX__
  return reinterpret_cast<Four>(_mm256_min_pd(reinterpret_cast<__m256d>(a), reinterpret_cast<__m256d>(b)));
#else
  return a < b ? a : b;
#endif
}

inline void store(const Four& four, double* to) { std::memcpy(to, &four, sizeof four); }

/// Eight numbers in single precision: of two groups.
typedef float Eight __attribute__((vector_size(2 * lanes * sizeof(float))));

inline Eight to_single(const Four& low, const Four& high) {
#ifdef __AVX__
  return reinterpret_cast<Eight>(
      _mm256_set_m128(_mm256_cvtpd_ps(reinterpret_cast<__m256d>(high)), _mm256_cvtpd_ps(reinterpret_cast<__m256d>(low))));
#else
  Eight eight;
  for (int m = 0; m < lanes; ++m) eight[m] = static_cast<float>(low[m]), eight[m + lanes] = static_cast<float>(high[m]);
  return eight;
#endif
}

inline Four low_half(const Eight& eight) {
#ifdef __AVX__
  return reinterpret_cast<Four>(_mm256_cvtps_pd(_mm256_castps256_ps128(reinterpret_cast<__m256>(eight))));
#else
  return Four{eight[0], eight[1], eight[2], eight[3]};
#endif
}

inline Four high_half(const Eight& eight) {
#ifdef __AVX__
  return reinterpret_cast<Four>(_mm256_cvtps_pd(_mm256_extractf128_ps(reinterpret_cast<__m256>(eight), 1)));
#else
  return Four{eight[4], eight[5], eight[6], eight[7]};
#endif
}

inline Eight square_root(const Eight& eight) {
#ifdef __AVX__
  return reinterpret_cast<Eight>(_mm256_sqrt_ps(reinterpret_cast<__m256>(eight)));
#else
  Eight result;
  for (int m = 0; m < 2 * lanes; ++m) result[m] = std::sqrt(eight[m]);
  return result;
#endif
}

/// The numbers of these lanes of the two groups, 0 for the others. Bit m of `low` and of `high`: lane m of the group.
inline Eight keep_lanes(const Eight& eight, int low, int high) {
  typedef std::int32_t Bits __attribute__((vector_size(2 * lanes * sizeof(float))));
  constexpr Bits bit = {1, 2, 4, 8, 16, 32, 64, 128};
  const Bits kept = Bits{} + (low | high << lanes);
  return (kept & bit) != 0 ? eight : Eight{};
}

/// How many are above 0.
inline int positive(const Eight& eight) {
#ifdef __AVX__
  return std::popcount(
      static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(reinterpret_cast<__m256>(eight), _mm256_setzero_ps(), _CMP_GT_OQ))));
#else
  int count = 0;
  for (int m = 0; m < 2 * lanes; ++m) count += eight[m] > 0;
  return count;
#endif
}

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

/// Calls visit(a, b, place) for the axes a < b of a pair and its place among them.
template <int D, class Visit>
[[gnu::always_inline]] inline void for_axis_pairs(Visit&& visit) {
  for (int a = 0, place = 0; a < D; ++a)
    for (int b = a + 1; b < D; ++b, ++place) visit(a, b, place);
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
