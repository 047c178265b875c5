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
void find_gradients(const Kernel<D>& kernel, const InterfacePairs<D>& pairs, const CarriedPressure<D>& carried, PointPressures<D>& points) {
  const Surface<D>& surface = carried.surface;
  std::vector<FaceSums<D>> sums(surface.position.size());
  for (const auto& pair : pairs.all_pairs()) {
    FaceSums<D>& at = sums[pair.point];
    const double b = -pair.b.dot(surface.normal[pair.point]), q = carried(pair.particle, pair.point);
    at.area += b;
    at.pressure += b * q;
    const Vector<D>& d = pair.offset;
    const Vector<D> gradient = carried.particles.volume[pair.particle] * kernel.gradient_weight(d.norm()) * d;
    at.offset += b * d;
    at.gradient += gradient;
    at.product += gradient * q;
    at.moment += gradient * d.transpose();
  }
  points.share.assign(sums.size(), 0);
  points.gradient.assign(sums.size(), Vector<D>::Zero());
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const double filled = sums[k].area / surface.area[k];
    if (wet_share(filled) == 0) continue;
    points.share[k] = wet_share(filled) / filled;
    points.gradient[k] = corrected_gradient<D>(sums[k]);
  }
}

}  // namespace

template <int D>
Scheme<D> fsa() {
  return {wet_share, find_gradients<D>, nullptr};
}

template Scheme<2> fsa<2>();
template Scheme<3> fsa<3>();

}  // namespace tern::coupler
