#pragma once
// The second derivatives of the energy of a layer, for the tangent of implicit steps.

#include <span>

#include "structure/shell/shell_layer.hpp"

namespace tern::structure {

template <int D>
using ShellHessian = Eigen::Matrix<double, D * shell_unknowns<D>, D * shell_unknowns<D>>;

/// d2W/dq2 of particle i, q the derivatives column by column: component a of column s is q[D s + a]. `turn`: R of each clamp.
template <int D>
ShellHessian<D> shell_energy_hessian(const ShellLayer<D>& layer, std::size_t i, const ShellDerivatives<D>& derivatives,
                                     std::span<const Matrix<D>> turn);

}  // namespace tern::structure
