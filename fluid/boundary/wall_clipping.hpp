#pragma once
// Where a body of the structure stands at a wall, the patches of the wall that its faces cut are hidden in part. Taken whole
// or not at all, a face that moves along a wall would uncover it in jumps of a patch, and the particles in the corner with it.

#include <vector>

#include "sph/faces.hpp"

namespace tern::fluid {

/// The walls as the fluid sees them beside the structure. They are a copy, which is not made before there is a structure.
template <int D>
class ClippedWalls {
 public:
  /// Nothing clips the walls: there are no faces().
  bool none() const { return !any_; }
  const Faces<D>& faces() const { return faces_; }

  /// The walls have moved.
  void reset() {
    any_ = false;
    clipped_.clear();
  }
  /// Leaves of every patch of `walls` what lies before the first face of the structure that cuts it; in 3D as if that were a square
  /// again. `finder`: of the walls, which it may hold as they were before: a patch moves by half its length at most.
  void clip(const Faces<D>& walls, const FaceFinder<D>& finder, const Faces<D>& structure);

 private:
  void cut(int wall, const Faces<D>& structure, int k);

  Faces<D> faces_;
  double largest_ = 0;  ///< half the length of a patch [m]
  bool any_ = false;
  std::vector<int> clipped_;
};

}  // namespace tern::fluid
