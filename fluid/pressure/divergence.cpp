// Velocity divergence, with S_i = sum_F V_j (u_j - u_i) grad w_ij^T (difference form, zero for constants):
//   inside:            div_i = tr(S_i C_i)                                exact for linear fields
//   symmetric:         div_i = tr S_i                                     the adjoint of that form of the pressure gradient
//   at faces also:     - 2 sum_k A_k w~_ik n_k . (u_k - u_i)  +  T_i : S_i C^F_i
// The factor 2 is the mirror velocity 2 u_k - u_i of the hidden side; without it half the flux through a wall is lost. Along
// a face the velocity behind it varies as that before it: without T, the part of the moments along hidden faces, fluid that
// stretches along a wall and thins towards it would seem to be compressed, by a quarter of the rate at which it stretches.

#include "fluid/pressure/divergence.hpp"

#include "base/parallel.hpp"
#include "fluid/motion/velocity_gradient.hpp"

namespace tern::fluid {
namespace {

/// tr(A B)
template <int D>
double trace_of_product(const Matrix<D>& a, const Matrix<D>& b) {
  return a.cwiseProduct(b.transpose()).sum();
}

}  // namespace

template <int D>
void compute_divergence(const Period<D>& space, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                        const Corrections<D>& correction, const std::vector<ParticleClass>& particle_class,
                        const std::vector<Vector<D>>& velocity, const std::vector<int>* only, ByAxis<D>& packed,
                        std::vector<double>& divergence) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(neighbours.rows());
  divergence.resize(n);
  const std::ptrdiff_t rows = only ? static_cast<std::ptrdiff_t>(only->size()) : n;
  by_axis<D>(velocity, packed);
  space.specialise([&](auto periodic) {
    const LanePeriod<decltype(periodic)::value, D> period(space);
    parallel_for(rows, [&](std::ptrdiff_t m) {
      const std::ptrdiff_t i = only ? (*only)[m] : m;
      const Matrix<D> sum = velocity_gradient_sum<decltype(periodic)::value, D>(neighbours, period, packed, i);
      if (!boundary.sees_face(i)) {
        divergence[i] =
            particle_class[i].has(ParticleClass::symmetric_gradient) ? sum.trace() : trace_of_product<D>(sum, correction.fluid[i]);
        return;
      }
      const double through_faces = boundary.sums.flux[i] + velocity[i].dot(boundary.sums.faces_gradient(i));
      divergence[i] = sum.trace() + boundary.sums.tangential[i].cwiseProduct(sum * correction.fluid[i]).sum() - 2 * through_faces;
    });
  });
}

template void compute_divergence<2>(const Period<2>&, const Neighbours<2>&, const Boundary<2>&, const Corrections<2>&,
                                    const std::vector<ParticleClass>&, const std::vector<Vector<2>>&, const std::vector<int>*, ByAxis<2>&,
                                    std::vector<double>&);
template void compute_divergence<3>(const Period<3>&, const Neighbours<3>&, const Boundary<3>&, const Corrections<3>&,
                                    const std::vector<ParticleClass>&, const std::vector<Vector<3>>&, const std::vector<int>*, ByAxis<3>&,
                                    std::vector<double>&);

}  // namespace tern::fluid
