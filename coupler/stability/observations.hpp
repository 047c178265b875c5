#pragma once
// Those who watch a coupling for divergence, and what they have seen so far. Each stops the run by a NumericalFailure that names what it
// has seen, the place, the limit and the remedy. coupler/window.cpp calls them.

#include <optional>
#include <vector>

#include "coupler/setup.hpp"
#include "coupler/stability/interface_energy.hpp"
#include "coupler/stability/load_alternation.hpp"

namespace tern::coupler {

template <int D>
struct Workspace;

/// Energies of both sides at one instant [J/m^(3-D)].
struct Energies {
  double total;    ///< kinetic and potential of the fluid, and the work of the interface on the structure since the start
  double present;  ///< kinetic and strain of both sides
};

struct Observations {
  explicit Observations(std::size_t bodies) : alternation(bodies) {}

  std::vector<LoadAlternation> alternation;  ///< of the load on each body
  InterfaceEnergy energy;
  std::optional<double> energy_at_start;  ///< present then [J/m^(3-D)]
  double surface_area = 0;                ///< of all bodies in the last window with an exchange [m^(D-1)]
  double duration = 0;                    ///< of the last window [s]

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("alternation", all.alternation...);
    visit("energy", all.energy...);
    visit("energy_at_start", all.energy_at_start...);
    visit("surface_area", all.surface_area...);
    visit("duration", all.duration...);
  }
};

/// The load of a window that is settled must not turn round from window to window.
template <int D>
void watch_load(const Setup<D>& setup, const Workspace<D>& window, Observations& seen);

/// The interface must not make energy. `time`: the instant of the energies, the end of a window or the start [s].
template <int D>
void watch_energy(const Setup<D>& setup, double time, const Energies& energies, Observations& seen);

}  // namespace tern::coupler
