// Damping of velocity noise on the scale of the particles. Nothing else in an inviscid projection method takes energy out
// of it: noise fed by irregular particle positions would drive a slow circulation for ever. A pair exchanges momentum
// along its line in proportion to the part of its velocity difference that the linear fields around both do not explain:
//   L_i  = S_i C^F_i,  S_i = sum V_j (u_j - u_i) grad w_ij^T over fluid neighbours
//   a_ij = r_ij . (u_j - u_i - (L_i + L_j)/2 r_ij)
//   du_i = (chi dt / tau) sum_j V_j |w'|/r r_ij a_ij min(1, |a_ij| / b_ij),   b_ij = (g_i + g_j)/2 r^2 / 10
// tau is the time in which neighbours at the distance h pass each other (density_source.hpp), chi dt/tau the mean of both; g is
// the rate of strain. Affine velocity fields are left as they are. Of a wave of wave number k the part a is (k r)^2/4 of what the linear
// fields explain: where that is less than a tenth, the wave is resolved, and the last factor takes the less the better it is. Without it
// the wave would lose of order (chi/tau) (k h)^4 per unit of time, with it (k h)^6.
// Pairs are antisymmetric and central: both momenta are conserved.
// The reconstruction is that of MUSCL schemes and of the structure's Riemann diffusion.

#include "fluid/motion/velocity_noise.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "fluid/pressure/density_source.hpp"

namespace tern::fluid {
namespace {

constexpr Four largest_share = {0.5, 0.5, 0.5, 0.5};  ///< per step, for stability
constexpr double resolved = 0.1;  ///< share of a difference of velocities that a resolved motion may have beyond the linear fields
constexpr double half_resolved = 0.5 * resolved;

}  // namespace

template <int D>
void damp_velocity_noise(const Reference<D>& reference, double duration, const Neighbours<D>& neighbours,
                         const std::vector<ParticleClass>& particle_class, const PackedVelocities<D>& packed,
                         std::vector<Vector<D>>& velocity) {
  const Constants<D>& constants = reference.constants;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(neighbours.rows());
  const PassingRate passing_rate(reference, constants.kernel.smoothing_length() / constants.spacing);
  const double half_chi = 0.5 * constants.numerics.noise_damping * duration;
  const double by_gravity = half_chi * passing_rate.by_gravity, by_flow = half_chi * passing_rate.by_flow;
  reference.period.specialise([&](auto periodic) {
    const LanePeriod<decltype(periodic)::value, D> period(reference.period);
    parallel_for(n, [&](std::ptrdiff_t i) {
      if (!particle_class[i].has(ParticleClass::corrected_gradient)) return;
      std::array<double, D> x, u;
      for (int c = 0; c < D; ++c) x[c] = neighbours.position[c][i], u[c] = packed.velocity[c][i];
      std::array<double, D> own_stretch;
      std::array<double, D*(D - 1) / 2> own_shear;
      for (int a = 0; a < D; ++a) own_stretch[a] = packed.half_stretch[a][i];
      for (std::size_t place = 0; place < own_shear.size(); ++place) own_shear[place] = packed.shear[place][i];
      const double rate = half_resolved * packed.strain_rate[i], passing = std::max(by_gravity, by_flow * packed.gradient_size[i]);
      std::array<Four, D> change{};
      for_groups(
          neighbours, i, [&](int j, Four weight) __attribute__((always_inline)) {
            std::array<Four, D> r, jump;
            Four r2{}, part{};
            for (int c = 0; c < D; ++c) {
              r[c] = period.between(x[c], neighbours.position[c].data() + j, c);
              jump[c] = load(packed.velocity[c].data() + j) - u[c];
              r2 += r[c] * r[c];
            }
            // r . (L_i + L_j)/2 r has no part of what turns.
            for (int a = 0; a < D; ++a) jump[a] -= (own_stretch[a] + load(packed.half_stretch[a].data() + j)) * r[a];
            for_axis_pairs<D>([&](int a, int b, int place) __attribute__((always_inline)) {
              jump[a] -= (own_shear[place] + load(packed.shear[place].data() + j)) * r[b];
            });
            for (int c = 0; c < D; ++c) part += jump[c] * r[c];
            const Four size = magnitude(part), smooth = (rate + half_resolved * load(packed.strain_rate.data() + j)) * r2 + 1e-300;
            const Four of_other = larger(by_flow * load(packed.gradient_size.data() + j), Four{} + by_gravity);
            const Four share = smaller(passing + of_other, largest_share);
            const Four exchange = weight * share * part * (size / larger(smooth, size));
            for (int c = 0; c < D; ++c) change[c] += exchange * r[c];
          });
      for (int c = 0; c < D; ++c) velocity[i][c] += sum(change[c]);
    });
  });
}

template void damp_velocity_noise<2>(const Reference<2>&, double, const Neighbours<2>&, const std::vector<ParticleClass>&,
                                     const PackedVelocities<2>&, std::vector<Vector<2>>&);
template void damp_velocity_noise<3>(const Reference<3>&, double, const Neighbours<3>&, const std::vector<ParticleClass>&,
                                     const PackedVelocities<3>&, std::vector<Vector<3>>&);

}  // namespace tern::fluid
