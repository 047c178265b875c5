#pragma once
// Where a body of the structure stands at a wall, the patches of the wall that its faces cut are hidden in part. Taken whole
// or not at all, a face that moves along a wall would uncover it in jumps of a patch, and the particles in the corner with it.

#include <vector>

#include "sph/faces.hpp"

namespace tern::fluid {

/// The walls as the fluid sees them beside the structure.
template <int D>
class ClippedWalls {
 public:
  const Faces<D>& faces() const { return faces_; }

  /// Takes over `walls` as they stand.
  void reset(const Faces<D>& walls) {
    faces_ = walls;
    clipped_.clear();
  }
  /// Leaves of every patch of `walls` what lies before the first face of the structure that cuts it; in 3D as if that were a square
  /// again. `finder`: of the walls, which it may hold as they were before: a patch moves by half its length at most.
  void clip(const Faces<D>& walls, const FaceFinder<D>& finder, const Faces<D>& structure);

 private:
  void cut(int wall, const Faces<D>& structure, int k);

  Faces<D> faces_;
  std::vector<int> clipped_;
};

}  // namespace tern::fluid
