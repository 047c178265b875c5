#pragma once
// What a pressure does at the interface: pressure forces of the scheme, then contacts.

#include "coupler/state.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

/// Carries the pressure of every particle to the faces it sees and adds the pair forces of the scheme to load and particle force.
template <int D>
void add_pressure(const Setup<D>& setup, const InterfacePressure<D>& pressure, Workspace<D>& window, Evaluations& evaluations);

/// Adds the impulses of particles that touch a face. Inelastic: a particle nearer to a face than the contact distance goes on with
/// the face. Thin sheets and spray feel too little pressure to be stopped otherwise.
template <int D>
void settle_contacts(const Setup<D>& setup, const InterfacePressure<D>& pressure, Workspace<D>& window);

}  // namespace tern::coupler
