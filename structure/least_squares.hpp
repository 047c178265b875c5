#pragma once
// Sparse systems that are solved once, when a body is built.

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/Sparse>
#include <cstddef>
#include <vector>

namespace tern::structure {

/// x of least |A x - b|, the shortest where several are, by conjugate gradients. `entries`: of A; `right`: b; `unknowns`: length of x.
inline Eigen::VectorXd least_squares(const std::vector<Eigen::Triplet<double>>& entries, const std::vector<double>& right,
                                     std::size_t unknowns, double tolerance) {
  Eigen::SparseMatrix<double> matrix(static_cast<Eigen::Index>(right.size()), static_cast<Eigen::Index>(unknowns));
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::LeastSquaresConjugateGradient<Eigen::SparseMatrix<double>> solver(matrix);
  solver.setTolerance(tolerance);
  return solver.solve(Eigen::Map<const Eigen::VectorXd>(right.data(), matrix.rows()));
}

}  // namespace tern::structure
