#pragma once
// Points nearer to a place than a distance, among points that lie one after the other: the candidates of a row of cells.
// In single precision, one array per axis, so that many distances are computed at a time.

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#ifdef __AVX2__
#include <immintrin.h>
#endif

namespace tern {

constexpr int near_lanes = 8;  ///< candidates tested at a time; places are written as many at a time

#ifdef __AVX2__
/// Row m: the places of the bits set in m, in ascending order; what follows them is of no account.
constexpr auto set_bits = [] {
  std::array<std::array<std::uint8_t, near_lanes>, 1 << near_lanes> table{};
  for (unsigned mask = 0; mask < table.size(); ++mask)
    for (unsigned bit = 0, found = 0; bit < near_lanes; ++bit)
      if (mask >> bit & 1) table[mask][found++] = static_cast<std::uint8_t>(bit);
  return table;
}();
#endif

/// Square of the distance in single precision within which every point lies that is nearer than `distance`; coordinates
/// counted from the corner of a box of that extent.
template <int D>
float near_limit2(double distance, double extent) {
  // Each coordinate and shift is off by half a unit in the last place of the extent at most: 2^-24 of it.
  const double limit = (1 + 1e-6) * distance + std::sqrt(double(D)) * 0x3p-24 * extent;
  return static_cast<float>(limit * limit);
}

/// Bit m: point first + m is nearer than the square root of `limit2` to x + shift. Reads `near_lanes` coordinates.
template <int D>
unsigned near_bits(const std::array<std::vector<float>, D>& coordinate, int first, const std::array<float, D>& x,
                   const std::array<float, D>& shift, float limit2) {
#ifdef __AVX2__
  __m256 distance2 = _mm256_setzero_ps();
  for (int c = 0; c < D; ++c) {
    const __m256 d =
        _mm256_sub_ps(_mm256_sub_ps(_mm256_loadu_ps(coordinate[c].data() + first), _mm256_set1_ps(x[c])), _mm256_set1_ps(shift[c]));
    distance2 = _mm256_fmadd_ps(d, d, distance2);
  }
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(distance2, _mm256_set1_ps(limit2), _CMP_LT_OQ)));
#else
  unsigned bits = 0;
  for (int m = 0; m < near_lanes; ++m) {
    float distance2 = 0;
    for (int c = 0; c < D; ++c) {
      const float d = coordinate[c][first + m] - x[c] - shift[c];
      distance2 += d * d;
    }
    bits |= static_cast<unsigned>(distance2 < limit2) << m;
  }
  return bits;
#endif
}

/// Appends to `near`, which holds `found` points so far, those of the points first .. last - 1 other than i that are nearer
/// than the square root of `limit2` to x + shift; returns the new number. May read `near_lanes` coordinates beyond the last
/// and write up to as many entries more than it keeps.
template <int D>
int keep_near(const std::array<std::vector<float>, D>& coordinate, int first, int last, int i, const std::array<float, D>& x,
              const std::array<float, D>& shift, float limit2, int found, int* near) {
  for (int k = first; k < last; k += near_lanes) {
    unsigned bits = near_bits<D>(coordinate, k, x, shift, limit2);
    if (last - k < near_lanes) bits &= (1u << (last - k)) - 1;
    if (static_cast<unsigned>(i - k) < near_lanes) bits &= ~(1u << (i - k));
#ifdef __AVX2__
    const __m128i places = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(set_bits[bits].data()));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(near + found), _mm256_add_epi32(_mm256_set1_epi32(k), _mm256_cvtepu8_epi32(places)));
    found += std::popcount(bits);
#else
    for (; bits != 0; bits &= bits - 1) near[found++] = k + std::countr_zero(bits);
#endif
  }
  return found;
}

}  // namespace tern
