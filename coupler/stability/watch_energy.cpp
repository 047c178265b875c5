#include <fmt/format.h>

#include "base/error.hpp"
#include "coupler/stability/observations.hpp"

namespace tern::coupler {
namespace {

constexpr double least_energy = 0.02;  ///< that counts, over that of the scene
constexpr double round_off = 1e-9;     ///< of the energy of the layer

}  // namespace

template <int D>
void watch_energy(const Setup<D>& setup, double time, const Energies& energies, Observations& seen) {
  // What counts: a fiftieth of the energy that the weight of the fluid beside the bodies and its motion at the start have; where there is
  // next to none of that, the motion of a layer of particles at the speed that the window is made for. The strain of a curved shell at rest
  // is round-off, and no scene.
  const double area = seen.surface_area, duration = seen.duration;
  if (!seen.energy_at_start) seen.energy_at_start = energies.present;
  const double of_scene = setup.fluid_weight.energy(area) + *seen.energy_at_start,
               speed = duration > 0 ? setup.courant * setup.spacing / duration : 0;
  const double of_layer = 0.5 * setup.density * setup.spacing * area * speed * speed;
  const double least = of_scene > round_off * of_layer ? least_energy * of_scene : of_layer;
  if (!seen.energy.add(energies.total, energies.present, least)) return;
  throw NumericalFailure(fmt::format(
      "The interface has made {:.3g} {} in the last {} windows up to t = {:.6g} s, of {:.3g} that are present as motion and strain; "
      "the limit is {:g} of it. The fluid sees another motion of the bodies' surface than they make: {}.",
      seen.energy.made(), D == 2 ? "J/m" : "J", InterfaceEnergy::windows, time, energies.present, InterfaceEnergy::share, setup.remedy));
}

template void watch_energy<2>(const Setup<2>&, double, const Energies&, Observations&);
template void watch_energy<3>(const Setup<3>&, double, const Energies&, Observations&);

}  // namespace tern::coupler
