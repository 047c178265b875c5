// Moving least squares with the basis p = {1, (X_j - X)/h}:  phi_j = w_j p_j^T A^-1 p(0),  A = sum_j w_j p_j p_j^T;
// exact for linear displacement fields, also at the surface, where the point lies outside the particles.

#include "structure/material_point.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "base/error.hpp"
#include "scene/geometry.hpp"
#include "sph/kernel.hpp"
#include "sph/symmetric_matrix.hpp"
#include "structure/shell/shell_surface.hpp"

namespace tern::structure {
namespace {

/// x(xi) of the nearest particle, linear in the displacements where z = 0. Before a run `at` is held to the mid-surface within 1e-3 of the
/// thickness; the parabola x(xi) departs from it by some more. A corner that turns by an angle between two particles stands beside the
/// straight line from one to the other by a quarter of angle times spacing at most, and a path may turn by pi/5 within a spacing.
template <int D>
MaterialPoint point_of_shell(const ShellBody<D>& shell, const Body& body, const Vector<D>& at) {
  const auto& x = shell.layer.particles.position;
  const auto nearest = std::min_element(
      x.begin(), x.end(), [&](const Vector<D>& a, const Vector<D>& b) { return (a - at).squaredNorm() < (b - at).squaredNorm(); });
  constexpr double most_beside = 0.25 * 0.2 * std::numbers::pi;  // of the spacing
  ShellPoint<D> point = shell_point<D>(shell.layer, nearest - x.begin(), at - *nearest);
  const auto is_beside = [&](int a) { return std::abs(point.xi[a]) <= shell.layer.particles.spacing[a] * (1 + 1e-9); };
  if (std::abs(point.z) > std::max(0.01 * shell.layer.thickness, most_beside * shell.layer.particles.spacing[0]) || !is_beside(0) ||
      !is_beside(D - 2))
    throw BadInput(
        fmt::format("A gauge point lies {:.3g} m beside the mid-surface of the shell '{}', {:.3g} m from its nearest particle, but has to "
                    "lie on it; correct the gauge's `at`.",
                    std::abs(point.z), body.name, (at - *nearest).norm()));
  point.z = 0;
  // The load of a unit force, spread over an undeformed shell, is the row of the point.
  ShellWork<D> rest;
  rest.x = x;
  rest.derivatives = shell.layer.reference;
  MaterialPoint result;
  spread_force<D>(shell.layer, rest, point, Vector<D>::Unit(0), [&](std::size_t j, const Vector<D>& share) {
    result.particle.push_back(static_cast<std::uint32_t>(body.first + j));
    result.weight.push_back(share[0]);
  });
  return result;
}

/// By a kernel of the smoothing length `width`; empty when too few particles are within its reach.
template <int D>
MaterialPoint point_of_solid(const Reference<D>& reference, const Body& body, const Vector<D>& at, double width) {
  const Kernel<D> kernel(width);
  using Basis = Eigen::Matrix<double, D + 1, 1>;
  MaterialPoint point;
  std::vector<Basis> bases;
  Eigen::Matrix<double, D + 1, D + 1> moments = Eigen::Matrix<double, D + 1, D + 1>::Zero();
  for (std::size_t p = body.first; p < body.first + body.count; ++p) {
    const Vector<D> offset = reference.position_of(reference.particle_row[p]) - at;
    const double r = offset.norm();
    if (r >= kernel.support()) continue;
    Basis basis;
    basis << 1, offset / width;
    const double w = kernel.value(r);
    moments += w * basis * basis.transpose();
    bases.push_back(basis);
    point.particle.push_back(static_cast<std::uint32_t>(p));
    point.weight.push_back(w);
  }
  const Eigen::MatrixXd inverse = inverse_of_moments(moments);
  if (inverse.size() == 0) return {};
  const Basis solution = inverse.col(0);
  for (std::size_t n = 0; n < bases.size(); ++n) point.weight[n] *= bases[n].dot(solution);
  return point;
}

}  // namespace

template <int D>
MaterialPoint find_material_point(const Reference<D>& reference, const std::string& body_name, const Vector<D>& at) {
  const auto body = std::find_if(reference.bodies.begin(), reference.bodies.end(), [&](const Body& b) { return b.name == body_name; });
  if (body == reference.bodies.end())
    throw BadInput(
        fmt::format("A gauge asks for body '{}', but no elastic body has this name; name one of "
                    "[[structure.body]].",
                    body_name));
  if (const ShellBody<D>* shell = reference.shell_of(*body)) return point_of_shell<D>(*shell, *body, at);
  if (const double beside = signed_distance<D>(body->shape, at); beside > 1e-6 * body->spacing)
    throw BadInput(fmt::format("A gauge point lies {:.3g} m outside the body '{}', but it must lie in it; correct the gauge's `at`.",
                               beside, body_name));
  // As wide as the particles need it: an edge or a tip of the shape may be farther from them than their kernel reaches.
  const Bounds<D> bounds = bounding_box<D>(body->shape);
  for (double width = body->smoothing_length; width < 2 * (bounds.max - bounds.min).norm(); width *= 1.5) {
    MaterialPoint point = point_of_solid<D>(reference, *body, at, width);
    if (!point.particle.empty()) return point;
  }
  throw BadInput(fmt::format("A gauge point of body '{}' has no displacement: its particles stand in a row.", body_name));
}

template MaterialPoint find_material_point<2>(const Reference<2>&, const std::string&, const Vector<2>&);
template MaterialPoint find_material_point<3>(const Reference<3>&, const std::string&, const Vector<3>&);

}  // namespace tern::structure
