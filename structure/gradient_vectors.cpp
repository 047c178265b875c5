// Derivatives of second-order consistency by weighted least squares: with the basis b_ij = {X_ji/h, X_ji x X_ji / h^2},
//   A_i = sum_j V w_ij b_ij b_ij^T,   g_ij = w_ij [A_i^-1 b_ij]_{1..D} / h
// is exact for every quadratic field, and the remaining entries are its second derivatives. With the linear part of the
// basis alone it is exact for linear fields; that is the fallback where A_i is singular (fewer than three layers across).

#include "structure/gradient_vectors.hpp"

#include "sph/kernel.hpp"
#include "sph/symmetric_matrix.hpp"

namespace tern::structure {
namespace {

template <int D, int Size>
Eigen::Matrix<double, Size, 1> basis(const Vector<D>& offset, double h) {
  Eigen::Matrix<double, Size, 1> b;
  const Vector<D> x = offset / h;
  int n = 0;
  for (int a = 0; a < D; ++a) b[n++] = x[a];
  if constexpr (Size > D) {
    for (int a = 0; a < D; ++a)
      for (int c = a; c < D; ++c) b[n++] = x[a] * x[c];
  }
  return b;
}

template <int D, int Size>
std::vector<DerivativeVectors<D>> least_squares(std::span<const Vector<D>> offsets, double volume, const Kernel<D>& kernel) {
  const double h = kernel.smoothing_length();
  Eigen::Matrix<double, Size, Size> moments = Eigen::Matrix<double, Size, Size>::Zero();
  for (const Vector<D>& offset : offsets) {
    const auto b = basis<D, Size>(offset, h);
    moments += volume * kernel.value(offset.norm()) * b * b.transpose();
  }
  const Eigen::MatrixXd found = inverse_of_moments(moments);
  if (found.size() == 0) return {};
  const Eigen::Matrix<double, Size, Size> inverse = found;
  std::vector<DerivativeVectors<D>> derivatives;
  derivatives.reserve(offsets.size());
  for (const Vector<D>& offset : offsets) {
    const Eigen::Matrix<double, Size, 1> solution = kernel.value(offset.norm()) * inverse * basis<D, Size>(offset, h);
    DerivativeVectors<D> d;
    d.gradient = solution.template head<D>() / h;
    if constexpr (Size > D) {
      for (int a = 0, n = D; a < D; ++a)
        for (int c = a; c < D; ++c, ++n) d.curvature[n - D] = (a == c ? 2 : 1) * solution[n] / (h * h);
    }
    derivatives.push_back(d);
  }
  return derivatives;
}

}  // namespace

template <int D>
std::vector<DerivativeVectors<D>> derivative_vectors(std::span<const Vector<D>> offsets, double volume, double smoothing_length) {
  const Kernel<D> kernel(smoothing_length);
  auto derivatives = least_squares<D, D + curvature_components<D>>(offsets, volume, kernel);
  if (derivatives.empty()) derivatives = least_squares<D, D>(offsets, volume, kernel);
  return derivatives;
}

template std::vector<DerivativeVectors<2>> derivative_vectors<2>(std::span<const Vector<2>>, double, double);
template std::vector<DerivativeVectors<3>> derivative_vectors<3>(std::span<const Vector<3>>, double, double);

}  // namespace tern::structure
