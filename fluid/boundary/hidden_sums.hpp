#pragma once
// Sums of one particle over the hidden side of the faces that it sees (Gauss: each face stands for the cone behind it).

#include "fluid/reference.hpp"
#include "sph/faces.hpp"

namespace tern::fluid {

/// Sums over the hidden side of the faces that one particle sees, with the unit vector e from it to a face, the normal n, and
/// the hidden parts of sum V w and tr M in the cone behind the face.
template <int D>
struct HiddenSums {
  double density = 0;                         ///< of the parts of sum V w
  Matrix<D> moment = Matrix<D>::Zero();       ///< sum tr M e e^T
  Matrix<D> across = Matrix<D>::Zero();       ///< sum tr M (e . n) e n^T
  Vector<D> accelerated = Vector<D>::Zero();  ///< sum tr M (e . n) a_n e, a_n the acceleration of the face along n
  Vector<D> gradient = Vector<D>::Zero();     ///< sum weight n
  double flux = 0;                            ///< sum weight n . u_k
};

/// Sums over the faces that particle i at x sees; writes the weights of the row and its least height.
template <int D>
HiddenSums<D> sum_hidden(const Constants<D>& constants, const Vector<D>& x, const Faces<D>& faces, std::ptrdiff_t i, FaceRows& rows);

/// Sums behind a whole plane at rest, at this height above it.
inline HiddenSums<3> sum_behind_plane(const Constants<3>& constants, double height, const Vector<3>& normal) {
  const FaceKernel<3>::PlaneSums plane = constants.faces.behind_plane(height);
  HiddenSums<3> sums;
  const Matrix<3> across = normal * normal.transpose();
  sums.density = plane.density;
  sums.moment = plane.along * Matrix<3>::Identity() + (plane.normal - plane.along) * across;
  sums.across = plane.normal * across;
  sums.gradient = plane.weight * normal;
  return sums;
}

}  // namespace tern::fluid
