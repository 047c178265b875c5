#pragma once
// The fluid's side of the interface: the particles that see the structure.

#include "fluid/boundary/boundary.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"
#include "proto/interface.hpp"

namespace tern::fluid {

/// The particles that see a face of the structure, with their images in walls and the faces that stand at walls. Sets `at_structure` to
/// their indices. `divergence`: to be reported, or nullptr. `images`: scratch.
template <int D>
InterfaceParticles<D> interface_particles(const Constants<D>& constants, const State<D>& state, const Prediction<D>& prediction,
                                          const Boundary<D>& boundary, const std::vector<double>* divergence,
                                          std::vector<Vector<D>>& images, std::vector<int>& at_structure);

}  // namespace tern::fluid
