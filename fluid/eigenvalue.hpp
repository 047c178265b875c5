#pragma once
// Smallest eigenvalue of a symmetric matrix.

#include <cmath>

#include <Eigen/Eigenvalues>

#include "particles/vector.hpp"

namespace tern::fluid {

template <int D>
double smallest_eigenvalue(const Matrix<D>& m) {
  if constexpr (D == 2) {
    const double mean = 0.5 * (m(0, 0) + m(1, 1)), half = 0.5 * (m(0, 0) - m(1, 1));
    return mean - std::sqrt(half * half + m(0, 1) * m(0, 1));
  } else {
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(Eigen::Matrix3d(m), Eigen::EigenvaluesOnly);
    return solver.eigenvalues()[0];
  }
}

}  // namespace tern::fluid
