// Start of a fluid, and what its state says of itself.

#include "fluid/fluid.hpp"

#include <algorithm>

#include "fluid/gauges/probe.hpp"
#include "fluid/gauges/totals.hpp"
#include "fluid/initial_state.hpp"

namespace tern::fluid {

template <int D>
Fluid<D>::Fluid(const Case& scene)
    : state_(initial_state<D>(scene)),
      reference_(scene, state_.position),
      reports_divergence_(scene.coupling.vem_coefficient.has_value()),
      boundary_(scene, reference_.constants),
      system_(reference_.period) {
  state_.reference_speed = std::max(2 * reference_.speed_floor, largest_speed());
  if (boundary_.walls.moving()) state_.wall_velocity.assign(boundary_.walls.faces().size(), Vector<D>::Zero());
}

template <int D>
Energies Fluid<D>::energies() const {
  return {kinetic_energy(constants().mass, state_), state_.potential};
}

template <int D>
Vector<D> Fluid<D>::momentum() const {
  return fluid::momentum(constants().mass, state_);
}

template <int D>
Vector<3> Fluid<D>::angular_momentum() const {
  return fluid::angular_momentum(constants().mass, state_);
}

template <int D>
VolumeDrift Fluid<D>::volume_drift() const {
  return fluid::volume_drift(constants(), neighbours_, boundary_, correction_, state_);
}

template <int D>
double Fluid<D>::largest_speed() const {
  return fluid::largest_speed(state_.velocity);
}

template <int D>
double Fluid<D>::largest_bulk_speed() const {
  return fluid::largest_bulk_speed(state_);
}

template <int D>
std::size_t Fluid<D>::spray_particles() const {
  return fluid::spray_particles(state_);
}

template <int D>
std::optional<double> Fluid<D>::pressure_at(const Vector<D>& x) const {
  return Probe<D>(*this).pressure(x);
}

template <int D>
std::optional<double> Fluid<D>::elevation_at(const Vector<D>& x) const {
  return Probe<D>(*this).elevation(x);
}

template class Fluid<2>;
template class Fluid<3>;

}  // namespace tern::fluid
