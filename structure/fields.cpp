// Output fields: Cauchy stress sigma = P F^T / J and its von Mises value. P is the stress at the middle of a particle's cell,
// without the part of the strain gradient. In plane strain the stress out of the plane (neo-Hookean: lambda ln J / J; St
// Venant-Kirchhoff: lambda tr E / J) enters the von Mises value; in plane stress it is zero, and J includes the thickness.

#include <algorithm>
#include <cmath>

#include "structure/material/energy.hpp"
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
    }
    const Body& body = reference.bodies[reference.particle_body[p]];
    const Material& m = body.material;
    const Matrix<D> f = deformation_gradient_of<D>(work, row);
    const Matrix<D> h = f - Matrix<D>::Identity(), e = 0.5 * (h + h.transpose() + h.transpose() * h);
    double j = f.determinant(), out_of_plane = 0;
    if (m.law == MaterialLaw::neo_hookean) {
      double log_j = std::log(j);
      if (m.plane_stress) {
        const double log_f33 = m.log_thickness_stretch(log_j);
        log_j += log_f33;
        j *= std::exp(log_f33);
      }
      stress = m.mu * f + (m.lambda * log_j - m.mu) * f.inverse().transpose();
      out_of_plane = m.plane_stress ? 0 : m.lambda * log_j / j;
    } else {
      stress = f * (m.plane_lambda * e.trace() * Matrix<D>::Identity() + 2 * m.mu * e);
      if (m.plane_stress)
        j *= std::sqrt(std::max(1 - 2 * m.lambda / (m.lambda + 2 * m.mu) * e.trace(), 0.0));
      else
        out_of_plane = m.lambda * e.trace() / j;
    }
    Eigen::Matrix3d full = Eigen::Matrix3d::Zero();
    full.topLeftCorner<D, D>() = stress * f.transpose() / j;
    if (D == 2) full(2, 2) = out_of_plane;
    const Eigen::Matrix3d deviator = full - full.trace() / 3 * Eigen::Matrix3d::Identity();
    fields.position.push_back(reference.position_of(row) + d);
    fields.displacement.push_back(d);
    fields.velocity.push_back(v);
    fields.stress.push_back(full.topLeftCorner<D, D>());
    fields.von_mises.push_back(std::sqrt(1.5) * deviator.norm());
    fields.jacobian.push_back(j);
    fields.energy_density.push_back(energy_density<D>(body, work, row));
    fields.clamped.push_back(reference.inverse_mass[row] == 0);
  }
  return fields;
}

template Fields<2> fields_of<2>(const Reference<2>&, const State<2>&, const Workspace<2>&);
template Fields<3> fields_of<3>(const Reference<3>&, const State<3>&, const Workspace<3>&);

}  // namespace tern::structure
