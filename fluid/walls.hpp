#pragma once
// Rigid walls as face patches: the insides of containers, the outsides of obstacles, fixed or moved by expressions in t.

#include <vector>

#include "particles/case_file.hpp"
#include "particles/faces.hpp"

namespace tern::fluid {

template <int D>
class Walls {
 public:
  /// Patches of half a fluid spacing. Those inside an elastic body are left out: there the body is the boundary.
  Walls(const Case& scene, double fluid_spacing);

  const Faces<D>& faces() const { return faces_; }
  bool moving() const { return moving_; }
  bool any_two_sided() const { return any_two_sided_; }

  /// Places moving walls at `time` [s]; velocity is the mean over the step of `duration` [s] that ends there.
  void move_to(double time, double duration);

 private:
  struct Wall {
    WallCase scene;
    std::size_t first, last;  ///< its patches
    Vector<D> velocity = Vector<D>::Zero();
  };
  std::vector<Wall> walls_;
  std::vector<Vector<D>> reference_;
  Faces<D> faces_;
  bool moving_ = false, any_two_sided_ = false;
};

}  // namespace tern::fluid
