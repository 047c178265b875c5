#pragma once
// A material point between the particles: weights phi_j with sum phi_j = 1 and sum phi_j X_j = X.

#include <string>

#include "structure/reference.hpp"
#include "structure/structure.hpp"

namespace tern::structure {

/// Throws BadInput when the body does not exist or `at` is no point of its shape.
template <int D>
MaterialPoint find_material_point(const Reference<D>& reference, const std::string& body, const Vector<D>& at);

}  // namespace tern::structure
