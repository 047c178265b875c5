#pragma once
// The order of one coupling window, the same for participants in other processes and for objects in this one.
// Fluid side:     begin_window, see_surface, solve_pressure, end_window  (fluid/fluid.hpp)
// Structure side: predict_surface, respond, apply                        (structure/coupled_structure.hpp)

#include "coupler/coupling_step.hpp"
#include "particles/time.hpp"

namespace tern::coupler {

template <int D, class FluidSide, class StructureSide>
void run_window(FluidSide& fluid, StructureSide& structure, CouplingStep<D>& step, Ticks begin, Ticks duration) {
  fluid.begin_window(begin, duration);
  const Surface<D> surface = structure.predict_surface(begin, duration);
  const Band<D> band = fluid.see_surface(surface);
  BandPressure<D> pressure = fluid.solve_pressure(step.dissipative_load(seconds(begin), seconds(duration), surface, band));
  while (const SurfaceLoad<D>* trial = step.next_trial(pressure))  // CM3 only
    pressure = fluid.solve_pressure(step.dissipative_load(structure.respond(*trial)));
  const BandForce<D> force = step.interface_force(pressure);
  structure.apply(step.surface_load());
  fluid.end_window(force);
}

}  // namespace tern::coupler
