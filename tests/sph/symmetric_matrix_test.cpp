#include "sph/symmetric_matrix.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tern {
namespace {

TEST(SymmetricMatrix, TheInverseOfMomentsIsTheirInverse) {
  Eigen::MatrixXd basis(3, 5);
  basis << 1, 1, 1, 1, 1, 0, 0.3, -0.7, 1.1, 0.2, 0.5, -0.4, 0.9, 0.1, -1.3;
  const Eigen::MatrixXd moments = basis * basis.transpose();
  EXPECT_LT((inverse_of_moments(moments) * moments - Eigen::MatrixXd::Identity(3, 3)).norm(), 1e-13);
}

TEST(SymmetricMatrix, PointsOnALineDetermineNoPlane) {
  Eigen::MatrixXd basis(3, 4);
  basis << 1, 1, 1, 1, 0, 1, 2, 3, 1, 3, 5, 7;
  EXPECT_EQ(inverse_of_moments(basis * basis.transpose()).size(), 0);
}

// 2 on the diagonal and -1 beside it: 2 - 2 cos(k pi/(n + 1)), k = 1..n.
TEST(SymmetricMatrix, TheLargestEigenvalueOfAChainIsTheKnownOne) {
  for (const int n : {1, 2, 7}) {
    const std::vector<double> diagonal(n, 2.0), beside(n - 1, -1.0);
    EXPECT_NEAR(largest_eigenvalue(diagonal, beside), 2 - 2 * std::cos(n * std::numbers::pi / (n + 1)), 1e-14) << n;
  }
}

}  // namespace
}  // namespace tern
