#pragma once

#include <algorithm>

namespace tern {

/// Wet share of a face as a function of the filled share of the space in front of it: half wet where that is half filled,
/// as at the edge of a flat surface, dry below a quarter and wet above three quarters.
inline double wet_share(double filled) { return std::clamp(2 * filled - 0.5, 0.0, 1.0); }

}  // namespace tern
