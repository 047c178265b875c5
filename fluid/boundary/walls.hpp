#pragma once
// Rigid walls as face patches: the insides of containers, the outsides of obstacles, fixed or moved as rigid bodies.

#include <string>
#include <vector>

#include "fluid/boundary/plane_walls.hpp"
#include "scene/case_file.hpp"
#include "sph/faces.hpp"

namespace tern::fluid {

/// One wall of the scene: where it is, and which patches are its own.
template <int D>
struct Wall {
  WallCase scene;
  std::size_t first = 0, last = 0;  ///< its patches: first .. last - 1
  Placement<D> place;
  double turn_rate = 0;                      ///< mean over the window [rad/s]
  Vector<D> shift_rate = Vector<D>::Zero();  ///< likewise [m/s]

  /// Of the rigid body at x, at the middle of the window; 0 where the wall does not move [m/s].
  Vector<D> velocity(const Vector<D>& x) const {
    if (!scene.motion) return Vector<D>::Zero();
    return shift_rate + turning_velocity<D>(turn_rate, scene.motion->axis, Vector<D>(x - place.pivot - place.shift));
  }
};

template <int D>
class Walls {
 public:
  /// Patches of half a fluid spacing. Those that an elastic body covers are patches too: it may leave. In a periodic direction the
  /// patches nearer to the end of the period than `support` have images beyond it.
  Walls(const Case& scene, double fluid_spacing, double support);

  const Faces<D>& faces() const { return faces_; }
  bool moving() const { return moving_; }
  /// The fluid does not stick to patch k.
  bool slips(int k) const { return slip_[k]; }
  bool any_two_sided() const { return any_two_sided_; }
  /// The wall of that name, which the scene is known to have.
  const Wall<D>& find(const std::string& name) const;
  const std::vector<Wall<D>>& all() const { return walls_; }
  /// Number of the wall in it that has patch k.
  std::size_t wall_of(int k) const;
  /// Sides of box-shaped containers, in 3D where no wall moves and nothing is periodic, ...
  const std::vector<PlaneWall>& planes() const { return planes_; }
  /// ... and the numbers of the other walls.
  const std::vector<int>& not_plane() const { return not_plane_; }

  /// Places moving walls at the middle of the window [begin, begin + duration] [s]: once per window, in the order of time. The
  /// velocity of a patch is that of a rigid body that shifts and turns at the mean rates over the window; its acceleration
  /// is the change from the velocity before, 0 in the first window. `velocity`: of each patch, of the window before; set to
  /// that of this one [m/s]. Returns the largest acceleration of a patch along its normal [m/s^2].
  double move_over(double begin, double duration, std::vector<Vector<D>>& velocity);

 private:
  void find_planes();

  std::vector<Wall<D>> walls_;
  std::vector<Vector<D>> reference_, reference_normal_;  ///< of walls that move; empty: none does
  std::vector<std::uint8_t> slip_;
  std::vector<PlaneWall> planes_;
  std::vector<int> not_plane_;
  Faces<D> faces_;
  bool moving_ = false, any_two_sided_ = false;
};

}  // namespace tern::fluid
