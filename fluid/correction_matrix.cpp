// Moment matrix and its inverse (Randles & Libersky 1996; Bonet & Lok 1999):
//   M_i = sum_j V_j grad w_ij (r_j - r_i)^T over fluid and hidden side,  C_i = M_i^-1.
// M is symmetric and positive semi-definite, so its smallest eigenvalue tells whether C may be used.

#include <Eigen/Eigenvalues>

#include "fluid/fluid.hpp"
#include "particles/parallel.hpp"

namespace tern::fluid {
namespace {

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

}  // namespace

template <int D>
void Fluid<D>::correct_moments() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  correction_.resize(n);
  trace_.resize(n);
  smallest_eigenvalue_.resize(n);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const Matrix<D> m = neighbours_.moment[i] + boundary_.moment[i];
    trace_[i] = m.trace() / D;
    smallest_eigenvalue_[i] = smallest_eigenvalue<D>(m);
    correction_[i] = smallest_eigenvalue_[i] >= 0.2 ? Matrix<D>(m.inverse()) : Matrix<D>::Identity();
  }
}

template void Fluid<2>::correct_moments();
template void Fluid<3>::correct_moments();

}  // namespace tern::fluid
