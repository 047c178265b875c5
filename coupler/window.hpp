#pragma once
// The coupler: what it is given, what it remembers, and the window (window.cpp).

#include <string>
#include <vector>

#include "coupler/participants.hpp"
#include "coupler/setup.hpp"
#include "coupler/state.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

/// Whether the surface is without influence on the fluid, and the fluid on the surface, in a window of this length.
template <int D>
bool out_of_reach(const FluidExtent<D>& fluid, const Surface<D>& surface, Ticks duration);

struct WindowProposal {
  double seconds;
  std::string limit;
};

template <int D>
class Coupler {
 public:
  Coupler(const Case& scene, const SurfaceProperties& properties) : setup_(scene, properties), state_(setup_), window_(setup_) {}

  /// How long the next window is to be, at most as long as the fluid proposes [s], and what limits it. Windows of light bodies are half as
  /// long as the fluid's, and no window is longer than the motion of the surface allows (motion_error.hpp).
  WindowProposal propose(double of_fluid, const std::string& limit) const;

  /// One window, from opening to end. Throws NumericalFailure when a load is not finite, when fluid and structure cannot be brought to
  /// agree, and when the coupling diverges; and what the participants throw.
  void run_window(Participants<D>& participants, Ticks begin, Ticks duration);

  // Its parts, in this order; times in s.

  /// Instead of all that follows: the surface is out of the fluid's reach, and without load.
  void pass_window(double begin, double duration, const Surface<D>& surface);

  /// Who sees whom, explicit forces from u* and the predicted velocity, and how the surface yields.
  const InterfaceCondition<D>& first_exchange(double begin, double duration, const Surface<D>& surface, InterfaceParticles<D> particles);

  /// The load under which the structure has to make this window again; null when both sides agree, or when the algorithm does not iterate.
  const SurfaceLoad<D>* next_load(const InterfacePressure<D>& pressure);

  /// `velocity`: that the structure reaches under next_load(). True when the surface moves as the fluid took it to: the window is done.
  bool accepts(const std::vector<Vector<D>>& velocity);

  /// After accepts() said no: a load that is nearer to agreement than that of next_load(), under which the structure has to move instead;
  /// null where there is none.
  const SurfaceLoad<D>* accelerated_load();

  /// The first exchange once more, with the velocities that the structure has reached last [m/s].
  const InterfaceCondition<D>& repeat_exchange(std::vector<Vector<D>> surface_velocity);

  /// Pressure and contact forces on the particles, where windows are repeated those of the last next_load(); surface_load() is the load
  /// of the structure now. Audit and observers.
  const InterfaceForce<D>& last_exchange(const InterfacePressure<D>& pressure);

  const SurfaceLoad<D>& surface_load() const { return window_.load; }
  const WindowAudit& audit() const { return window_.audit; }
  int iterations() const { return window_.iterations; }  ///< of the last window: pressure solves, where they are counted
  bool agreed() const { return window_.agreed; }         ///< whether fluid and structure did at its end
  const Setup<D>& setup() const { return setup_; }
  const State<D>& state() const { return state_; }
  /// Of another coupler of the same case, at a window's end.
  void set_state(const State<D>& state) {
    state_ = state;
    if (!state_.start.area.empty() && setup_.learns) state_.response.prepare(setup_, state_.start);  // a report may follow at once
  }

  /// At the end of a window that no other follows.
  void watch(double time, const Energies& energies) { watch_energy(setup_, time, energies, state_.observations); }
  /// Load on one body in the last window [N/m^(3-D)].
  Vector<D> total_load(std::uint32_t body) const;

 private:
  const Setup<D> setup_;
  State<D> state_;
  Workspace<D> window_;
};

/// The same with both sides in this process.
template <int D, class FluidSide, class StructureSide>
void run_window(FluidSide& fluid, StructureSide& structure, Coupler<D>& coupler, Ticks begin, Ticks duration) {
  LocalParticipants<D, FluidSide, StructureSide> participants(fluid, structure);
  coupler.run_window(participants, begin, duration);
}

}  // namespace tern::coupler
