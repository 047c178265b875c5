#include "coupler/interface_condition.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tern::coupler {
namespace {

/// Of the half space before a point. At the end of the kernel, where w~ may be negative, particles and point feel nothing of each other.
constexpr double least_share = 1e-3;

/// Mass per area behind a point that a pressure moves within the window [kg/m^2].
template <int D>
double responding_mass(const Setup<D>& setup, double duration, double stretch, std::size_t k) {
  // Over a window a pressure accelerates the section behind the point. While an elastic wave is on its way through the section, the
  // face moves at the constant p/(rho c). The fluid takes the mean velocity for half of that at the end; for it the answer is that
  // of half the layer that the wave reaches. At least one particle moves. These masses are per area at the start; where the body has
  // been stretched since, less mass is behind the same area.
  const SurfaceProperties& of = setup.properties;
  return std::max(std::min(of.section_mass[k], 0.5 * of.impedance[k] * duration), of.least_mass[k]) / stretch;
}

/// How many times this mass the stiffness of the body adds to it, at most: m (1 + (omega dt/2)^2) answers a push that lasts a window, of
/// the fastest motion that the fluid can excite, the wave of two of its spacings. Waves are slower than c k, and bending waves of a section
/// of thickness T than c k T k/sqrt(12). In long windows stiffness holds all that is not the motion of the whole; in short ones nothing.
template <int D>
double held_by_stiffness(const Setup<D>& setup, double duration, std::size_t k) {
  const SurfaceProperties& of = setup.properties;
  const double density = setup.body_density[of.body[k]], wave_number = std::numbers::pi / setup.spacing;
  const double thickness = 2 * of.section_mass[k] / density;  // of two wet faces; more than it is with one
  const double frequency = of.impedance[k] / density * wave_number * std::min(1.0, thickness * wave_number / std::sqrt(12.0));
  return std::pow(0.5 * frequency * duration, 2);
}

}  // namespace

template <int D>
void find_answer(const Setup<D>& setup, const Surface<D>& surface, State<D>& state, Workspace<D>& window) {
  const std::size_t points = surface.position.size();
  if (state.start.area.empty()) state.start = {surface.position, surface.normal, surface.area};
  window.responding_mass.resize(points);
  for (std::size_t k = 0; k < points; ++k) {
    const double stretch = surface.area[k] / state.start.area[k];
    window.responding_mass[k] = responding_mass(setup, window.duration, stretch, k);
  }
  if (setup.learns) {
    state.response.prepare(setup, state.start);
    state.response.adjust_to(window.duration);
    window.answer = state.response.answer(setup, window.responding_mass, surface.area);
    for (double& mass : window.answer.mass) mass *= setup.robin_mass_factor;
    return;
  }
  window.answer = {lumps_of_points(points), {}, 1};
  for (std::size_t k = 0; k < points; ++k) {
    const double alone = setup.robin_mass_factor * window.responding_mass[k];
    const double mass = std::max(alone, std::min(setup.mass_of_held, alone * (1 + held_by_stiffness(setup, window.duration, k))));
    window.answer.mass.push_back(mass * surface.area[k]);
    window.answer.gain = std::max(window.answer.gain, mass / window.responding_mass[k]);
  }
}

template <int D>
void set_robin_condition(const Setup<D>& setup, Workspace<D>& window) {
  const Surface<D>& surface = window.surface;
  const std::size_t points = surface.position.size(), per_point = window.answer.lumps.per_point;
  SurfaceResponse& response = window.condition.response;
  window.condition.reference_pressure.assign(points, 0);
  response = {};  // the fluid takes the surface as a wall that moves as given
  if (!setup.iterates) return;
  response = {window.answer.lumps.lump, window.answer.lumps.share, window.answer.mass};
  for (std::size_t k = 0; k < points; ++k) {
    // A pressure p loads the point with s p A, where the fluid takes it for p A: s is some per cent off 1 where particles are on no
    // lattice, and less at a free surface. So its load is that of the pressure L/(s A), and its shares add up to s. With s left out, a body
    // that rests under p is taken to give way by dt (1 - s) p/m in every window: where s > 1 that makes energy. And a level of p that rises
    // on both sides of a plate moves it by what s differs from side to side. A point that no pressure loads yields to what the particles
    // before it fill.
    const bool loaded = window.share[k] > least_share;
    const double share = loaded ? window.share[k] : 1;
    const double quickness = loaded ? share : window.seen_share[k] > least_share ? window.seen_share[k] : 1;
    for (std::size_t c = k * per_point; c < (k + 1) * per_point; ++c) response.share[c] *= quickness;
    // What the assumed load carries, less what is known of the answer; contacts are not the pressure's. A pressure in excess of this moves
    // the surface on from where it was predicted.
    const Vector<D> carried = window.assumed_load.force[k] - window.load.force[k] - window.assumed_contact.force[k];
    window.condition.reference_pressure[k] = -carried.dot(surface.normal[k]) / (share * surface.area[k]);
  }
}

template void find_answer<2>(const Setup<2>&, const Surface<2>&, State<2>&, Workspace<2>&);
template void find_answer<3>(const Setup<3>&, const Surface<3>&, State<3>&, Workspace<3>&);
template void set_robin_condition<2>(const Setup<2>&, Workspace<2>&);
template void set_robin_condition<3>(const Setup<3>&, Workspace<3>&);

}  // namespace tern::coupler
