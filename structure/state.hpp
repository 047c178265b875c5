#pragma once
// What changes. State is the motion, which a repeated window begins from again; what the integrators learn from window to window
// stands beside it (complete_state.hpp). Workspace is rebuilt from them.

#include <array>
#include <vector>

#include "base/time.hpp"
#include "proto/interface.hpp"
#include "structure/reference.hpp"
#include "structure/structure.hpp"

namespace tern::structure {

template <int D>
using RowVectors = std::array<std::vector<double>, D>;  ///< one array of rows per component

template <int D>
struct State {
  Ticks time = 0;
  RowVectors<D> displacement;       ///< x - X [m]
  RowVectors<D> velocity;           ///< [m/s]
  std::vector<double> clamp_angle;  ///< by which each of Reference::clamps is turned [rad]
  std::vector<double> clamp_spin;   ///< and turns, from the last time it was aimed [rad/s]
  RowVectors<D> internal_force;     ///< elastic + diffusion at `displacement` [N/m^(3-D)]
  RowVectors<D> external_force;     ///< all that acts from outside, constant over a window: of the last one [N/m^(3-D)]
  bool force_is_elastic = false;    ///< internal_force is the elastic part alone
  bool undisturbed = true;          ///< as it was built: nothing has moved or loaded it yet
  SurfaceLoad<D> load;              ///< of the last window
  double interface_work = 0;        ///< [J/m^(3-D)] since t = 0
  double gravity_work = 0;
  double load_work = 0;                ///< of tractions, pressures and body loads
  double clamp_work = 0;               ///< of clamps that move
  std::vector<Lanes> diffusion_loss;   ///< per block: energy dissipated by the diffusion in its pairs
  std::vector<Lanes> diffusion_power;  ///< what it dissipates at the present velocity
  std::vector<Lanes> diffusion_brake;  ///< and by how much less with every second that the present forces act
  std::vector<Lanes> damping_loss;     ///< per block: energy dissipated by the mass damping; empty without

  /// The list of the members: visit(name, member of each state) for every one.
  template <class Visit, class... States>
  static void for_each_field(Visit&& visit, States&... state) {
    visit("time", state.time...);
    visit("displacement", state.displacement...);
    visit("velocity", state.velocity...);
    visit("clamp_angle", state.clamp_angle...);
    visit("clamp_spin", state.clamp_spin...);
    visit("internal_force", state.internal_force...);
    visit("external_force", state.external_force...);
    visit("force_is_elastic", state.force_is_elastic...);
    visit("undisturbed", state.undisturbed...);
    visit("load", state.load.force...);
    visit("interface_work", state.interface_work...);
    visit("gravity_work", state.gravity_work...);
    visit("load_work", state.load_work...);
    visit("clamp_work", state.clamp_work...);
    visit("diffusion_loss", state.diffusion_loss...);
    visit("diffusion_power", state.diffusion_power...);
    visit("diffusion_brake", state.diffusion_brake...);
    visit("damping_loss", state.damping_loss...);
  }
};

template <int D>
using RowMatrices = std::array<std::array<std::vector<double>, D>, D>;  ///< [component][direction]

/// Second derivatives: [component][pair of directions, see curvature_index].
template <int D>
using RowCurvatures = std::array<std::array<std::vector<double>, curvature_components<D>>, D>;

/// Of a shell, particle by particle.
template <int D>
struct ShellWork {
  std::vector<Vector<D>> x;                      ///< [m]
  std::vector<ShellDerivatives<D>> derivatives;  ///< of `x`
  std::vector<ShellDerivatives<D>> conjugate;    ///< of the last evaluation of the forces
  std::vector<double> energy_density;            ///< [J/m^(D-1)]
  std::vector<Vector<D>> v;                      ///< [m/s]
  std::vector<ShellDerivatives<D>> rate;         ///< of the derivatives
  std::vector<Matrix<D>> turn;                   ///< R of each of Reference::clamps, and of those without a name
  std::vector<Matrix<D>> turn_rate;              ///< dR/dt [1/s]
  std::vector<ShellDerivatives<D>> viscous;      ///< what is conjugate to them in the viscous stress
};

template <int D>
struct Workspace {
  RowMatrices<D> displacement_gradient;  ///< H = F - I
  RowCurvatures<D> curvature;            ///< K = d2u/dX dX [1/m]
  RowMatrices<D> fitted_gradient;        ///< H of the fit where some particles' is completed (unseen_fields.hpp), else empty
  RowCurvatures<D> fitted_curvature;     ///< K of the fit of those particles
  RowCurvatures<D> double_stress;        ///< Q = dW/dK, W the energy density of a particle's cell [N/m]
  RowMatrices<D> velocity_gradient;      ///< dv/dx [1/s], for the reconstruction in the diffusion
  RowMatrices<D> diffusion_stress;       ///< what the diffusion adds to P for its reconstruction [Pa]
  RowMatrices<D> stress;                 ///< first Piola-Kirchhoff P [Pa]
  RowVectors<D> drag;                    ///< force of the diffusion on the first row of each pair: array of rows per pair slot
  std::vector<ShellWork<D>> shells;
  Evaluations evaluations;
};

template <int D>
State<D> state_at_rest(const Reference<D>& reference, std::size_t surface_points) {
  State<D> state;
  for (auto* vectors : {&state.displacement, &state.velocity, &state.internal_force, &state.external_force})
    for (auto& axis : *vectors) axis.assign(reference.rows, 0);
  state.clamp_angle.assign(reference.clamps.size(), 0);
  state.clamp_spin.assign(reference.clamps.size(), 0);
  state.load.force.assign(surface_points, Vector<D>::Zero());
  for (auto* values : {&state.diffusion_loss, &state.diffusion_power, &state.diffusion_brake})
    values->assign(reference.blocks.size(), broadcast(0));
  if (reference.has_damping) state.damping_loss.assign(reference.blocks.size(), broadcast(0));
  return state;
}

template <int D>
Workspace<D> workspace_for(const Reference<D>& reference) {
  Workspace<D> work;
  for (auto* matrices : {&work.displacement_gradient, &work.velocity_gradient, &work.diffusion_stress, &work.stress})
    for (auto& component : *matrices)
      for (auto& direction : component) direction.assign(reference.rows, 0);
  for (auto* curvatures : {&work.curvature, &work.double_stress})
    for (auto& component : *curvatures)
      for (auto& pair : component) pair.assign(reference.rows, 0);
  if (!reference.unseen.empty()) {
    for (auto& component : work.fitted_gradient)
      for (auto& direction : component) direction.assign(reference.rows, 0);
    for (auto& component : work.fitted_curvature)
      for (auto& pair : component) pair.assign(reference.rows, 0);
  }
  if (reference.has_diffusion)
    for (auto& axis : work.drag) axis.assign(reference.rows * reference.pair_slots, 0);
  for (const ShellBody<D>& shell : reference.shells) {
    ShellWork<D>& own = work.shells.emplace_back();
    own.x.resize(shell.layer.size());
    own.derivatives.resize(shell.layer.size());
    own.conjugate.resize(shell.layer.size());
    own.energy_density.resize(shell.layer.size());
    own.v.resize(shell.layer.size());
    own.rate.resize(shell.layer.size());
    own.viscous.resize(shell.layer.size());
    own.turn.assign(reference.clamps.size() + 1, Matrix<D>::Identity());
    own.turn_rate.assign(reference.clamps.size() + 1, Matrix<D>::Zero());
  }
  return work;
}

}  // namespace tern::structure
