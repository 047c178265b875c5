#pragma once
// Divergence of the velocity.

#include "fluid/boundary/boundary.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// div u of particle i, of its velocity and S_i (velocity_gradient.hpp) [1/s]. S_i may be from before the same was added to all
/// velocities.
template <int D>
[[gnu::always_inline]] inline double divergence_of(const Matrix<D>& sum, const Vector<D>& velocity, const Boundary<D>& boundary,
                                                   const Corrections<D>& correction, ParticleClass particle_class, std::ptrdiff_t i) {
  const auto trace_of_product = [](const Matrix<D>& a, const Matrix<D>& b) { return a.cwiseProduct(b.transpose()).sum(); };
  if (!boundary.sees_face(i))
    return particle_class.has(ParticleClass::symmetric_gradient) ? sum.trace() : trace_of_product(sum, correction.fluid[i]);
  const double through_faces = boundary.sums.flux[i] + velocity.dot(boundary.sums.wall_gradient[i] + boundary.sums.surface_gradient[i]);
  return sum.trace() + boundary.sums.tangential[i].cwiseProduct(sum * correction.fluid[i]).sum() - 2 * through_faces;
}

/// div u of the particles `only`, or with nullptr of every one [1/s]. `packed`: the velocity by axis.
template <int D>
void compute_divergence(const Period<D>& space, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                        const Corrections<D>& correction, const std::vector<ParticleClass>& particle_class,
                        const std::vector<Vector<D>>& velocity, const std::vector<int>* only, ByAxis<D>& packed,
                        std::vector<double>& divergence);

}  // namespace tern::fluid
