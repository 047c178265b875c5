// Output fields: Cauchy stress sigma = P F^T / J and its von Mises value. P is the stress at the middle of a particle's cell,
// without the part of the strain gradient. In plane strain the stress out of the plane enters the von Mises value; in plane
// stress it is zero, and J includes the thickness. Of a shell: the stress of the mid-surface, the von Mises value of the face where it is
// larger, and for J the stretch of the area.

#include <cmath>
#include <utility>

#include "structure/energy.hpp"
#include "structure/shell/shell_body.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// P of one particle.
template <int D, class Law>
Matrix<D> stress_of(const Law& law, const Matrix<D>& h, const Matrix<D>& f, double j) {
  const Matrix<D> inverse_transposed = f.inverse().transpose();
  double h_of[D][D], f_of[D][D], inverse_of[D][D], p[D][D];
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) {
      h_of[a][b] = h(a, b);
      f_of[a][b] = f(a, b);
      inverse_of[a][b] = inverse_transposed(a, b);
    }
  law.template stress<D>(h_of, f_of, inverse_of, j, p);
  Matrix<D> result;
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) result(a, b) = p[a][b];
  return result;
}

}  // namespace

template <int D>
Fields<D> fields_of(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work) {
  const std::size_t count = reference.particle_row.size();
  Fields<D> fields;
  fields.body = reference.particle_body;
  for (std::size_t p = 0; p < count; ++p) {
    const auto row = reference.particle_row[p];
    Vector<D> d, v;
    for (int a = 0; a < D; ++a) {
      d[a] = state.displacement[a][row];
      v[a] = state.velocity[a][row];
    }
    const Body& body = reference.bodies[reference.particle_body[p]];
    fields.position.push_back(reference.position_of(row) + d);
    fields.displacement.push_back(d);
    fields.velocity.push_back(v);
    fields.clamped.push_back(reference.inverse_mass[row] == 0);
    const ShellBody<D>* shell = reference.shell_of(body);
    if (!reference.shells.empty()) fields.shell_thickness.push_back(shell == nullptr ? 0 : shell->layer.thickness);
    if (shell != nullptr) {
      const ShellStress<D> of = shell_stress(*shell, work, row - shell->first_row);
      fields.stress.push_back(of.cauchy);
      fields.von_mises.push_back(of.von_mises);
      fields.jacobian.push_back(of.area_ratio);
      fields.energy_density.push_back(of.energy_density);
      continue;
    }
    const Matrix<D> f = deformation_gradient_of<D>(work, row), h = f - Matrix<D>::Identity();
    const double j2 = f.determinant();
    const auto [piola, across] = std::visit(
        [&](const auto& law) {
          return std::pair(stress_of<D>(law, h, f, j2), D == 2 ? law.template out_of_plane<D>(h, j2) : OutOfPlane{});
        },
        body.material.law);
    const double j = j2 * across.stretch;
    Eigen::Matrix3d full = Eigen::Matrix3d::Zero();
    full.topLeftCorner<D, D>() = piola * f.transpose() / j;
    if (D == 2) full(2, 2) = across.stress;
    const Eigen::Matrix3d deviator = full - full.trace() / 3 * Eigen::Matrix3d::Identity();
    fields.stress.push_back(full.topLeftCorner<D, D>());
    fields.von_mises.push_back(std::sqrt(1.5) * deviator.norm());
    fields.jacobian.push_back(j);
    fields.energy_density.push_back(energy_density<D>(body, work, row));
  }
  return fields;
}

template Fields<2> fields_of<2>(const Reference<2>&, const State<2>&, const Workspace<2>&);
template Fields<3> fields_of<3>(const Reference<3>&, const State<3>&, const Workspace<3>&);

}  // namespace tern::structure
