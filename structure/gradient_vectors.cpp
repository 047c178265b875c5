// Derivatives of second-order consistency by weighted least squares: with the basis b_ij = {X_ji/h, X_ji x X_ji / h^2},
//   A_i = sum_j V w_ij b_ij b_ij^T,   g_ij = w_ij [A_i^-1 b_ij]_{1..D} / h
// is exact for every quadratic field, and the remaining entries are its second derivatives. Where A_i is singular (fewer than three
// layers across), its null vectors are quadratic fields that vanish at all neighbours. The fit can then have any multiple of them; it is
// taken with none in its second derivatives, and unseen_fields.hpp completes it.

#include "structure/gradient_vectors.hpp"

#include <Eigen/QR>

#include "sph/kernel.hpp"
#include "sph/symmetric_matrix.hpp"

namespace tern::structure {
namespace {

template <int D>
constexpr int terms = D + curvature_components<D>;

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
Eigen::Matrix<double, Size, Size> moments_of(std::span<const Vector<D>> offsets, double volume, const Kernel<D>& kernel) {
  Eigen::Matrix<double, Size, Size> moments = Eigen::Matrix<double, Size, Size>::Zero();
  for (const Vector<D>& offset : offsets) {
    const auto b = basis<D, Size>(offset, kernel.smoothing_length());
    moments += volume * kernel.value(offset.norm()) * b * b.transpose();
  }
  return moments;
}

/// Second derivatives over the coefficients of the fit.
template <int D>
std::array<double, curvature_components<D>> curvature_factors(double h) {
  std::array<double, curvature_components<D>> factors;
  for (int a = 0, n = 0; a < D; ++a)
    for (int c = a; c < D; ++c, ++n) factors[n] = (a == c ? 2 : 1) / (h * h);
  return factors;
}

}  // namespace

template <int D>
DerivativeFit<D> derivative_fit(std::span<const Vector<D>> offsets, double volume, double smoothing_length) {
  constexpr int pairs = curvature_components<D>;
  const Kernel<D> kernel(smoothing_length);
  const double h = smoothing_length;
  const auto factors = curvature_factors<D>(h);
  const auto moments = moments_of<D, terms<D>>(offsets, volume, kernel);
  DerivativeFit<D> fit;
  Eigen::MatrixXd inverse = inverse_of_moments(moments);
  Eigen::MatrixXd gradients, curvatures;  // of the vanishing fields, as columns
  if (inverse.size() == 0) {
    if (inverse_of_moments(moments_of<D, D>(offsets, volume, kernel)).size() == 0) return fit;
    const PartOfMoments part = determined_part_of_moments(moments);
    inverse = part.inverse;
    gradients = part.vanishing.topRows(D) / h;
    curvatures = part.vanishing.bottomRows(pairs);
    for (int n = 0; n < pairs; ++n) curvatures.row(n) *= factors[n];
    // Orthonormal second derivatives; they are independent, because no linear field vanishes at all neighbours.
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(curvatures);
    const auto count = curvatures.cols();
    const Eigen::MatrixXd triangle = qr.matrixQR().topRows(count).template triangularView<Eigen::Upper>();
    const Eigen::MatrixXd to_orthonormal = triangle.inverse();
    gradients = (gradients * to_orthonormal).eval();
    curvatures = (curvatures * to_orthonormal).eval();
    for (Eigen::Index r = 0; r < count; ++r) {
      VanishingField<D>& field = fit.vanishing.emplace_back();
      field.gradient = gradients.col(r);
      for (int n = 0; n < pairs; ++n) field.curvature[n] = curvatures(n, r);
    }
  }
  fit.vectors.reserve(offsets.size());
  for (const Vector<D>& offset : offsets) {
    const Eigen::Matrix<double, terms<D>, 1> solution = kernel.value(offset.norm()) * inverse * basis<D, terms<D>>(offset, h);
    Vector<D> gradient = solution.template head<D>() / h;
    Eigen::Matrix<double, pairs, 1> curvature = solution.template tail<pairs>();
    for (int n = 0; n < pairs; ++n) curvature[n] *= factors[n];
    if (!fit.vanishing.empty()) {
      const Eigen::VectorXd share = curvatures.transpose() * curvature;
      gradient -= gradients * share;
      curvature -= curvatures * share;
    }
    DerivativeVectors<D>& d = fit.vectors.emplace_back();
    d.gradient = gradient;
    for (int n = 0; n < pairs; ++n) d.curvature[n] = curvature[n];
  }
  return fit;
}

template DerivativeFit<2> derivative_fit<2>(std::span<const Vector<2>>, double, double);
template DerivativeFit<3> derivative_fit<3>(std::span<const Vector<3>>, double, double);

}  // namespace tern::structure
