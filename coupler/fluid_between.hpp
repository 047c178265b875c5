#pragma once
// The fluid between the faces and the particles that load them. A particle i stands before the faces that it sees at the mean distance
//   h_i = sum_k B_ik h_ik / sum_k B_ik,      h_ik = (x_i - x_k) . n_k,   B_ik = -b_ik . n_k
// Where the fluid is accelerated, its pressure goes on to the face by its inertia as well as by its weight, and between particle and
// faces it has the acceleration of these, as the particle sees them:
//   q_ik = p_i + rho g . (x_k - x_i) + rho h_i a_i . n_k,      a_i = sum_k B_ik a_k n_k / sum_k B_ik
// Without the last term the particles next to the face are pushed too little. They lag behind it, and what they lag takes energy from
// the motion, to first order in the window.
//
// By this term the fluid between is a mass on the face, sum_i rho h_i sum_k B_ik n_k (sum_l B_il n_l . a_l) / sum_k B_ik: symmetric, and
// positive. It does not feel motions of the face that particles do not see. A mass on every point would, and the learnt response of a
// body, which is in lumps as wide as a particle or wider, knows nothing of their answer: a soft body ran away.
//
// a_k is the acceleration of which the fluid is told: that of the trial, and what the pressure adds to it. The face yields to a pressure
// together with the fluid between, which has the mass rho sum_i B_ik h_i. The fluid is told of three quarters of it: motions as short as
// four or five spacings, which gain most from window to window, feel half of it, and with a mass that is too large they would grow.
//
// No lump has more between it and the particles than half of the mass with which it answers. More is a small difference of large forces.
// Bodies so light that all their windows are repeated (Setup::is_light without Setup::learns) have nothing between.

#include "coupler/state.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

/// window.between but for its acceleration. Nothing is between where the pressure is not carried by its inertia: before light bodies
/// (above); in the first window of a run, because what the fluid did before is not known; with schemes that make another pressure of those
/// of the pairs.
template <int D>
void find_fluid_between(const Setup<D>& setup, const State<D>& state, Workspace<D>& window);

/// What carries the pressure of the trial: its acceleration is that from the velocity at the end of the last window to that of this
/// coupling iteration.
template <int D>
void carry_trial_by_inertia(const Setup<D>& setup, const State<D>& state, Workspace<D>& window);

/// between.answer, how the surface answers with the fluid between, and between.told, of which the fluid is told.
template <int D>
void answer_with_fluid_between(Workspace<D>& window);

/// Carries the pressures `carried` of all pairs, which have their weight already, to the faces by their inertia, with what the pressures
/// add to the acceleration of the trial.
template <int D>
void carry_by_inertia(const Setup<D>& setup, Workspace<D>& window, std::vector<double>& carried);

}  // namespace tern::coupler
