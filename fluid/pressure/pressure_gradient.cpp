// Acceleration by the pressure gradient, a_i = -G_i / rho. With B_i = sum_F V_j (p_j - p_i) grad w_ij:
//   blended:    G = C_i (B_i + H_i) + 2 p^_i E_i,   p^_i = min(theta (p_i - least p of the neighbours), rho h^2 / (5.4 dt^2))
//   symmetric:  G = B_i + H_i + T_i C^F_i B_i + 2 p_i sum V grad w                  = sum V_j (p_j + p_i) grad w_ij
//   beside the structure: the symmetric form - 2 p_i R_i + 2 p^_i (E_i without its part along the interface's reaction)
// E_i is sum V grad w over fluid and faces, R_i what a uniform pressure of 1/2 does to the particle, with the interface's reaction.
// A wall mirrors the pressure: along its normal p_w = p_i + rho (g - a_w) . (r_w - r_i), which gives H_i, along its face
// with the fluid's own gradient, which C_i finds (blended form) or T_i completes (symmetric form). The symmetric form conserves momentum
// pair by pair and is used at the free surface; the blended form is exact for linear fields but for its last term,
// which keeps particles in order, and used inside. There the level of the pressure means nothing, so that term does not know it. Beside
// the structure the interface has brought the level in, as the reaction to the load: it is taken out again.

#include "fluid/pressure/pressure_gradient.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"

namespace tern::fluid {
namespace {

/// The regularising part is a spring between particles. A displacement of wave number k from a lattice answers with
/// omega^2 = (2 theta p / rho) sum V (1 - cos(k . r)) w'', at most 2.7 times the first factor over h^2 (2D and 3D, h of 1.3 to 2 spacings).
/// It takes no more pressure than gives omega dt = 1: an explicit force is unstable from 2 on, and the pressure of an impact is that of
/// the step.
constexpr double stiffest = 2.7;

}  // namespace

template <int D>
void apply_pressure_gradient(const Reference<D>& reference, double duration, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                             const Corrections<D>& correction, const State<D>& state, const std::vector<int>* only,
                             std::vector<Vector<D>>& velocity, std::vector<Vector<D>>* order) {
  const Constants<D>& constants = reference.constants;
  const bool at_structure = only != nullptr;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(at_structure ? only->size() : state.size());
  const double theta = order ? constants.numerics.blend_theta : 0, scale = -duration / constants.density;
  // theta (p - least) of a force whose vibrations the window resolves
  const double most = constants.density / (2 * stiffest) * std::pow(constants.kernel.smoothing_length() / duration, 2);
  const double* pressure = state.pressure.data();
  reference.period.specialise([&](auto periodic) {
    const LanePeriod<decltype(periodic)::value, D> period(reference.period);
    const auto apply = [&](auto ordered) {
      parallel_for(n, [&](std::ptrdiff_t m) {
        const std::ptrdiff_t i = at_structure ? (*only)[m] : m;
        if (!state.particle_class[i].pressure_unknown() || boundary.sees_structure(i) != at_structure) return;
        std::array<double, D> x;
        for (int c = 0; c < D; ++c) x[c] = neighbours.position[c][i];
        const double p = pressure[i];
        Four lowest = p - Four{};
        std::array<Four, D> sums{};
        for_groups(
            neighbours, i, [&](int j, Four weight) __attribute__((always_inline)) {
              const Four other = load(pressure + j), weighted = weight * (other - p);
              if constexpr (decltype(ordered)::value) lowest = (weight > 0) & (other < lowest) ? other : lowest;
              for (int c = 0; c < D; ++c) sums[c] += weighted * period.between(x[c], neighbours.position[c].data() + j, c);
            });
        const double least = std::min({lowest[0], lowest[1], lowest[2], lowest[3]});
        Vector<D> difference;
        for (int c = 0; c < D; ++c) difference[c] = sum(sums[c]);
        const Vector<D> kernel_gradient =
            neighbours.kernel_gradient[i] + boundary.sums.wall_gradient[i] + boundary.sums.unborne_gradient[i];
        if (boundary.sees_face(i)) {
          if (state.particle_class[i].has(ParticleClass::symmetric_gradient))
            difference += boundary.sums.tangential[i] * (correction.fluid[i] * difference);
          difference += boundary.sums.mirrored_hydrostatic[i];
        }
        Vector<D> gradient;
        const double in_order = std::min(theta * (p - least), most);  // p^
        const bool symmetric = state.particle_class[i].has(ParticleClass::symmetric_gradient);
        const bool level = symmetric && feels_level(constants, state.particle_class[i], at_structure);
        if (symmetric) {
          gradient = difference;
          if (level)
            gradient += 2 * p * kernel_gradient;
          else if (at_structure)
            gradient -= 2 * p * boundary.sums.reaction[i];
        } else {
          gradient = correction.matrix[i] * difference;
        }
        if constexpr (decltype(ordered)::value) {
          if (!level) {
            Vector<D> gap = neighbours.kernel_gradient[i] + boundary.sums.wall_gradient[i];
            if (!boundary.sums.surface_gradient.empty()) gap += boundary.sums.surface_gradient[i];
            gap += boundary.sums.back_facing_gradient[i];
            if (at_structure) {
              const Vector<D>& reaction = boundary.sums.reaction[i];
              if (const double squared = reaction.squaredNorm(); squared > 0) gap -= gap.dot(reaction) / squared * reaction;
            }
            (*order)[i] += scale * 2 * in_order * gap;
          }
        }
        velocity[i] += scale * gradient;
      });
    };
    if (theta > 0)
      apply(std::true_type{});
    else
      apply(std::false_type{});
  });
}

template void apply_pressure_gradient<2>(const Reference<2>&, double, const Neighbours<2>&, const Boundary<2>&, const Corrections<2>&,
                                         const State<2>&, const std::vector<int>*, std::vector<Vector<2>>&, std::vector<Vector<2>>*);
template void apply_pressure_gradient<3>(const Reference<3>&, double, const Neighbours<3>&, const Boundary<3>&, const Corrections<3>&,
                                         const State<3>&, const std::vector<int>*, std::vector<Vector<3>>&, std::vector<Vector<3>>*);

}  // namespace tern::fluid
