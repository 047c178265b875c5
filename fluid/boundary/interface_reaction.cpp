// The reaction of the interface to a uniform pressure p is -2 V_i p on a particle times
//   sum_k s_k/f_k A_k w~_ik n_k,    f_k = sum_i 2 V_i w~_ik
// over front- and back-facing faces, with the borne shares of corners. f_k is what particles and images fill of the half space before a
// face, s_k its wet share: the reaction of a load s_k p A_k, taken from whatever particles there are. It is exactly that of the coupler.
//
// The weight of the fluid, grad p = rho g, is in the sums as (M^F + T + H) rho g, with H = -2 sum_k s_k/f_k A_k w~ n_k d_ik^T what the
// interface gives back and walls mirror. On a lattice before a face the normal part of this is 0.92 rho g in the first layer and 1.08 rho g
// in the second: the pressure of a mirror, which a lattice continues, is not what faces bear by pairs. The pressure equation hardly sees
// layers that move against each other, so this would drive them until they stand in another order. What is missing is added.

#include "fluid/boundary/interface_reaction.hpp"

#include "sph/wet_share.hpp"

namespace tern::fluid {
template <int D>
void find_interface_reaction(const Constants<D>& constants, const Ranks& ranks, const InterfaceParticles<D>& particles,
                             const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                             const std::vector<int>& at_structure, Boundary<D>& boundary) {
  const Faces<D>& faces = boundary.surface;
  const FaceRows& rows = boundary.surface_rows;
  BoundarySums<D>& sums = boundary.sums;

  // What a face and a particle exchange does not ask whether the face is wet: f_k says that.
  const auto whole = [&](int i, int entry) {
    const int k = rows.face[entry];
    return rows.wet[k] == 1 ? rows.weight[entry] : faces.area[k] * constants.faces.surface_weight((position[i] - faces.position[k]).norm());
  };
  std::vector<double>& share = sums.reaction_share;  // f_k, then s_k / f_k
  share.assign(2 * faces.size(), 0);
  const std::span<double> seen = std::span(share).subspan(faces.size());  // of f_k, by particles that see the face where it is wet
  for (const int i : at_structure)
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
      const int k = rows.face[entry];
      share[k] += 2 * constants.volume * whole(i, entry) / faces.area[k];
      seen[k] += 2 * constants.volume * rows.weight[entry] / faces.area[k];
    }
  for (const auto& of_thread : sums.back_facing)
    for (const BackFacing& back : of_thread) share[back.face] += 2 * constants.volume * back.weight / faces.area[back.face];
  const double support = constants.faces.support();
  for (std::size_t m = 0; m < particles.image_of.size(); ++m) {
    const int i = at_structure[particles.image_of[m]];
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
      const int k = rows.face[entry];
      const Vector<D> offset = particles.image_position[m] - faces.position[k];
      const double distance = offset.norm();
      if (offset.dot(faces.normal[k]) > 0 && distance < support)
        share[k] += 2 * constants.volume * constants.faces.surface_weight(distance);
    }
  }
  ranks.sum(std::span(share));
  if (at_structure.empty()) return;
  sums.swept_share.resize(faces.size());
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const double filled = sums.borne_share[k] * share[k], wet = wet_share(filled);
    share[k] = wet > 0 ? sums.borne_share[k] * wet / filled : 0;
    sums.swept_share[k] = wet > 0 && seen[k] > least_seen ? 1 / seen[k] : 0;
  }

  sums.reaction.resize(rows.begin.size());
  sums.carried_weight.resize(rows.begin.size());
  const auto add = [&](int i, int k, double weight) {
    const Vector<D> from_particle = faces.position[k] - position[i];
    sums.reaction[i] -= share[k] * weight * faces.normal[k];
    sums.carried_weight[i] -= (2 * constants.density * gravity[i].dot(from_particle) * share[k] * weight) * faces.normal[k];
    sums.linear_moment[i] -= (2 * (share[k] - sums.borne_share[k] * rows.wet[k]) * weight) * faces.normal[k] * from_particle.transpose();
  };
  for (const int i : at_structure) {
    sums.reaction[i].setZero();
    sums.carried_weight[i].setZero();
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) add(i, rows.face[entry], whole(i, entry));
  }
  for (const auto& of_thread : sums.back_facing)
    for (const BackFacing& back : of_thread) add(back.particle, back.face, back.weight);
}

template <int D>
void add_interface_reaction(const Constants<D>& constants, double duration, const Boundary<D>& boundary, const State<D>& state,
                            const std::vector<int>& at_structure, std::vector<Vector<D>>& velocity) {
  const BoundarySums<D>& sums = boundary.sums;
  for (const int i : at_structure)
    velocity[i] -= duration / constants.density * (2 * state.pressure[i] * sums.reaction[i] + sums.carried_weight[i]);
}

template <int D>
void balance_weight(const Constants<D>& constants, const Neighbours<D>& neighbours, const Corrections<D>& correction,
                    const std::vector<ParticleClass>& particle_class, const std::vector<Vector<D>>& gravity,
                    const std::vector<int>& at_structure, Boundary<D>& boundary) {
  BoundarySums<D>& sums = boundary.sums;
  for (const int i : at_structure) {
    if (!particle_class[i].inside()) continue;
    Matrix<D> moment = neighbours.moment[i] + sums.moment[i] + sums.linear_moment[i];
    if (!particle_class[i].has(ParticleClass::corrected_gradient))  // what T takes of the gradient: as in apply_pressure_gradient()
      moment -= sums.tangential[i] * (Matrix<D>::Identity() - correction.fluid[i] * neighbours.moment[i]);
    sums.mirrored_hydrostatic[i] += constants.density * (gravity[i] - moment * gravity[i]);
  }
}

#define TERN_INSTANTIATE(D)                                                                                                                \
  template void find_interface_reaction<D>(const Constants<D>&, const Ranks&, const InterfaceParticles<D>&, const std::vector<Vector<D>>&, \
                                           const std::vector<Vector<D>>&, const std::vector<int>&, Boundary<D>&);                          \
  template void add_interface_reaction<D>(const Constants<D>&, double, const Boundary<D>&, const State<D>&, const std::vector<int>&,       \
                                          std::vector<Vector<D>>&);                                                                        \
  template void balance_weight<D>(const Constants<D>&, const Neighbours<D>&, const Corrections<D>&, const std::vector<ParticleClass>&,     \
                                  const std::vector<Vector<D>>&, const std::vector<int>&, Boundary<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
