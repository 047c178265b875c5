// "pi", the surface integral of the pressure (Antoci, Gallati & Sibilla 2007; Hwang et al. 2014). The load is -s_k A_k P_k n_k,
//   P_k = sum_i B_ik q_i / sum_i B_ik,   B_ik = -b_ik . n_k,
// with q_i the pressure of particle i, carried to the face by the weight of the fluid between. Every particle gets back what it has
// contributed, so that momentum is exact.

#include "coupler/schemes/scheme.hpp"
#include "sph/wet_share.hpp"

namespace tern::coupler {

template <int D>
void take_means(const Kernel<D>&, const InterfacePairs<D>& pairs, const CarriedPressure<D>&, PointPressures<D>& points) {
  points.share.resize(pairs.filled().size());
  points.gradient.clear();
  for (std::size_t k = 0; k < points.share.size(); ++k) {
    const double filled = pairs.filled()[k], wet = wet_share(filled);
    points.share[k] = wet == 0 ? 0 : wet / filled;
  }
}

template <int D>
Scheme<D> pi() {
  return {wet_share, take_means<D>, nullptr};
}

template void take_means<2>(const Kernel<2>&, const InterfacePairs<2>&, const CarriedPressure<2>&, PointPressures<2>&);
template void take_means<3>(const Kernel<3>&, const InterfacePairs<3>&, const CarriedPressure<3>&, PointPressures<3>&);
template Scheme<2> pi<2>();
template Scheme<3> pi<3>();

}  // namespace tern::coupler
