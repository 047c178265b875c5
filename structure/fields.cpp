// Output fields: Cauchy stress sigma = P F^T / J and its von Mises value. In 2D (plane strain) the stress out of the plane,
// lambda ln J / J, enters the von Mises value.

#include <cmath>

#include "structure/energy.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {

template <int D>
Fields<D> fields_of(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work) {
  const std::size_t count = reference.particle_row.size();
  Fields<D> fields;
  fields.body = reference.particle_body;
  for (std::size_t p = 0; p < count; ++p) {
    const auto row = reference.particle_row[p];
    Vector<D> d, v;
    Matrix<D> stress;
    for (int a = 0; a < D; ++a) {
      d[a] = state.displacement[a][row];
      v[a] = state.velocity[a][row];
      for (int b = 0; b < D; ++b) stress(a, b) = work.stress[a][b][row];
    }
    const Matrix<D> f = deformation_gradient_of<D>(work, row);
    const double j = f.determinant();
    Eigen::Matrix3d full = Eigen::Matrix3d::Zero();
    full.topLeftCorner<D, D>() = stress * f.transpose() / j;
    if (D == 2) full(2, 2) = reference.bodies[reference.particle_body[p]].material.lambda * std::log(j) / j;
    const Eigen::Matrix3d deviator = full - full.trace() / 3 * Eigen::Matrix3d::Identity();
    fields.position.push_back(reference.position_of(row) + d);
    fields.displacement.push_back(d);
    fields.velocity.push_back(v);
    fields.stress.push_back(full.topLeftCorner<D, D>());
    fields.von_mises.push_back(std::sqrt(1.5) * deviator.norm());
    fields.jacobian.push_back(j);
    fields.clamped.push_back(reference.inverse_mass[row] == 0);
  }
  return fields;
}

template Fields<2> fields_of<2>(const Reference<2>&, const State<2>&, const Workspace<2>&);
template Fields<3> fields_of<3>(const Reference<3>&, const State<3>&, const Workspace<3>&);

}  // namespace tern::structure
