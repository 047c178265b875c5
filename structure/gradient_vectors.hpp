#pragma once
// Gradient vectors g_ij of one particle: grad f |_i = sum_j V (f_j - f_i) g_ij in the reference configuration.

#include <span>
#include <vector>

#include "particles/vector.hpp"

namespace tern::structure {

/// g_ij [1/m^(D+1)] for the neighbours at `offsets` = X_j - X_i [m], each of volume `volume` [m^D]; exact for quadratic
/// fields (C2), or for linear fields only (C1) where the neighbours do not determine a quadratic. Empty when they do not
/// even determine a linear field.
template <int D>
std::vector<Vector<D>> gradient_vectors(std::span<const Vector<D>> offsets, double volume, double smoothing_length);

}  // namespace tern::structure
