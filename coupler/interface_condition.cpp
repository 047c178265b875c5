#include "coupler/interface_condition.hpp"

#include <algorithm>

namespace tern::coupler {
namespace {

/// Of the half space before a point. At the end of the kernel, where w~ may be negative, particles and point feel nothing of each other.
constexpr double least_share = 1e-3;

}  // namespace

template <int D>
std::vector<double> stretch_of(const Surface<D>& surface, std::vector<double>& area_at_start) {
  if (area_at_start.empty()) area_at_start = surface.area;
  std::vector<double> stretch(surface.area.size());
  for (std::size_t k = 0; k < stretch.size(); ++k) stretch[k] = surface.area[k] / area_at_start[k];
  return stretch;
}

template <int D>
double responding_mass(const Setup<D>& setup, const Workspace<D>& window, std::size_t k) {
  // Over a window a pressure accelerates the section behind the point. While an elastic wave is on its way through the section, the
  // face moves at the constant p/(rho c). The fluid takes the mean velocity for half of that at the end; for it the answer is that
  // of half the layer that the wave reaches. At least one particle moves. These masses are per area at the start; where the body has
  // been stretched since, less mass is behind the same area.
  const SurfaceProperties& of = setup.properties;
  return std::max(std::min(of.section_mass[k], 0.5 * of.impedance[k] * window.duration), of.least_mass[k]) / window.stretch[k];
}

template <int D>
std::vector<double> robin_mass(const Setup<D>& setup, const Workspace<D>& window, const LearntMass& learnt) {
  std::vector<double> mass(window.stretch.size());
  for (std::size_t k = 0; k < mass.size(); ++k) {
    const double guess = responding_mass(setup, window, k);
    mass[k] = std::max(setup.robin_mass_factor * (setup.algorithm.tests ? learnt.at(k, guess) : guess), setup.least_robin_mass);
  }
  return mass;
}

template <int D>
double largest_gain(const Setup<D>& setup, const Workspace<D>& window) {
  double largest = 1;
  for (std::size_t k = 0; k < setup.properties.body.size(); ++k)
    largest = std::max(largest, window.robin_mass[k] / responding_mass(setup, window, k));
  return largest;
}

template <int D>
void set_robin_condition(const Setup<D>& setup, Workspace<D>& window) {
  const Surface<D>& surface = window.surface;
  const std::size_t points = surface.position.size();
  window.condition.reference_pressure.assign(points, 0);
  window.condition.robin_mass.assign(points, 0);  // 0: the fluid takes the surface as a wall that moves as given
  if (!setup.algorithm.yields) return;
  for (std::size_t k = 0; k < points; ++k) {
    // A pressure p loads the point with s p A, s being the share of its half space that particles fill: some per cent off 1 where they
    // are on no lattice, less at a free surface. So it answers p with the mass m/s, and its load is that of the pressure L/(s A). With s
    // left out, a body that rests under p is taken to give way by dt (1 - s) p/m in every window: where s > 1 that makes energy.
    const double share = window.share[k] > least_share ? window.share[k] : 1;
    window.condition.robin_mass[k] = window.robin_mass[k] / share;
    // What the assumed load carries, less what is known of the answer; contacts are not the pressure's. A pressure in excess of this moves
    // the surface on from where it was predicted.
    const Vector<D> carried = window.assumed_load.force[k] - window.load.force[k] - window.assumed_contact.force[k];
    window.condition.reference_pressure[k] = -carried.dot(surface.normal[k]) / (share * surface.area[k]);
  }
}

template std::vector<double> stretch_of<2>(const Surface<2>&, std::vector<double>&);
template std::vector<double> stretch_of<3>(const Surface<3>&, std::vector<double>&);
template double responding_mass<2>(const Setup<2>&, const Workspace<2>&, std::size_t);
template double responding_mass<3>(const Setup<3>&, const Workspace<3>&, std::size_t);
template std::vector<double> robin_mass<2>(const Setup<2>&, const Workspace<2>&, const LearntMass&);
template std::vector<double> robin_mass<3>(const Setup<3>&, const Workspace<3>&, const LearntMass&);
template double largest_gain<2>(const Setup<2>&, const Workspace<2>&);
template double largest_gain<3>(const Setup<3>&, const Workspace<3>&);
template void set_robin_condition<2>(const Setup<2>&, Workspace<2>&);
template void set_robin_condition<3>(const Setup<3>&, Workspace<3>&);

}  // namespace tern::coupler
