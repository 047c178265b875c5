#pragma once
// Matrix and right-hand side of the pressure Poisson equation.

#include "fluid/boundary/boundary.hpp"
#include "fluid/domain.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/pressure/pressure_system.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"
#include "proto/interface.hpp"

namespace tern::fluid {

/// system.enclosed, whose particles it marks in the state: what they lack of their support is no surface.
template <int D>
void find_enclosed_fluid(const Domain<D>& domain, const Neighbours<D>& neighbours, const Corrections<D>& correction, State<D>& state,
                         PressureSystem<D>& system);

/// The rows of all particles that see no face of the structure.
template <int D>
void assemble_pressure_matrix(const Constants<D>& constants, const State<D>& state, const Neighbours<D>& neighbours,
                              const Boundary<D>& boundary, const Corrections<D>& correction, EdgeMatrix& matrix);

/// system.yielding and the rows of the particles `at_structure`, whose faces yield as the load says; system.sealed and
/// system.beside_bodies.
template <int D>
void complete_pressure_matrix(const Constants<D>& constants, const Ranks& ranks, const InterfaceCondition<D>& load,
                              const Neighbours<D>& neighbours, const Boundary<D>& boundary, const Corrections<D>& correction,
                              const Prediction<D>& prediction, const std::vector<int>& at_structure, const State<D>& state,
                              PressureSystem<D>& system);

/// system.source from div u* and the target q of the divergence, and over each enclosed region that bodies tie from what its faces sweep.
template <int D>
void assemble_pressure_source(const Constants<D>& constants, double duration, const InterfaceCondition<D>& load, const State<D>& state,
                              const Prediction<D>& prediction, const Boundary<D>& boundary, const std::vector<int>& at_structure,
                              const std::vector<double>& divergence, const std::vector<double>& target, PressureSystem<D>& system);

}  // namespace tern::fluid
