#pragma once
// The order of one coupling window, the same for participants in other processes and for objects in this one.
// Fluid side:     begin_window, see_surface, solve_pressure, end_window; extent, pass_window  (fluid/fluid.hpp)
// Structure side: predict_surface, respond, apply                        (structure/coupled_structure.hpp)

#include <algorithm>

#include "base/time.hpp"
#include "coupler/coupling_step.hpp"

namespace tern::coupler {

/// Whether the surface is without influence on the fluid, and the fluid on the surface, in a window of this length.
template <int D>
bool out_of_reach(const FluidExtent<D>& fluid, const Surface<D>& surface, Ticks duration) {
  const double reach = fluid.reach + 0.5 * seconds(duration) * fluid.largest_speed;  // the pressure is solved halfway
  return std::none_of(surface.position.begin(), surface.position.end(),
                      [&](const Vector<D>& x) { return (x - x.cwiseMax(fluid.low).cwiseMin(fluid.high)).squaredNorm() <= reach * reach; });
}

template <int D, class FluidSide, class StructureSide>
void run_window(FluidSide& fluid, StructureSide& structure, CouplingStep<D>& step, Ticks begin, Ticks duration) {
  fluid.begin_window(begin, duration);
  const Surface<D> surface = structure.predict_surface(begin, duration);
  if (const auto extent = fluid.extent(); extent && out_of_reach(*extent, surface, duration)) {
    step.pass(seconds(begin), seconds(duration), surface);
    fluid.pass_window();
    structure.apply(step.surface_load());
    return;
  }
  const InterfaceParticles<D> band = fluid.see_surface(surface);
  InterfacePressure<D> pressure = fluid.solve_pressure(step.dissipative_load(seconds(begin), seconds(duration), surface, band));
  while (const SurfaceLoad<D>* trial = step.next_trial(pressure))  // CM3 only
    pressure = fluid.solve_pressure(step.dissipative_load(structure.respond(*trial)));
  const InterfaceForce<D> force = step.interface_force(pressure);
  fluid.end_window(force);
  structure.apply(step.surface_load());
}

}  // namespace tern::coupler
