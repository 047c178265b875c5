#pragma once
// Rigid walls as face patches: the insides of containers, the outsides of obstacles, fixed or moved as rigid bodies.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fluid/boundary/plane_walls.hpp"
#include "scene/case_file.hpp"
#include "scene/geometry.hpp"
#include "sph/faces.hpp"

namespace tern::fluid {

/// Where a wall that moves is at the middle of a window, and how it moves at its end.
template <int D>
struct WallMotion {
  Placement<D> place;
  double turn_rate = 0;                      ///< [rad/s]
  Vector<D> shift_rate = Vector<D>::Zero();  ///< [m/s]

  /// Of the rigid body at x [m/s]. `axis`: of the turn, in 3D.
  Vector<D> velocity(const std::array<double, 3>& axis, const Vector<D>& x) const {
    return shift_rate + turning_velocity<D>(turn_rate, axis, Vector<D>(x - place.pivot - place.shift));
  }
};

/// One wall of the scene: where it is, and which patches are its own.
template <int D>
struct Wall {
  WallCase scene;
  int frame = 0;                    ///< 0: at rest; else its number among those that move, from 1 on
  std::size_t first = 0, last = 0;  ///< its patches: first .. last - 1
  WallMotion<D> now, before;        ///< in the window and in the one before

  /// Of the rigid body at x, at the end of the window; 0 where the wall does not move [m/s].
  Vector<D> velocity(const Vector<D>& x) const { return scene.motion ? now.velocity(scene.motion->axis, x) : Vector<D>(Vector<D>::Zero()); }
  /// Where the point that is now at x was at t = 0.
  Vector<D> reference(const Vector<D>& x) const { return scene.motion ? now.place.reference(x) : x; }
};

/// What the fluid has followed of the motion of walls: FollowedVelocity of each wall, of its shift [m/s] and of its turn [rad/s], and the
/// angle at which it stood [rad].
template <int D>
struct FollowedWalls {
  std::vector<Vector<D>> shift_rate, own_shift_rate;
  std::vector<double> turn_rate, own_turn_rate, angle;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("shift_rate", all.shift_rate...);
    visit("own_shift_rate", all.own_shift_rate...);
    visit("turn_rate", all.turn_rate...);
    visit("own_turn_rate", all.own_turn_rate...);
    visit("angle", all.angle...);
  }
};

/// Of all patches of walls: the largest speed, the same to the observer who goes along with the scene [m/s], and the largest acceleration
/// along the normal [m/s^2].
struct WallRates {
  double speed = 0, speed_in_frame = 0, acceleration = 0;
};

/// Which of some patches are looked at: every so many one, from `first` on.
struct PatchShare {
  int first = 0, every = 1;
};

/// Of the domain of a case: where it ends, and whether it repeats itself there.
struct DomainEnds {
  std::array<bool, 3> periodic;
  std::array<double, 3> min, max;
};

template <int D>
class Walls {
 public:
  /// Patches of half a fluid spacing. Those that an elastic body covers are patches too: it may leave. In a periodic direction the
  /// patches nearer to the end of the period than `support` have images beyond it. `whole`: with all patches; else there are none until
  /// hold(), and move_over() looks at the rates of this share of them.
  Walls(const Case& scene, double fluid_spacing, double support, bool whole = true, PatchShare share = {});

  /// All patches are here.
  bool whole() const { return whole_; }
  /// Of walls that are not whole: from now on those patches that lay in one of the boxes of their wall at t = 0, each with its images, in
  /// the order of all. Of the grid of a plane wall only those in the box `near` can be found by their place, which is one of the boxes.
  void hold(const std::vector<std::vector<Bounds<D>>>& boxes_of_walls, const Bounds<D>& near);
  /// The same walls with all patches.
  Walls in_whole() const;
  /// Places the patches as `other` has them, of the same scene.
  void move_as(const Walls& other);
  /// The lowest coordinates that patches have at t = 0: of walls that are not whole, and in every window, the patches are found in the
  /// order of all as they are then.
  const Vector<D>& lowest() const { return lowest_; }

  const Faces<D>& faces() const { return faces_; }
  bool moving() const { return moving_; }
  /// Shift rate of the wall on which an observer stands who goes along with the scene (wall_of_frame()); nothing if there is none [m/s].
  std::optional<Vector<D>> frame_velocity(const FollowedWalls<D>& followed) const;
  /// The fluid does not stick to patch k.
  bool slips(int k) const { return slip_[k]; }
  bool any_two_sided() const { return any_two_sided_; }
  /// Some wall is not convex on the side of the fluid.
  bool may_have_corners() const { return may_have_corners_; }
  /// The wall of that name, which the scene is known to have.
  const Wall<D>& find(const std::string& name) const;
  const std::vector<Wall<D>>& all() const { return walls_; }
  /// Number of the wall in it that has patch k.
  std::size_t wall_of(int k) const;
  /// Where patch k was at t = 0.
  const Vector<D>& reference(std::size_t k) const { return moving_ ? reference_[k] : faces_.position[k]; }
  /// Whether patch k moves, or a wall that moves may have a patch nearer to it than `reach` [m]; true as well where patches have images.
  bool is_beside_moving(std::size_t k, double reach) const;
  /// Sides of box-shaped containers that do not move, in 3D where nothing is periodic, ...
  const std::vector<PlaneWall>& planes() const { return planes_; }
  /// ... and the numbers of the other walls.
  const std::vector<int>& not_plane() const { return not_plane_; }

  /// Places moving walls at the middle of the window [begin, begin + duration] [s]: once per window, in the order of time. The
  /// velocity of a patch is that of a rigid body that shifts and turns at the rates that followed_velocity() makes of the mean ones; its
  /// acceleration is the change from the velocity before, in the first window from that of its begin. `last_duration`: of the window
  /// before [s], 0 in the first. `followed`: of the window before; set to that of this one.
  WallRates move_over(double begin, double duration, double last_duration, FollowedWalls<D>& followed);

 private:
  /// Patches of walls that move, as at t = 0.
  struct Watched {
    std::vector<Vector<D>> position, normal;
    std::vector<int> wall;
  };
  void look_at_all(PatchShare share);
  void hold_all();
  void place_patches();
  void find_planes();
  /// `numbers`: of the patches, each in its wall (visit_surface()).
  void hold_planes(const Bounds<D>& near, const std::vector<std::int64_t>& numbers);

  double patch_, support_;  ///< [m]
  DomainEnds ends_;
  std::optional<std::size_t> frame_;                       ///< wall_of_frame()
  Vector<D> frame_velocity_at_start_ = Vector<D>::Zero();  ///< of it [m/s]
  bool whole_;
  Vector<D> lowest_ = Vector<D>::Constant(1e300);
  Watched watched_;      ///< where walls are not whole
  double duration_ = 0;  ///< of the window [s]; 0 before the first
  std::vector<Wall<D>> walls_;
  std::vector<Vector<D>> reference_, reference_normal_;  ///< of walls that move; empty: none does
  std::vector<std::uint8_t> slip_;
  std::vector<PlaneWall> planes_;
  std::vector<int> not_plane_;
  struct Side {
    std::size_t wall;
    std::int64_t first;  ///< number of its first patch
  };
  std::vector<Side> sides_;  ///< of each plane
  Faces<D> faces_;
  bool moving_ = false, any_two_sided_ = false, may_have_corners_ = false;
};

}  // namespace tern::fluid
