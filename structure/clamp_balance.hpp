#pragma once
// A clamp holds a body where its face is. A displacement field has a kink there, so the first particles see the face by a
// particle on it and none behind it (reference.hpp). With the gradients of a quadratic fit over these, a uniform stress P is not at rest:
// it pushes the free particles j near the face by -P b_j, b_j = sum_i V_i dF_i/dx_j, and a body that is pulled goes 0.2 spacings' strain
// too far, as if its clamp were softer. So the gradients along the normal n of the face get second differences along the lattice lines
// that go out from it,
//   F_i += sum_q c_iq (y_0 d_q + y_1 d_q+1 + y_2 d_q+2) x n,
// y = (1, -2, 1), and (4/3, -2, 2/3) where q is the particle on the face, half a spacing before the next. No affine field sees them. c is
// the least that makes b_j what free faces bear (surface_weights.hpp), and 0 elsewhere, in the direction n. The fit is then exact for
// affine fields only; a curvature kappa along the line is seen as a shear of kappa/8 of a spacing in the first layer, which is of no
// weight beside its bending.

#include "structure/lattice.hpp"

namespace tern::structure {

/// Corrects the gradients of the free particles before the faces of clamps; those get neighbourhoods of their own. `offsets`: of
/// DerivativeVectors. Edges of clamps, where a particle has free ones beside it in more than one direction, are left as they are.
template <int D>
void balance_clamps(const std::vector<Cell<D>>& cells, const std::vector<Cell<D>>& offsets, double spacing, Lattice<D>& lattice,
                    std::vector<Neighbourhood<D>>& neighbourhoods);

}  // namespace tern::structure
