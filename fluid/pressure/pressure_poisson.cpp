// Pressure Poisson equation (seed paper eq. 2 with the sign a projection needs), rows scaled by V_i:
//   sum_j a_ij (p_i - p_j) + c_i p_i + sum_j R_ij p_j = -(rho/dt) V_i (div_i(u*) - q_i) + what R has on this side
//   a_ij  = V_i V_j K_ij,  K = 2 |w'|/r                        (Cummins & Rudman 1999)
//   c_i   = V_i f_i K_full + sum_spray a_ij
// Free surface: the missing part f_i = 1 - tr M_i / D of a support acts as neighbours at p = 0. Unlike p = 0 on marked
// particles this never switches a particle between two kinds of row, and the matrix keeps one size. Fluid that fills its
// enclosure has no surface (enclosed_regions.hpp).
// Enclosed fluid beside a deformable body: the sum of the rows is the volume that the faces sweep (enclosed_regions.hpp).
// What this operator leaves of the divergence, because it is not the divergence of the pressure gradient: left_behind.hpp.
// Walls and structure are no unknowns: their flux is in div(u*). The structure yields to an increment of pressure: R, of which the matrix
// has the diagonal bound kappa_i in c_i (yielding_surface.hpp).

#include "fluid/pressure/pressure_poisson.hpp"

#include "base/parallel.hpp"
#include "fluid/pressure/divergence_target.hpp"
#include "fluid/pressure/level_ties.hpp"

namespace tern::fluid {
namespace {

constexpr double least_deficit = 0.08;       ///< of tr M / D: less is disorder, not a surface
constexpr double deficit_of_surface = 0.38;  ///< of a particle at a flat surface

/// Part of a particle's kernel, where it is more than disorder.
template <int D>
double missing_support(const State<D>& state, const Corrections<D>& correction, std::ptrdiff_t i) {
  const double deficit = state.particle_class[i].has(ParticleClass::enclosed) ? 0 : 1 - correction.trace[i];
  return deficit > least_deficit ? deficit : 0;
}

/// `yields`: kappa_i.
template <int D>
void assemble_row(const Constants<D>& constants, double yields, const State<D>& state, const Neighbours<D>& neighbours,
                  const Corrections<D>& correction, int i, EdgeMatrix& matrix) {
  if (!state.particle_class[i].pressure_unknown()) {
    matrix.set_fixed(i);
    return;
  }
  const double volume = constants.volume;
  const double full = constants.lattice.laplacian_weight / constants.lattice.gradient_moment;
  const double constant = volume * missing_support(state, correction, i) * full + yields;
  double to_spray = 0;
  if (state.particle_class[i].has(ParticleClass::beside_spray))
    neighbours.for_each(i, [&](int j, float weight) {
      if (!state.particle_class[j].pressure_unknown()) to_spray += 2 * volume * weight;
    });
  matrix.set_row(i, constant, to_spray);
}

}  // namespace

template <int D>
void find_enclosed_fluid(const Domain<D>& domain, const Neighbours<D>& neighbours, const Corrections<D>& correction, State<D>& state,
                         PressureSystem<D>& system) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state.size());
  system.at_surface.resize(n);
  parallel_for(n, [&](std::ptrdiff_t i) {
    const ParticleClass own = state.particle_class[i];
    system.at_surface[i] =
        own.has(ParticleClass::beside_spray) || (!state.fills_enclosure && 1 - correction.trace[i] >= 0.5 * deficit_of_surface);
  });
  if (!domain.alone()) {
    find_enclosed_regions_of_ranks(domain, neighbours, state.particle_class, state.id, system.at_surface, system.enclosed);
  } else {
    find_enclosed_regions<D>(neighbours, state.particle_class, system.at_surface, system.enclosed);
  }
  if (!system.enclosed.any()) return;
  for (std::ptrdiff_t i = 0; i < n; ++i) state.particle_class[i].set(ParticleClass::enclosed, system.enclosed.region[i] >= 0);
}

template <int D>
void assemble_pressure_matrix(const Constants<D>& constants, const State<D>& state, const Neighbours<D>& neighbours,
                              const Boundary<D>& boundary, const Corrections<D>& correction, EdgeMatrix& matrix) {
  const int n = static_cast<int>(state.size());
  matrix.reset(neighbours, 2 * constants.volume);
  parallel_for(n, [&](int i) {
    if (!boundary.sees_structure(i)) assemble_row(constants, 0, state, neighbours, correction, i, matrix);
  });
}

template <int D>
void complete_pressure_matrix(const Constants<D>& constants, const Ranks& ranks, const InterfaceCondition<D>& load,
                              const Neighbours<D>& neighbours, const Boundary<D>& boundary, const Corrections<D>& correction,
                              const Prediction<D>& prediction, const std::vector<int>& at_structure, const State<D>& state,
                              PressureSystem<D>& system) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(at_structure.size());
  system.yielding.assemble(constants, ranks, load.response, boundary, state.particle_class, prediction, at_structure);
  const LevelTies ties = find_level_ties(system.yielding, at_structure, system.enclosed);
  select_regions(system.enclosed, ties.beside_bodies, system.beside_bodies);
  select_regions(system.enclosed, ties.sealed, system.sealed);
  parallel_for(n, [&](std::ptrdiff_t m) {
    assemble_row(constants, system.yielding.bound(m), state, neighbours, correction, at_structure[m], system.matrix);
  });
}

template <int D>
void assemble_pressure_source(const Constants<D>& constants, double duration, const InterfaceCondition<D>& load, const State<D>& state,
                              const Prediction<D>& prediction, const Boundary<D>& boundary, const std::vector<int>& at_structure,
                              const std::vector<double>& divergence, const std::vector<double>& target, PressureSystem<D>& system) {
  const int n = static_cast<int>(state.size());
  const double density = constants.density, scale = -density / duration * constants.volume;
  system.source.assign(system.matrix.rows(), 0);
  parallel_for(n, [&](int i) {
    if (!state.particle_class[i].pressure_unknown()) return;
    double b = scale * (divergence[i] - target[i]);
    // Past a corner the pressure behind the face goes on along the face as before it, by the weight of the fluid.
    b += 2 * density * constants.volume * prediction.gravity[i].dot(boundary.sums.back_facing_gradient[i]);
    if (boundary.walls.moving() && boundary.walls.may_have_corners())
      b += 2 * density * constants.volume * boundary.sums.back_facing_acceleration[i];
    system.source[i] = b;
  });
  if (system.beside_bodies.any()) {
    const bool first = load.surface_velocity.empty();
    SweptVolume<D>& swept = system.swept;
    swept.find(constants, duration, load, boundary, system.beside_bodies, state);
    std::vector<double>&wanted = system.swept_wanted, &left = system.swept_left;
    wanted.resize(swept.rate.size());
    left.resize(swept.rate.size());
    for (std::size_t r = 0; r < wanted.size(); ++r) {
      if (first) left[r] = swept.rate[r] - swept.taken_away(r, duration);
      wanted[r] = (swept.rate[r] - left[r]) / swept.answer(r);
      if (first) swept.past.taken_away[r] = wanted[r];
    }
    system.beside_bodies.set_sums(wanted, density / duration, system.source);
  }
  system.yielding.add_source(load.reference_pressure, boundary, at_structure, system.source);
}

#define TERN_INSTANTIATE(D)                                                                                                                \
  template void find_enclosed_fluid<D>(const Domain<D>&, const Neighbours<D>&, const Corrections<D>&, State<D>&, PressureSystem<D>&);      \
  template void assemble_pressure_matrix<D>(const Constants<D>&, const State<D>&, const Neighbours<D>&, const Boundary<D>&,                \
                                            const Corrections<D>&, EdgeMatrix&);                                                           \
  template void complete_pressure_matrix<D>(const Constants<D>&, const Ranks&, const InterfaceCondition<D>&, const Neighbours<D>&,         \
                                            const Boundary<D>&, const Corrections<D>&, const Prediction<D>&, const std::vector<int>&,      \
                                            const State<D>&, PressureSystem<D>&);                                                          \
  template void assemble_pressure_source<D>(const Constants<D>&, double, const InterfaceCondition<D>&, const State<D>&,                    \
                                            const Prediction<D>&, const Boundary<D>&, const std::vector<int>&, const std::vector<double>&, \
                                            const std::vector<double>&, PressureSystem<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
