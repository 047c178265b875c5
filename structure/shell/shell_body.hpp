#pragma once
// The shells among the bodies: their rows of particles, and their share of forces, energies and fields.

#include "structure/state.hpp"

namespace tern::structure {

/// The derivatives of every shell from the displacement.
template <int D>
void shell_derivatives(const Reference<D>& reference, const State<D>& state, Workspace<D>& work);

/// Sets state.internal_force of the rows of shells. Throws NumericalFailure when a mid-surface has been torn or has collapsed.
template <int D>
void shell_internal_forces(const Reference<D>& reference, double time_s, State<D>& state, Workspace<D>& work);

/// The same of the elastic forces alone, without viscosity; false when a mid-surface has been torn or has collapsed.
template <int D>
bool shell_elastic_forces(const Reference<D>& reference, State<D>& state, Workspace<D>& work);

/// Power of the clamps that turn, of their couple alone [W/m^(3-D)], by the stresses of the last shell_internal_forces().
template <int D>
double shell_clamp_power(const Reference<D>& reference, const Workspace<D>& work);

/// Sets the viscosity of the shells: `coefficient` times 0.1 of the critical damping of the fastest motion; of every other one the
/// share falls with its frequency. Their stable_step_at_rest is that without, and becomes that with it.
template <int D>
void damp_shells(Reference<D>& reference, double coefficient);

/// Largest stable sub-step of the shells [s]; see scene/mid_surface.hpp, at the largest and smallest stretch of the mid-surface. Throws
/// NumericalFailure when one is curved so much that the fibres inside turn over.
template <int D>
double shell_stable_sub_step(const Reference<D>& reference, double courant, const State<D>& state, const Workspace<D>& work);

/// Strain energy of the shells [J/m^(3-D)].
template <int D>
double shell_strain_energy(const Reference<D>& reference, const Workspace<D>& work);

/// Moment with which the edges on clamp `clamp` (or all, if -1) turn the shell by its elastic stress, without that of the forces; 2D: the
/// last entry [N m/m^(3-D)].
template <int D>
Vector<3> shell_clamp_couple(const ShellBody<D>& shell, const Workspace<D>& work, std::int32_t clamp);

/// Stress and energy at one particle: Cauchy stress at mid-surface, the larger von Mises stress of both faces, by Hooke's law.
template <int D>
struct ShellStress {
  Matrix<D> cauchy;
  double von_mises, area_ratio, energy_density;
};
template <int D>
ShellStress<D> shell_stress(const ShellBody<D>& shell, const Workspace<D>& work, std::size_t particle);

}  // namespace tern::structure
