#pragma once
// The rigid part of the motion of a body that nothing holds. No stiffness acts on it: loads alone change it.

#include <vector>

#include "base/vector.hpp"
#include "structure/state.hpp"

namespace tern::structure {

/// Motion of the rigid body that has the mass, the momentum and the angular momentum of a body about its centre of mass.
template <int D>
struct FreeMotion {
  Vector<D> centre = Vector<D>::Zero();    ///< of mass [m]
  Vector<D> velocity = Vector<D>::Zero();  ///< of the centre [m/s]
  Matrix<D> spin = Matrix<D>::Zero();      ///< W, skew: a point moves at velocity + W (x - centre) [1/s]

  Vector<D> at(const Vector<D>& x) const { return velocity + spin * (x - centre); }
};

/// Of each of Reference::bodies; one that is held somewhere, by a clamp or a hinge, has no motion here.
template <int D>
std::vector<FreeMotion<D>> free_motions(const Reference<D>& reference, const State<D>& state);

}  // namespace tern::structure
