#pragma once
// Solution of the pressure Poisson equation: conjugate gradients with a multigrid cycle, or, should that fail, with the diagonal.

#include "fluid/domain.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/pressure/pressure_system.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"

namespace tern::fluid {

/// What the solve needs of the matrix alone: the multigrid and the enclosed regions. Begins the count of iterations.
template <int D>
void prepare_pressure_solve(const Constants<D>& constants, const Domain<D>& domain, const Neighbours<D>& neighbours,
                            const std::vector<ParticleClass>& particle_class, const std::vector<Vector<D>>& position,
                            const std::vector<int>& at_structure, PressureSystem<D>& system);

/// state.pressure, with its ghosts, starting from that before. Throws NumericalFailure when it does not converge. `position`: of the
/// particles, for the message. `any_at_structure`: of all ranks.
template <int D>
void solve_pressure_poisson(const Constants<D>& constants, const Domain<D>& domain, const Window& window,
                            const std::vector<Vector<D>>& position, const std::vector<int>& at_structure, bool any_at_structure,
                            State<D>& state, PressureSystem<D>& system);

/// system.correction: what the matrix answers to system.left_behind, roughly or, where any particle of any rank is at the structure,
/// closely. Leaves system.result as the solve before made it.
template <int D>
void solve_for_correction(const Constants<D>& constants, const Domain<D>& domain, const Window& window,
                          const std::vector<Vector<D>>& position, const std::vector<int>& at_structure, bool any_at_structure,
                          State<D>& state, PressureSystem<D>& system);

}  // namespace tern::fluid
