#pragma once
// Points nearer to a place than a distance, among points that lie one after the other: the candidates of a row of cells.
// In single precision, one array per axis, so that many distances are computed at a time.

#include <algorithm>
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

/// Square of the distance in single precision within which no point lies that is not nearer than `distance`.
template <int D>
float surely_near_limit2(double distance, double extent) {
  const double limit = std::max(0.0, (1 - 1e-6) * distance - std::sqrt(double(D)) * 0x3p-24 * extent);
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

/// Of `near_lanes` patches: those that may be near and turned as asked, and those that are for sure.
struct PatchBits {
  unsigned may = 0, sure = 0;
};

/// Bit m: patch first + m is nearer to x than the square root of `near2`, and the product of its normal with the way to it is above
/// `least`. `side` 1: the product, of patches that are turned away from x; -1: its negative, of those that look at x. What `slack` of the
/// product, and `limit2` in place of `near2`, leave open is left to `may`.
template <int D>
PatchBits patch_bits(const std::array<std::vector<float>, D>& coordinate, const std::array<std::vector<float>, D>& normal, int first,
                     const std::array<float, D>& x, float near2, float limit2, float side, float least, float slack) {
#ifdef __AVX2__
  __m256 distance2 = _mm256_setzero_ps(), product = _mm256_setzero_ps();
  for (int c = 0; c < D; ++c) {
    const __m256 d = _mm256_sub_ps(_mm256_loadu_ps(coordinate[c].data() + first), _mm256_set1_ps(x[c]));
    distance2 = _mm256_fmadd_ps(d, d, distance2);
    product = _mm256_fmadd_ps(d, _mm256_loadu_ps(normal[c].data() + first), product);
  }
  product = _mm256_mul_ps(product, _mm256_set1_ps(side));
  const auto bits = [&](float limit, float above) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_and_ps(_mm256_cmp_ps(distance2, _mm256_set1_ps(limit), _CMP_LT_OQ),
                                                                  _mm256_cmp_ps(product, _mm256_set1_ps(above), _CMP_GT_OQ))));
  };
  return {bits(limit2, least - slack), bits(near2, least + slack)};
#else
  PatchBits bits;
  for (int m = 0; m < near_lanes; ++m) {
    float distance2 = 0, product = 0;
    for (int c = 0; c < D; ++c) {
      const float d = coordinate[c][first + m] - x[c];
      distance2 += d * d;
      product += d * normal[c][first + m];
    }
    product *= side;
    bits.may |= static_cast<unsigned>((distance2 < limit2) & (product > least - slack)) << m;
    bits.sure |= static_cast<unsigned>((distance2 < near2) & (product > least + slack)) << m;
  }
  return bits;
#endif
}

/// Of `near_lanes` groups of patches, the bits of those that may have a patch that is near and turned as asked (patch_bits()). By group:
/// `middle`, `normal`: of its patches; `reach2`: square of the distance of the middle beyond which no patch is near; `more`: by how much
/// the product of a near patch may exceed that of middle and normal. `rest`: what x is beyond single precision.
template <int D>
unsigned group_bits(const std::array<std::vector<float>, D>& middle, const std::array<std::vector<float>, D>& normal, int first,
                    const std::array<float, D>& x, const std::array<float, D>& rest, const std::vector<float>& reach2,
                    const std::vector<float>& more, float side, float least) {
#ifdef __AVX2__
  __m256 distance2 = _mm256_setzero_ps(), product = _mm256_setzero_ps();
  for (int c = 0; c < D; ++c) {
    const __m256 d = _mm256_sub_ps(_mm256_sub_ps(_mm256_loadu_ps(middle[c].data() + first), _mm256_set1_ps(x[c])), _mm256_set1_ps(rest[c]));
    distance2 = _mm256_fmadd_ps(d, d, distance2);
    product = _mm256_fmadd_ps(d, _mm256_loadu_ps(normal[c].data() + first), product);
  }
  product = _mm256_fmadd_ps(product, _mm256_set1_ps(side), _mm256_loadu_ps(more.data() + first));
  return static_cast<unsigned>(
      _mm256_movemask_ps(_mm256_and_ps(_mm256_cmp_ps(distance2, _mm256_loadu_ps(reach2.data() + first), _CMP_LT_OQ),
                                       _mm256_cmp_ps(product, _mm256_set1_ps(least), _CMP_GT_OQ))));
#else
  unsigned bits = 0;
  for (int g = 0; g < near_lanes; ++g) {
    float distance2 = 0, product = 0;
    for (int c = 0; c < D; ++c) {
      const float d = middle[c][first + g] - x[c] - rest[c];
      distance2 += d * d;
      product += d * normal[c][first + g];
    }
    bits |= static_cast<unsigned>((distance2 < reach2[first + g]) & (product * side + more[first + g] > least)) << g;
  }
  return bits;
#endif
}

/// Bit g: some patch of group first + g may have a normal whose product with `direction` is above `least`. `lean`: by how much its
/// normals differ from the mean `normal`.
template <int D>
unsigned direction_bits(const std::array<std::vector<float>, D>& normal, const std::vector<float>& lean, int first,
                        const std::array<float, D>& direction, float least) {
#ifdef __AVX2__
  __m256 product = _mm256_loadu_ps(lean.data() + first);
  for (int c = 0; c < D; ++c) product = _mm256_fmadd_ps(_mm256_set1_ps(direction[c]), _mm256_loadu_ps(normal[c].data() + first), product);
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(product, _mm256_set1_ps(least), _CMP_GT_OQ)));
#else
  unsigned bits = 0;
  for (int g = 0; g < near_lanes; ++g) {
    float product = lean[first + g];
    for (int c = 0; c < D; ++c) product += direction[c] * normal[c][first + g];
    bits |= static_cast<unsigned>(product > least) << g;
  }
  return bits;
#endif
}

/// Those of `bits` that belong to points first .. last - 1.
inline unsigned bits_before(unsigned bits, int first, int last) {
  return last - first < near_lanes ? bits & ((1u << (last - first)) - 1) : bits;
}

/// Appends the places first + m of the bits m that are set to `near`, which holds `found`; returns the new number. May write up to
/// `near_lanes` entries more than it keeps.
inline int append_places(unsigned bits, int first, int found, int* near) {
#ifdef __AVX2__
  const __m128i places = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(set_bits[bits].data()));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(near + found), _mm256_add_epi32(_mm256_set1_epi32(first), _mm256_cvtepu8_epi32(places)));
  return found + std::popcount(bits);
#else
  for (; bits != 0; bits &= bits - 1) near[found++] = first + std::countr_zero(bits);
  return found;
#endif
}

/// The same with value[first + m] in place of a place.
inline int append_values(unsigned bits, const int* value, int first, int found, int* near) {
#ifdef __AVX2__
  const __m256i places = _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(set_bits[bits].data())));
  const __m256i values = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(value + first));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(near + found), _mm256_permutevar8x32_epi32(values, places));
  return found + std::popcount(bits);
#else
  for (; bits != 0; bits &= bits - 1) near[found++] = value[first + std::countr_zero(bits)];
  return found;
#endif
}

/// Appends to `near`, which holds `found` points so far, those of the points first .. last - 1 other than i that are nearer
/// than the square root of `limit2` to x + shift; returns the new number. May read `near_lanes` coordinates beyond the last
/// and write up to as many entries more than it keeps.
template <int D>
int keep_near(const std::array<std::vector<float>, D>& coordinate, int first, int last, int i, const std::array<float, D>& x,
              const std::array<float, D>& shift, float limit2, int found, int* near) {
  for (int k = first; k < last; k += near_lanes) {
    unsigned bits = bits_before(near_bits<D>(coordinate, k, x, shift, limit2), k, last);
    if (static_cast<unsigned>(i - k) < near_lanes) bits &= ~(1u << (i - k));
    found = append_places(bits, k, found, near);
  }
  return found;
}

}  // namespace tern
