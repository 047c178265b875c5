#pragma once
// A uniform stress P is at rest in a body if its particles j push each other by what the faces bear of it,
//   b_j = sum_i V_i dF_i/dx_j = sum_k A_k N_k w_kj     (surface_weights.hpp; inside, where there are no faces, b_j = 0).
// With the gradients of a quadratic fit it is not in two places. Particles give way there until it is, and the body is softer than it
// ought to be. So these gradients get second differences along lattice lines, which no affine field sees,
//   F_i += sum_q c_q (y_0 d_q + y_1 d_q+1 + y_2 d_q+2) x e,      y = (1, -2, 1),
// with the c of least squares of what is wrong with b. The fit is then exact for affine fields only, there.
//
// Clamps. The first particles see the face of a clamp by a particle on it and none behind it (reference.hpp). A body that is pulled goes
// 0.2 spacings' strain too far. The first three layers are corrected in the direction e of the normal, along the lines that go out from
// the face; where q is the particle on it, half a spacing before the next, y = (4/3, -2, 2/3). A curvature kappa along the line is then
// seen as a shear of kappa/8 of a spacing in the first layer, which is of no weight beside its bending.
//
// Askew faces, which cut the lattice. What juts out between its lines bears next to nothing by itself: a beam of four particles across
// bends a third too far. The particles behind such a face and those beside them are corrected in all directions, along all lines of three
// through them or away from them. The lattice fills another volume than the body, so that b cannot become quite right, and c would grow in
// trying to: a hundredth of its square is added to the squares. (A quarter of a ring bends by the same to 1 % with a ten times lesser or
// greater part of it, and with more layers, from eight particles across on.)

#include "scene/case_file.hpp"
#include "structure/lattice.hpp"

namespace tern::structure {

/// The lattice of a body and what its particles see, to be corrected.
template <int D>
struct Fit {
  const std::vector<Cell<D>>& cells;    ///< of the particles
  const std::vector<Cell<D>>& offsets;  ///< of Neighbourhood::derivatives
  double spacing;
  Lattice<D>& lattice;
  std::vector<Neighbourhood<D>>& neighbourhoods;
};

/// Corrects the free particles before the faces of clamps. Edges of clamps, where a particle has free ones beside it in more than one
/// direction, are left as they are.
template <int D>
void balance_clamps(const Fit<D>& fit);

/// Corrects the free particles behind askew faces of `shape`. `first`: X of the first of the cells [m].
template <int D>
void balance_askew_faces(const Fit<D>& fit, const Shape& shape, const std::vector<Shape>& clamps, const Vector<D>& first);

}  // namespace tern::structure
