#pragma once
// Simulation time as an integer count of ticks of 2^-32 s: exact in a double up to 2^21 s, so no floating-point
// number is ever compared to decide whether a window is over.

#include <cmath>
#include <cstdint>

namespace tern {

using Ticks = std::int64_t;

inline constexpr double ticks_per_second = 4294967296.0;

inline double seconds(Ticks t) { return static_cast<double>(t) / ticks_per_second; }
inline Ticks to_ticks(double seconds) { return static_cast<Ticks>(std::llround(seconds * ticks_per_second)); }

}  // namespace tern
