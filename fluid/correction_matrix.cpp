// Moment matrix and its inverse (Randles & Libersky 1996; Bonet & Lok 1999):
//   M_i = sum_j V_j grad w_ij (r_j - r_i)^T over fluid and hidden side,  C_i = (M_i - T_i)^-1
// M is symmetric and positive semi-definite, so its smallest eigenvalue tells whether C may be used. T, the part of hidden
// sides along their faces, is left to the fluid: see pressure_gradient.cpp. C^F is the inverse over fluid neighbours alone.

#include "base/parallel.hpp"
#include "fluid/eigenvalue.hpp"
#include "fluid/fluid.hpp"

namespace tern::fluid {
namespace {

constexpr double least_eigenvalue = 0.2;  ///< below, the inverse is not trusted

}  // namespace

template <int D>
void Fluid<D>::correct_moments() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  correction_.resize(n);
  fluid_correction_.resize(n);
  has_gradient_.resize(n);
  trace_.resize(n);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const Matrix<D> m = neighbours_.moment[i] + boundary_.moment[i];
    trace_[i] = m.trace() / D;
    has_gradient_[i] = eigenvalues_reach<D>(neighbours_.moment[i], least_eigenvalue);
    fluid_correction_[i] = has_gradient_[i] ? Matrix<D>(neighbours_.moment[i].inverse()) : Matrix<D>::Zero();
    if (wall_rows_.count[i] == 0 && surface_rows_.count[i] == 0) {
      correction_[i] = has_gradient_[i] ? fluid_correction_[i] : Matrix<D>::Identity();
      continue;
    }
    const Matrix<D> across = m - boundary_.tangential[i];
    const bool trusted = eigenvalues_reach<D>(0.5 * (across + across.transpose()), least_eigenvalue);
    correction_[i] = trusted ? Matrix<D>(across.inverse()) : Matrix<D>::Identity();
  }
}

template void Fluid<2>::correct_moments();
template void Fluid<3>::correct_moments();

}  // namespace tern::fluid
