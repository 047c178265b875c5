// Moving least squares with the basis p = {1, (X_j - X)/h}:  phi_j = w_j p_j^T A^-1 p(0),  A = sum_j w_j p_j p_j^T;
// exact for linear displacement fields, also at the surface, where the point lies outside the particles.

#include "structure/material_point.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "sph/kernel.hpp"

namespace tern::structure {

template <int D>
MaterialPoint find_material_point(const Reference<D>& reference, const std::string& body_name, const Vector<D>& at) {
  const auto body = std::find_if(reference.bodies.begin(), reference.bodies.end(), [&](const Body& b) { return b.name == body_name; });
  if (body == reference.bodies.end())
    throw BadInput(
        fmt::format("A gauge asks for body '{}', but no elastic body has this name; name one of "
                    "[[structure.body]].",
                    body_name));
  const Kernel<D> kernel(body->smoothing_length);
  using Basis = Eigen::Matrix<double, D + 1, 1>;
  MaterialPoint point;
  std::vector<Basis> bases;
  Eigen::Matrix<double, D + 1, D + 1> moments = Eigen::Matrix<double, D + 1, D + 1>::Zero();
  double nearest = std::numeric_limits<double>::max();
  for (std::size_t p = body->first; p < body->first + body->count; ++p) {
    const Vector<D> offset = reference.position_of(reference.particle_row[p]) - at;
    const double r = offset.norm();
    nearest = std::min(nearest, r);
    if (r >= kernel.support()) continue;
    Basis basis;
    basis << 1, offset / body->smoothing_length;
    const double w = kernel.value(r);
    moments += w * basis * basis.transpose();
    bases.push_back(basis);
    point.particle.push_back(static_cast<std::uint32_t>(p));
    point.weight.push_back(w);
  }
  const Eigen::FullPivLU<Eigen::Matrix<double, D + 1, D + 1>> factor(moments);
  if (nearest > body->spacing || !factor.isInvertible())
    throw BadInput(
        fmt::format("A gauge point lies {:.3g} m from the nearest particle of body '{}', but it must lie in the "
                    "body (within one spacing, {:.3g} m); correct the gauge's `at`.",
                    nearest, body_name, body->spacing));
  const Basis solution = factor.solve(Basis::Unit(0));
  for (std::size_t n = 0; n < bases.size(); ++n) point.weight[n] *= bases[n].dot(solution);
  return point;
}

template MaterialPoint find_material_point<2>(const Reference<2>&, const std::string&, const Vector<2>&);
template MaterialPoint find_material_point<3>(const Reference<3>&, const std::string&, const Vector<3>&);

}  // namespace tern::structure
