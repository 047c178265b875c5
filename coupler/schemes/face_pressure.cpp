#include "coupler/schemes/face_pressure.hpp"

#include <algorithm>

namespace tern::coupler {
namespace {

/// Share of a face that is wet, from the share of its kernel that fluid fills: as for walls (fluid/boundary/boundary.cpp).
double wet_share(double filled) { return std::clamp(2 * filled - 0.5, 0.0, 1.0); }

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

}  // namespace

template <int D>
void integrate_over_faces(const Kernel<D>& kernel, std::span<const InterfacePair<D>> pairs, const Surface<D>& surface,
                          const InterfaceParticles<D>& band, InterfaceScheme scheme, std::vector<double>& carried) {
  std::vector<FaceSums<D>> sums(surface.position.size());
  for (std::size_t m = 0; m < pairs.size(); ++m) {
    FaceSums<D>& at = sums[pairs[m].point];
    const double b = -pairs[m].b.dot(surface.normal[pairs[m].point]), q = carried[m];
    at.area += b;
    at.pressure += b * q;
    if (scheme != InterfaceScheme::fsa) continue;
    const Vector<D>& d = pairs[m].offset;
    const Vector<D> gradient = band.volume[pairs[m].particle] * kernel.gradient_weight(d.norm()) * d;
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
    if (scheme == InterfaceScheme::fsa) gradient[k] = corrected_gradient<D>(sums[k]);
  }
  for (std::size_t m = 0; m < pairs.size(); ++m)
    carried[m] = share[pairs[m].point] * (carried[m] - gradient[pairs[m].point].dot(pairs[m].offset));
}

template <int D>
std::vector<double> uniform_load(std::span<const InterfacePair<D>> pairs, const Surface<D>& surface, InterfaceScheme scheme) {
  std::vector<double> filled(surface.position.size(), 0);
  for (const auto& pair : pairs) filled[pair.point] -= pair.b.dot(surface.normal[pair.point]) / surface.area[pair.point];
  if (scheme != InterfaceScheme::riemann)
    for (double& f : filled) f = wet_share(f);
  return filled;
}

template std::vector<double> uniform_load<2>(std::span<const InterfacePair<2>>, const Surface<2>&, InterfaceScheme);
template std::vector<double> uniform_load<3>(std::span<const InterfacePair<3>>, const Surface<3>&, InterfaceScheme);
template void integrate_over_faces<2>(const Kernel<2>&, std::span<const InterfacePair<2>>, const Surface<2>&, const InterfaceParticles<2>&,
                                      InterfaceScheme, std::vector<double>&);
template void integrate_over_faces<3>(const Kernel<3>&, std::span<const InterfacePair<3>>, const Surface<3>&, const InterfaceParticles<3>&,
                                      InterfaceScheme, std::vector<double>&);

}  // namespace tern::coupler
