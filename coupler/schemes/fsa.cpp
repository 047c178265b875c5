// "fsa", the acceleration of the structure by the pressure gradient (seed paper eq. 5). Over the section behind a point the pressure
// falls from P_k at the face to 0 behind it; there the acceleration -(1/rho_S) grad p adds up to the load -s_k A_k P_k n_k, whatever
// the thickness. The particles' pressures q_i are carried to the face by the corrected gradient G of eq. 5 over the fluid, and P_k is
// the pressure with which they explain each other in the mean:
//   sum V_i grad w_ki (q_i - P_k) = [sum V_i grad w_ki d_i^T] G,   sum B_ik (q_i - P_k - G . d_i) = 0,   d_i = x_i - x_k.
// This is exact for linear pressures. The weight of the fluid has been carried before, so that G is what the pressure gradient differs
// from rho g. Every particle gets back what it has contributed, so that momentum is exact. As published, eq. 5 has no reaction: the
// fluid's pressure gradient at the structure is a sum of its own.

#include "coupler/schemes/scheme.hpp"
#include "sph/wet_share.hpp"

namespace tern::coupler {
namespace {

/// Of the matrix that gives the gradient; 0.1 on the half space of a lattice. Below, the particles do not determine a
/// gradient: too few of them, or all in one layer.
constexpr double least_singular_value = 0.03;

/// What a surface point sums over the particles it sees.
template <int D>
struct FaceSums {
  double area = 0, pressure = 0;           ///< sum B, sum B q
  Vector<D> offset = Vector<D>::Zero();    ///< sum B d
  Vector<D> gradient = Vector<D>::Zero();  ///< sum V grad w
  Vector<D> product = Vector<D>::Zero();   ///< sum V grad w q
  Matrix<D> moment = Matrix<D>::Zero();    ///< sum V grad w d^T
};

/// G, with P_k eliminated; zero where it is not determined.
template <int D>
Vector<D> corrected_gradient(const FaceSums<D>& sums) {
  const Matrix<D> system = sums.moment - sums.gradient * (sums.offset / sums.area).transpose();
  const Matrix<D> inverse = system.inverse();
  // The norm of the inverse bounds the smallest singular value.
  if (!(inverse.norm() < 1 / least_singular_value)) return Vector<D>::Zero();
  return inverse * (sums.product - sums.pressure / sums.area * sums.gradient);
}

template <int D>
void pair_pressures(const PairView<D>& view, std::vector<double>& carried) {
  const auto& [kernel, pairs, surface, particles, weighed_area] = view;
  std::vector<FaceSums<D>> sums(surface.position.size());
  for (std::size_t m = 0; m < pairs.size(); ++m) {
    FaceSums<D>& at = sums[pairs[m].point];
    const double b = -pairs[m].b.dot(surface.normal[pairs[m].point]), q = carried[m];
    at.area += b;
    at.pressure += b * q;
    const Vector<D>& d = pairs[m].offset;
    const Vector<D> gradient = particles.volume[pairs[m].particle] * kernel.gradient_weight(d.norm()) * d;
    at.offset += b * d;
    at.gradient += gradient;
    at.product += gradient * q;
    at.moment += gradient * d.transpose();
  }
  std::vector<double> share(sums.size(), 0);
  std::vector<Vector<D>> gradient(sums.size(), Vector<D>::Zero());
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const double filled = sums[k].area / surface.area[k];
    if (wet_share(filled) == 0) continue;
    share[k] = wet_share(filled) / filled;
    gradient[k] = corrected_gradient<D>(sums[k]);
  }
  for (std::size_t m = 0; m < pairs.size(); ++m)
    carried[m] = share[pairs[m].point] * (carried[m] - gradient[pairs[m].point].dot(pairs[m].offset));
}

}  // namespace

template <int D>
Scheme<D> fsa() {
  return {wet_share, pair_pressures<D>, nullptr};
}

template Scheme<2> fsa<2>();
template Scheme<3> fsa<3>();

}  // namespace tern::coupler
