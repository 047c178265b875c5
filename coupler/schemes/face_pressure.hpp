#pragma once
// Schemes whose load is a pressure per surface point times its area, -s_k A_k P_k n_k, where s_k is the wet share of the face:
//   pi    P_k = sum_i B_ik q_i / sum_i B_ik,   B_ik = -b_ik . n_k, q_i: pressure of particle i carried to the face by the
//         weight of the fluid between (Antoci, Gallati & Sibilla 2007; Hwang et al. 2014)
//   fsa   seed paper eq. 5. Over the section behind the point, from P_k at the face to 0 behind it, the acceleration
//         -(1/rho_S) grad p adds up to the same load, whatever the thickness. The particles' pressures are carried to the
//         face by the corrected gradient G of eq. 5 over the fluid; P_k is such that they explain each other in the mean:
//           sum V_i grad w_ki (q_i - P_k) = [sum V_i grad w_ki d_i^T] G,   sum B_ik (q_i - P_k - G . d_i) = 0,
//         d_i = x_i - x_k: exact for linear pressures. With the weight of the fluid carried before, G is what the
//         pressure gradient differs from rho g.
// Every particle gets back what it has contributed, so that momentum is exact. Published, eq. 5 has no reaction: the
// fluid's pressure gradient at the structure is a sum of its own.

#include <span>
#include <vector>

#include "coupler/schemes/interface_pairs.hpp"
#include "scene/case_file.hpp"

namespace tern::coupler {

/// Replaces the carried pressures q_i [Pa] of all pairs by those which, times b_ik, are the pair forces of the scheme.
template <int D>
void integrate_over_faces(const Kernel<D>& kernel, std::span<const InterfacePair<D>> pairs, const Surface<D>& surface,
                          const InterfaceParticles<D>& band, InterfaceScheme scheme, std::vector<double>& carried);

/// Load of every surface point under a uniform pressure, over that pressure times its area. With riemann what the pairs fill of the
/// half space before it, with pi and fsa its wet share.
template <int D>
std::vector<double> uniform_load(std::span<const InterfacePair<D>> pairs, const Surface<D>& surface, InterfaceScheme scheme);

}  // namespace tern::coupler
