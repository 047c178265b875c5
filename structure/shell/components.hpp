#pragma once
// The components of a vector side by side in one register: the sums of a shell over its neighbours add whole vectors.

#include "base/lanes.hpp"
#include "base/vector.hpp"

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace tern::structure {

/// The D numbers from `from` on, and 0 in the other lanes. Nothing behind them is read.
template <int D>
inline Lanes components(const double* from) {
#ifdef __AVX__
  return reinterpret_cast<Lanes>(_mm256_maskload_pd(from, _mm256_setr_epi64x(-1, -1, D == 3 ? -1 : 0, 0)));
#else
  return D == 3 ? Lanes{from[0], from[1], from[2], 0} : Lanes{from[0], from[1], 0, 0};
#endif
}

template <int D>
inline Vector<D> vector_of(const Lanes& lanes) {
  Vector<D> x;
  for (int a = 0; a < D; ++a) x[a] = lanes[a];
  return x;
}

}  // namespace tern::structure
