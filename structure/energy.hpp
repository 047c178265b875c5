#pragma once
// Energies, momentum and output fields of the present state.

#include "structure/state.hpp"
#include "structure/structure.hpp"

namespace tern::structure {

/// Energy density of the cell of the particle in `row` [J/m^3], from the last deformation_gradient().
template <int D>
double energy_density(const Body& body, const Workspace<D>& work, std::int32_t row);

/// `work` holds the deformation gradient of `state`.
template <int D>
Energies energies_of(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work);

template <int D>
Momentum momentum_of(const Reference<D>& reference, const State<D>& state);

/// `work` holds deformation gradient and stress of `state`.
template <int D>
Fields<D> fields_of(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work);

}  // namespace tern::structure
