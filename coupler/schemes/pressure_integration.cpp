// "pi", the surface integral of the pressure (Antoci, Gallati & Sibilla 2007; Hwang et al. 2014). The load is -s_k A_k P_k n_k,
//   P_k = sum_i B_ik q_i / sum_i B_ik,   B_ik = -b_ik . n_k,
// with q_i the pressure of particle i, carried to the face by the weight of the fluid between. Every particle gets back what it has
// contributed, so that momentum is exact.

#include "base/parallel.hpp"
#include "coupler/schemes/scheme.hpp"
#include "sph/wet_share.hpp"

namespace tern::coupler {
template <int D>
void mean_pair_pressures(const PairView<D>& view, std::vector<double>& carried) {
  thread_local std::vector<double> share;  // kept, so that a window allocates nothing
  share = view.weighed_area;
  for (std::size_t k = 0; k < share.size(); ++k) {
    const double filled = share[k] / view.surface.area[k], wet = wet_share(filled);
    share[k] = wet == 0 ? 0 : wet / filled;
  }
  const std::vector<double>& factor = share;  // of the calling thread
  parallel_for(static_cast<std::ptrdiff_t>(view.pairs.size()),
               [&](std::ptrdiff_t m) { carried[m] = factor[view.pairs.point(m)] * carried[m]; });
}

template <int D>
Scheme<D> pi() {
  return {wet_share, mean_pair_pressures<D>, nullptr};
}

template void mean_pair_pressures<2>(const PairView<2>&, std::vector<double>&);
template void mean_pair_pressures<3>(const PairView<3>&, std::vector<double>&);
template Scheme<2> pi<2>();
template Scheme<3> pi<3>();

}  // namespace tern::coupler
