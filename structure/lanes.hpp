#pragma once
// Four consecutive particles worked on at once. A Lanes value is one AVX2 register; the same code compiles to two SSE2
// registers elsewhere, with the same bits: lanes never mix.

#include <cstring>

namespace tern::structure {

inline constexpr int lane_count = 4;

using Lanes = double __attribute__((vector_size(lane_count * sizeof(double))));

/// Reads four consecutive doubles at any alignment.
inline Lanes load(const double* p) {
  Lanes v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

inline void store(double* p, const Lanes& v) { std::memcpy(p, &v, sizeof v); }

inline Lanes broadcast(double x) { return Lanes{x, x, x, x}; }

inline double sum(const Lanes& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

}  // namespace tern::structure
