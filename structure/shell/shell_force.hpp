#pragma once
// Energy of a layer (Kirchhoff-Love: material lines across stay normal) and the forces that are its exact gradient.
//
// 3D: n = x_,1 x x_,2 / |x_,1 x x_,2|, capital letters the same sums of the reference,
//   E_ab = (x_,a.x_,b - X_,a.X_,b)/2,   rho_ab = n.x_,ab - N.X_,ab,   G_abc = sym_ab(x_,ac.x_,b) - reference,
//   W = t Psi(E) + t^3/24 C(rho, rho) + sum_c c_c t/2 C(G_..c, G_..c),   C(A, A) = E' [(1 - nu) A:A + nu (tr A)^2],   E' = E/(1 - nu^2).
// Psi is the material's energy in plane stress; bending follows Hooke's law. The last term is the energy of the change of strain in
// a cell of length sqrt(12 c), c = min(spacing, t)^2/12: without it a zigzag costs nothing, with the spacing alone a curved layer locks.
// 2D, as complex numbers a = x', b = x'':  z = b/a - its reference = (ln |a|)' + i phi',
//   W = t Psi(|a|) + E' t/2 [c (Re z)^2 + t^2/12 (Im z)^2].
// Total energy: sum_i A_i W_i. A particle on a clamped edge has no cell term, and rho = (R N).x_,ab - N.X_,ab.

#include <span>

#include "structure/shell/shell_layer.hpp"

namespace tern::structure {

/// x_,a and x_,ab of every particle. `turn`: R of each clamp. With velocities and dR/dt in their places: the rates of these.
template <int D>
void shell_derivatives_of(const ShellLayer<D>& layer, std::span<const Vector<D>> x, std::span<const Matrix<D>> turn,
                          std::span<ShellDerivatives<D>> derivatives);

/// What the energy of particle i compares with. Its reference has to be there.
ShellRest shell_rest(const ShellLayer<3>& layer, std::size_t i);

/// W [J/m^(D-1)] of particle i and, in `conjugate`, dW/dx_,a and dW/dx_,ab.
template <int D>
double shell_energy_density(const ShellLayer<D>& layer, std::size_t i, const ShellDerivatives<D>& derivatives,
                            std::span<const Matrix<D>> turn, ShellDerivatives<D>& conjugate);

/// The same of the viscous energy, half the power that it takes, W with the rates of E (rho, G) in place of their changes, Hooke's law, and
/// `viscous_time` [s] before it. `rate`: of the derivatives [1/s], `turn_rate`: dR/dt. Rigid motions have no such rates.
template <int D>
void shell_viscous_stress(const ShellLayer<D>& layer, std::size_t i, const ShellDerivatives<D>& derivatives,
                          const ShellDerivatives<D>& rate, std::span<const Matrix<D>> turn, std::span<const Matrix<D>> turn_rate,
                          double viscous_time, ShellDerivatives<D>& conjugate);

/// Power per area [W/m^2] with which the turning of its clamp does work on particle i, whose stresses are `conjugate`.
template <int D>
double shell_turning_power(const ShellLayer<D>& layer, std::size_t i, const ShellDerivatives<D>& derivatives,
                           const ShellDerivatives<D>& conjugate, std::span<const Matrix<D>> turn, std::span<const Matrix<D>> turn_rate);

/// f_i = -dU/dx_i [N/m^(3-D)] from dW_j of all particles j; of several W at once.
template <int D, std::size_t N>
std::array<Vector<D>, N> shell_force(const ShellLayer<D>& layer, std::size_t i,
                                     const std::array<std::span<const ShellDerivatives<D>>, N>& conjugate);

/// All of it: U [J/m^(3-D)], and the forces. `derivatives` and `conjugate` are work space of the size of the layer.
template <int D>
double shell_forces(const ShellLayer<D>& layer, std::span<const Vector<D>> x, std::span<const Matrix<D>> turn,
                    std::span<ShellDerivatives<D>> derivatives, std::span<ShellDerivatives<D>> conjugate, std::span<Vector<D>> force);

}  // namespace tern::structure
