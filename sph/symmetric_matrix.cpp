#include "sph/symmetric_matrix.hpp"

#include <Eigen/Eigenvalues>

namespace tern {

namespace {
constexpr double largest_condition_number = 1e8;
}

Eigen::MatrixXd inverse_of_moments(const Eigen::MatrixXd& moments) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(moments);
  const auto& values = eigen.eigenvalues();
  if (!(values[0] > 0) || values[values.size() - 1] > largest_condition_number * values[0]) return {};
  return eigen.eigenvectors() * values.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
}

PartOfMoments determined_part_of_moments(const Eigen::MatrixXd& moments) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(moments);
  const auto& values = eigen.eigenvalues();  // ascending
  Eigen::Index zeros = 0;
  while (zeros < values.size() && !(values[zeros] * largest_condition_number >= values[values.size() - 1] && values[zeros] > 0)) ++zeros;
  const auto seen = eigen.eigenvectors().rightCols(values.size() - zeros);
  return {seen * values.tail(values.size() - zeros).cwiseInverse().asDiagonal() * seen.transpose(), eigen.eigenvectors().leftCols(zeros)};
}

double largest_eigenvalue(const std::vector<double>& diagonal, const std::vector<double>& beside) {
  const auto n = static_cast<Eigen::Index>(diagonal.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) matrix(k, k) = diagonal[k];
  for (Eigen::Index k = 0; k + 1 < n; ++k) matrix(k, k + 1) = matrix(k + 1, k) = beside[k];
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues()[n - 1];
}

}  // namespace tern
