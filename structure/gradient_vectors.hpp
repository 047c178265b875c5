#pragma once
// Derivative vectors of one particle in the reference configuration:
//   grad f |_i = sum_j V (f_j - f_i) g_ij,   d2f/dX_a dX_b |_i = sum_j V (f_j - f_i) k_ij^ab.

#include <array>
#include <span>
#include <vector>

#include "base/vector.hpp"

namespace tern::structure {

/// Pairs of directions a <= b of a second derivative, in the order 00, 01, (02,) 11, (12, 22).
template <int D>
inline constexpr int curvature_components = D*(D + 1) / 2;

/// Position of the pair (a, b) in that order.
template <int D>
constexpr int curvature_index(int a, int b) {
  const int low = a < b ? a : b, high = a < b ? b : a;
  return low * D - low * (low - 1) / 2 + high - low;
}

template <int D>
struct DerivativeVectors {
  Vector<D> gradient = Vector<D>::Zero();                   ///< g_ij [1/m^(D+1)]
  std::array<double, curvature_components<D>> curvature{};  ///< k_ij [1/m^(D+2)]
};

/// For the neighbours at `offsets` = X_j - X_i [m], each of volume `volume` [m^D]: exact for quadratic fields (C2); where
/// the neighbours do not determine a quadratic, exact for linear fields only (C1), with zero second derivatives. Empty
/// when they do not even determine a linear field.
template <int D>
std::vector<DerivativeVectors<D>> derivative_vectors(std::span<const Vector<D>> offsets, double volume, double smoothing_length);

}  // namespace tern::structure
