// Moment matrix and its inverse (Randles & Libersky 1996; Bonet & Lok 1999):
//   M_i = sum_j V_j grad w_ij (r_j - r_i)^T over fluid and hidden side,  C_i = (M_i - T_i)^-1
// M is symmetric and positive semi-definite, so its smallest eigenvalue tells whether C may be used. T is the part of hidden sides
// along their faces; it is left to the fluid (pressure_gradient.cpp). C^F is the inverse over fluid neighbours alone.

#include "fluid/correction_matrix.hpp"

#include <Eigen/Eigenvalues>

#include "base/parallel.hpp"
#include "fluid/eigenvalue.hpp"

namespace tern::fluid {
namespace {

constexpr double least_eigenvalue = 0.2;  ///< below, the inverse is not trusted

/// Inverse of a symmetric matrix in the directions in which it is to be trusted, 0 in the others.
template <int D>
Matrix<D> trusted_inverse(const Matrix<D>& m) {
  Eigen::SelfAdjointEigenSolver<Matrix<D>> solver;
  solver.computeDirect(m);
  Vector<D> inverse;
  for (int c = 0; c < D; ++c) inverse[c] = solver.eigenvalues()[c] < least_eigenvalue ? 0 : 1 / solver.eigenvalues()[c];
  return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace

template <int D>
void correct_moments(const Neighbours<D>& neighbours, const Boundary<D>& boundary, std::vector<ParticleClass>& particle_class,
                     Corrections<D>& correction) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(neighbours.rows());
  correction.matrix.resize(n);
  correction.fluid.resize(n);
  correction.trace.resize(n);
  parallel_for(n, [&](std::ptrdiff_t i) {
    const Matrix<D> m = neighbours.moment[i] + boundary.sums.moment[i];
    correction.trace[i] = m.trace() / D;
    const bool has_gradient = eigenvalues_reach<D>(neighbours.moment[i], least_eigenvalue);
    particle_class[i].set(ParticleClass::corrected_gradient, has_gradient);
    correction.fluid[i] = has_gradient ? Matrix<D>(neighbours.moment[i].inverse()) : Matrix<D>::Zero();
    if (!has_gradient && boundary.sees_structure(i) && particle_class[i].inside())
      correction.fluid[i] = trusted_inverse<D>(neighbours.moment[i]);
    if (!boundary.sees_face(i)) {
      correction.matrix[i] = has_gradient ? correction.fluid[i] : Matrix<D>::Identity();
      return;
    }
    const Matrix<D> across = m - boundary.sums.tangential[i];
    const bool trusted = eigenvalues_reach<D>(0.5 * (across + across.transpose()), least_eigenvalue);
    correction.matrix[i] = trusted ? Matrix<D>(across.inverse()) : Matrix<D>::Identity();
  });
}

template void correct_moments<2>(const Neighbours<2>&, const Boundary<2>&, std::vector<ParticleClass>&, Corrections<2>&);
template void correct_moments<3>(const Neighbours<3>&, const Boundary<3>&, std::vector<ParticleClass>&, Corrections<3>&);

}  // namespace tern::fluid
