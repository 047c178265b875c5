#include "structure/unseen_fields.hpp"

#include <Eigen/Cholesky>

namespace tern::structure {

template <int D>
std::vector<UnseenField<D, double>> unseen_fields(const std::vector<VanishingField<D>>& vanishing, const Hooke& hooke) {
  constexpr int pairs = curvature_components<D>;
  const auto count = static_cast<Eigen::Index>(vanishing.size());
  // Nothing is seen of the second derivatives where all fields vanish; they are zero then.
  if (count == 0 || count == pairs) return {};
  // The energy as k^T energy k/2, over the entries (m, n) of k.
  Eigen::MatrixXd energy = Eigen::MatrixXd::Zero(D * pairs, D * pairs);
  for (int direction = 0; direction < D; ++direction) {
    Eigen::Matrix<double, D * D, D* pairs> strain = Eigen::Matrix<double, D * D, D * pairs>::Zero();
    for (int i = 0; i < D; ++i)
      for (int l = 0; l < D; ++l) {
        strain(i * D + l, i * pairs + curvature_index<D>(direction, l)) += 0.5;
        strain(i * D + l, l * pairs + curvature_index<D>(direction, i)) += 0.5;
      }
    Eigen::Matrix<double, D * D, D * D> stiffness;
    for (int i = 0; i < D; ++i)
      for (int j = 0; j < D; ++j)
        for (int k = 0; k < D; ++k)
          for (int l = 0; l < D; ++l) stiffness(i * D + j, k * D + l) = hooke.stiffness(i, j, k, l);
    energy += strain.transpose() * stiffness * strain;
  }
  Eigen::MatrixXd of_amplitudes = Eigen::MatrixXd::Zero(D * pairs, count * D);  // k over a
  for (Eigen::Index r = 0; r < count; ++r)
    for (int c = 0; c < D; ++c)
      for (int n = 0; n < pairs; ++n) of_amplitudes(c * pairs + n, r * D + c) = vanishing[r].curvature[n];
  // Positive definite: a field whose strain has no gradient has no second derivatives.
  const Eigen::MatrixXd amplitude =
      -(of_amplitudes.transpose() * energy * of_amplitudes).llt().solve(of_amplitudes.transpose() * energy).eval();
  std::vector<UnseenField<D, double>> fields(vanishing.size());
  for (Eigen::Index r = 0; r < count; ++r) {
    UnseenField<D, double>& field = fields[r];
    for (int b = 0; b < D; ++b) field.gradient[b] = vanishing[r].gradient[b];
    for (int n = 0; n < pairs; ++n) field.curvature[n] = vanishing[r].curvature[n];
    for (int c = 0; c < D; ++c)
      for (int m = 0; m < D; ++m)
        for (int n = 0; n < pairs; ++n) field.amplitude[c][m][n] = amplitude(r * D + c, m * pairs + n);
  }
  return fields;
}

template std::vector<UnseenField<2, double>> unseen_fields<2>(const std::vector<VanishingField<2>>&, const Hooke&);
template std::vector<UnseenField<3, double>> unseen_fields<3>(const std::vector<VanishingField<3>>&, const Hooke&);

}  // namespace tern::structure
