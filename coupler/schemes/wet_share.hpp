#pragma once
// Schemes whose load is a pressure per surface point times its area, -s_k A_k P_k n_k, with the wet share s_k of the face.

#include <algorithm>

namespace tern::coupler {

/// Share of a face that is wet, from the share of its half space that fluid fills: as for walls (fluid/boundary).
inline double wet_share(double filled) { return std::clamp(2 * filled - 0.5, 0.0, 1.0); }

}  // namespace tern::coupler
