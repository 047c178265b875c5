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

/// A quadratic field that is zero at the particle and at all of its neighbours: n . X (n . X - dx) where there are two layers, dx apart
/// in the direction n. Its derivatives at the particle.
template <int D>
struct VanishingField {
  Vector<D> gradient = Vector<D>::Zero();                   ///< [m]
  std::array<double, curvature_components<D>> curvature{};  ///< orthonormal to those of the others
};

template <int D>
struct DerivativeFit {
  std::vector<DerivativeVectors<D>> vectors;  ///< one per neighbour
  std::vector<VanishingField<D>> vanishing;
};

/// For the neighbours at `offsets` = X_j - X_i [m], each of volume `volume` [m^D]: exact for quadratic fields (C2). Where the neighbours
/// do not determine a quadratic, exact for those quadratic fields whose second derivatives are orthogonal to those of all vanishing
/// fields, linear fields among them. Empty when the neighbours do not even determine a linear field.
template <int D>
DerivativeFit<D> derivative_fit(std::span<const Vector<D>> offsets, double volume, double smoothing_length);

}  // namespace tern::structure
