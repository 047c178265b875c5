// The spectral decompositions that the methods need, of symmetric matrices of up to a few dozen rows.

#pragma once

#include <Eigen/Core>
#include <vector>

namespace tern {

/// Inverse of the moment matrix of a least-squares fit; empty where its condition number says that the points do not determine the fit.
Eigen::MatrixXd inverse_of_moments(const Eigen::MatrixXd& moments);

/// The same for points that do not determine the fit: a basis of the fits that are zero at all points, as columns, and the inverse on the
/// fits that are orthogonal to them.
struct PartOfMoments {
  Eigen::MatrixXd inverse, vanishing;
};
PartOfMoments determined_part_of_moments(const Eigen::MatrixXd& moments);

/// Largest eigenvalue of the symmetric tridiagonal matrix with this diagonal and these values beside it (n - 1 of n, n > 0).
double largest_eigenvalue(const std::vector<double>& diagonal, const std::vector<double>& beside);

}  // namespace tern
