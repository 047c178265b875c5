#pragma once
// The equations of motion of the structure, one function per equation, each in the file named after it.
// All loop over blocks of four rows and only gather: the bits do not depend on the number of threads.

#include "base/vector.hpp"
#include "structure/state.hpp"

namespace tern::structure {

/// H_i = sum_j V_j (d_j - d_i) x g_ij, its derivatives K_i and, when `work` is used by the diffusion, l_i from the velocities.
template <int D>
void deformation_gradient(const Reference<D>& reference, const State<D>& state, Workspace<D>& work);

/// The same without l_i.
template <int D>
void displacement_gradients(const Reference<D>& reference, const State<D>& state, Workspace<D>& work);

/// P and Q of every row. Throws NumericalFailure when J <= 0 or not finite, naming particle and `time_s`.
template <int D>
void first_piola_kirchhoff(const Reference<D>& reference, const State<D>& state, double time_s, Workspace<D>& work);

/// The same without a message: false when some J is not positive or not finite; the stress of its block is then not touched.
template <int D>
bool stresses(const Reference<D>& reference, Workspace<D>& work);

/// Riemann diffusion of every row into state.internal_force, and its power, which kick() counts, into the accounts of `state`.
template <int D>
void diffusion_force(const Reference<D>& reference, State<D>& state, Workspace<D>& work);

/// Adds the elastic force of every row to state.internal_force, which holds that of the diffusion.
template <int D>
void elastic_force(const Reference<D>& reference, const Workspace<D>& work, State<D>& state);

/// The elastic force alone into state.internal_force, from the displacement on; false when some J is not positive.
template <int D>
bool evaluate_elastic_force(const Reference<D>& reference, State<D>& state, Workspace<D>& work);

/// state.internal_force of the present displacement and velocity, at `time_s`: all of the above in their order.
template <int D>
void internal_forces(const Reference<D>& reference, double time_s, State<D>& state, Workspace<D>& work);

/// v += dt (f_internal + f_external) / m, after the mass damping; unchanged where clamped. Counts what the diffusion takes.
template <int D>
void kick(const Reference<D>& reference, double dt, State<D>& state);

/// Gives moving clamps the velocity and the spin that bring them to their place at the time `end` within `dt` [s].
template <int D>
void aim_clamps(const Reference<D>& reference, double end, double dt, State<D>& state);

/// d += dt v; clamps turn by dt state.clamp_spin.
template <int D>
void drift(const Reference<D>& reference, double dt, State<D>& state);

/// Power of the clamps that move, sum of their reaction times their velocity, of shells also of their couple times their spin
/// [W/m^(3-D)]; `work` holds the stresses of the last internal_forces().
template <int D>
double clamp_power(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work);

/// Largest stable sub-step [s]: courant dx/(c + |v|max), c the pressure wave speed at the strongest compression, and no more than the
/// forces at rest allow. `work` holds the deformation gradient of `state`.
template <int D>
double stable_sub_step(const Reference<D>& reference, double courant, const State<D>& state, const Workspace<D>& work);

/// Throws NumericalFailure when neighbours have passed through each other; `work` as above.
template <int D>
void check_bond_order(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work);

/// Advances displacement and velocity by `duration` [s], from the time `begin` [s], in `sub_steps` equal steps of velocity Verlet under
/// state.external_force; the time in `state` stays.
template <int D>
void verlet(const Reference<D>& reference, double begin, double duration, int sub_steps, State<D>& state, Workspace<D>& work);

template <int D>
class ImplicitStep;

/// Advances the state by `duration` under state.external_force: in `sub_steps` explicit steps, or, with `implicit`, in
/// one implicit step. One that does not converge is halved until it stands for least_implicit_ratio explicit steps, and at last replaced
/// by those.
template <int D>
void advance_window(const Reference<D>& reference, Ticks duration, int sub_steps, ImplicitStep<D>* implicit, State<D>& state,
                    Workspace<D>& work);
inline constexpr int least_implicit_ratio = 25;

/// F_i in the row, from the last deformation_gradient().
template <int D>
Matrix<D> deformation_gradient_of(const Workspace<D>& work, std::int32_t row) {
  Matrix<D> f = Matrix<D>::Identity();
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) f(a, b) += work.displacement_gradient[a][b][row];
  return f;
}

/// H of the fit of all rows.
template <int D>
const RowMatrices<D>& fitted_gradient(const Workspace<D>& work) {
  return work.fitted_gradient[0][0].empty() ? work.displacement_gradient : work.fitted_gradient;
}

}  // namespace tern::structure
