#include "fluid/boundary/walls.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/followed_velocity.hpp"
#include "scene/estimate.hpp"

namespace tern::fluid {
namespace {

constexpr const char* open_names[3][2] = {{"x_min", "x_max"}, {"y_min", "y_max"}, {"z_min", "z_max"}};

/// Index of the box face with this outward normal: 2 * direction + (1 for the upper face).
template <int D>
int box_face(const Vector<D>& outward) {
  int direction = 0;
  outward.cwiseAbs().maxCoeff(&direction);
  return 2 * direction + (outward[direction] > 0 ? 1 : 0);
}

bool is_open(const WallCase& wall, int face) { return std::count(wall.open.begin(), wall.open.end(), open_names[face / 2][face % 2]) > 0; }

/// Calls add(x) for the place x of a patch and its images beyond the ends of the period. A patch on such an end is no face
/// where the wall continues in its own image, that is, where the shape has as much on the other end.
template <int D, class Add>
void add_with_images(const DomainEnds& ends, const Shape& shape, const Vector<D>& x, const Vector<D>& normal, double slack, double support,
                     Add&& add) {
  if (!std::count(ends.periodic.begin(), ends.periodic.begin() + D, true)) return add(x);
  std::vector<Vector<D>> places = {x};
  for (int c = 0; c < D; ++c) {
    if (!ends.periodic[c]) continue;
    const double low = ends.min[c], high = ends.max[c];
    const Vector<D> period = (high - low) * Vector<D>::Unit(c);
    if (x[c] < low + slack && normal[c] < -0.99 && contains<D>(shape, x + 2 * slack * normal + period)) return;
    if (x[c] > high - slack && normal[c] > 0.99 && contains<D>(shape, x + 2 * slack * normal - period)) return;
    const std::size_t before = places.size();
    for (std::size_t k = 0; k < before; ++k) {
      if (x[c] < low + support) places.push_back(places[k] + period);
      if (x[c] > high - support) places.push_back(places[k] - period);
    }
  }
  for (const Vector<D>& place : places) add(place);
}

/// Calls visit(place, normal, area, number, image) for the patches of a wall that lie in one of the boxes, and for their images after each.
template <int D, class Visit>
void for_each_patch(const WallCase& wall, const DomainEnds& ends, double patch, double support, const std::vector<Bounds<D>>& boxes,
                    Visit&& visit) {
  visit_surface<D>(wall.shape, patch, boxes, [&](const Vector<D>& x, const Vector<D>& normal, double area, std::int64_t number) {
    if (wall.container && wall.shape.kind == Shape::Kind::box && is_open(wall, box_face<D>(normal))) return;
    bool image = false;
    add_with_images<D>(ends, wall.shape, x, normal, 0.02 * patch, support, [&](const Vector<D>& place) {
      visit(place, wall.container ? Vector<D>(-normal) : normal, area, number, std::exchange(image, true));
    });
  });
}

}  // namespace

template <int D>
Walls<D>::Walls(const Case& scene, double fluid_spacing, double support, bool whole, PatchShare share)
    : patch_(0.5 * fluid_spacing),
      support_(support),
      ends_{scene.periodic, scene.domain_min, scene.domain_max},
      frame_(wall_of_frame(scene)),
      whole_(whole) {
  int frame = 0;
  for (const WallCase& wall : scene.walls) {
    moving_ = moving_ || wall.motion.has_value();
    any_two_sided_ = any_two_sided_ || !wall.container;
    may_have_corners_ =
        may_have_corners_ || !wall.container || (wall.shape.kind != Shape::Kind::box && wall.shape.kind != Shape::Kind::ball);
    walls_.push_back({wall, wall.motion ? ++frame : 0, 0, 0, {}, {}});
  }
  if (!std::count(ends_.periodic.begin(), ends_.periodic.begin() + D, true)) find_planes();
  whole_ ? hold_all() : look_at_all(share);
  if (!frame_) return;
  const RigidMotion& motion = *walls_[*frame_].scene.motion;
  const double instant = 1e-6 * scene.end_time;
  frame_velocity_at_start_ = (placement<D>(motion, instant).shift - placement<D>(motion, 0).shift) / instant;
}

template <int D>
std::optional<Vector<D>> Walls<D>::frame_velocity(const FollowedWalls<D>& followed) const {
  if (!frame_) return std::nullopt;
  return followed.shift_rate.empty() ? frame_velocity_at_start_ : followed.shift_rate[*frame_];
}

template <int D>
void Walls<D>::look_at_all(PatchShare share) {
  std::int64_t number = -share.first;
  for (std::size_t w = 0; w < walls_.size(); ++w)
    for_each_patch<D>(walls_[w].scene, ends_, patch_, support_, {Bounds<D>::everywhere()},
                      [&](const Vector<D>& x, const Vector<D>& normal, double, std::int64_t, bool) {
                        lowest_ = lowest_.cwiseMin(x);
                        if (!walls_[w].scene.motion || number++ % share.every != 0) return;
                        watched_.position.push_back(x);
                        watched_.normal.push_back(normal);
                        watched_.wall.push_back(static_cast<int>(w));
                      });
}

template <int D>
void Walls<D>::hold_all() {
  hold(std::vector<std::vector<Bounds<D>>>(walls_.size(), {Bounds<D>::everywhere()}), Bounds<D>::everywhere());
  for (std::size_t k = 0; k < faces_.size(); ++k) lowest_ = lowest_.cwiseMin(reference(k));
}

template <int D>
Walls<D> Walls<D>::in_whole() const {
  Walls whole = *this;
  whole.whole_ = true;
  whole.hold_all();
  return whole;
}

template <int D>
void Walls<D>::move_as(const Walls& other) {
  for (std::size_t w = 0; w < walls_.size(); ++w) walls_[w].now = other.walls_[w].now, walls_[w].before = other.walls_[w].before;
  duration_ = other.duration_;
  place_patches();
}

template <int D>
void Walls<D>::hold(const std::vector<std::vector<Bounds<D>>>& boxes_of_walls, const Bounds<D>& near) {
  faces_ = {};
  slip_.clear();
  std::vector<std::int64_t> numbers;
  bool any_image = false;
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    Wall<D>& wall = walls_[w];
    wall.first = faces_.size();
    int original = 0;
    for_each_patch<D>(wall.scene, ends_, patch_, support_, boxes_of_walls[w],
                      [&](const Vector<D>& x, const Vector<D>& normal, double area, std::int64_t number, bool image) {
                        if (!image) original = static_cast<int>(faces_.size());
                        faces_.position.push_back(x);
                        faces_.normal.push_back(normal);
                        faces_.area.push_back(area);
                        faces_.two_sided.push_back(!wall.scene.container);
                        any_image = any_image || image;
                        faces_.original.push_back(original);
                        slip_.push_back(wall.scene.slip);
                        numbers.push_back(number);
                      });
    wall.last = faces_.size();
  }
  if (!any_image) faces_.original.clear();
  for (auto* v : {&faces_.position, &faces_.normal}) v->shrink_to_fit();
  faces_.area.shrink_to_fit();
  faces_.original.shrink_to_fit();
  hold_planes(near, numbers);
  if (!moving_) return;
  faces_.velocity.assign(faces_.size(), Vector<D>::Zero());
  faces_.normal_acceleration.assign(faces_.size(), 0);
  reference_ = faces_.position;
  reference_normal_ = faces_.normal;
  place_patches();
}

template <int D>
void Walls<D>::find_planes() {
  if constexpr (D == 3) {
    for (std::size_t w = 0; w < walls_.size(); ++w) {
      const WallCase& scene = walls_[w].scene;
      if (!scene.container || scene.shape.kind != Shape::Kind::box || scene.motion) {
        not_plane_.push_back(static_cast<int>(w));
        continue;
      }
      const Vector<D> low(scene.shape.min.data()), high(scene.shape.max.data());
      std::int64_t number = 0;
      for (int axis = 0; axis < D; ++axis)
        for (const bool upper : {false, true}) {
          PlaneWall plane;
          plane.axis = axis;
          plane.side = upper ? -1 : 1;
          plane.place = upper ? high[axis] : low[axis];
          plane.along = {(axis + 1) % D, (axis + 2) % D};
          for (int c = 0; c < 2; ++c) {
            plane.low[c] = low[plane.along[c]];
            plane.high[c] = high[plane.along[c]];
            plane.count[c] = static_cast<int>(surface_pieces(plane.high[c] - plane.low[c], patch_));
            plane.step[c] = (plane.high[c] - plane.low[c]) / plane.count[c];
          }
          if (!is_open(scene, 2 * axis + (upper ? 1 : 0))) {
            planes_.push_back(plane);
            sides_.push_back({w, number});
          }
          number += static_cast<std::int64_t>(plane.count[0]) * plane.count[1];
        }
    }
  }
}

template <int D>
void Walls<D>::hold_planes(const Bounds<D>& near, const std::vector<std::int64_t>& numbers) {
  if constexpr (D == 3) {
    for (std::size_t p = 0; p < planes_.size(); ++p) {
      PlaneWall& plane = planes_[p];
      const Wall<D>& wall = walls_[sides_[p].wall];
      const std::int64_t columns = plane.count[0], end_of_side = sides_[p].first + columns * plane.count[1];
      const auto place_of = [&](std::int64_t number) {
        const auto from = numbers.begin() + static_cast<std::ptrdiff_t>(wall.first),
                   to = numbers.begin() + static_cast<std::ptrdiff_t>(wall.last);
        return static_cast<int>(std::lower_bound(from, to, number) - numbers.begin());
      };
      const int first = place_of(sides_[p].first), last = place_of(end_of_side);
      const auto for_each_near = [&](auto&& visit) {  // the others are held for another box
        for (int k = first; k < last; ++k)
          if (near.has(faces_.position[k]))
            visit(k, static_cast<int>((numbers[k] - sides_[p].first) % columns),
                  static_cast<int>((numbers[k] - sides_[p].first) / columns));
      };
      plane.held = {plane.count, {0, 0}};
      for_each_near([&](int, int column, int row) {
        plane.held.from = {std::min(plane.held.from[0], column), std::min(plane.held.from[1], row)};
        plane.held.to = {std::max(plane.held.to[0], column + 1), std::max(plane.held.to[1], row + 1)};
      });
      if (plane.held.to[1] == 0) plane.held = {};
      plane.row.assign(static_cast<std::size_t>(plane.held.to[1] - plane.held.from[1]), 0);
      for_each_near([&](int k, int column, int row) { plane.row[row - plane.held.from[1]] = k - column; });
    }
  }
}

template <int D>
const Wall<D>& Walls<D>::find(const std::string& name) const {
  return *std::find_if(walls_.begin(), walls_.end(), [&](const Wall<D>& wall) { return wall.scene.name == name; });
}

template <int D>
std::size_t Walls<D>::wall_of(int k) const {
  const auto behind = [](std::size_t patch, const Wall<D>& wall) { return patch < wall.last; };
  return static_cast<std::size_t>(std::upper_bound(walls_.begin(), walls_.end(), static_cast<std::size_t>(k), behind) - walls_.begin());
}

template <int D>
bool Walls<D>::is_beside_moving(std::size_t k, double reach) const {
  const Vector<D>& x = faces_.position[k];
  return !faces_.original.empty() || std::any_of(walls_.begin(), walls_.end(), [&](const Wall<D>& wall) {
    return wall.scene.motion &&
           ((k >= wall.first && k < wall.last) || std::abs(signed_distance<D>(wall.scene.shape, wall.reference(x))) < reach);
  });
}

namespace {

/// A patch of a wall that moves, in the window.
template <int D>
struct MovedPatch {
  Vector<D> position, normal, velocity;
  double normal_acceleration;

  /// `duration`: of the window [s]; 0: there is none yet.
  MovedPatch(const Wall<D>& wall, const Vector<D>& reference, const Vector<D>& reference_normal, double duration)
      : position(wall.now.place(reference)), normal(wall.now.place.turn * reference_normal), velocity(wall.velocity(position)) {
    // The change of the patch's own velocity has the tangential and the centripetal part of its acceleration.
    const Vector<D> velocity_before = wall.before.velocity(wall.scene.motion->axis, wall.before.place(reference));
    normal_acceleration = duration > 0 ? (velocity - velocity_before).dot(normal) / duration : 0;
  }
};

}  // namespace

template <int D>
void Walls<D>::place_patches() {
  for (const Wall<D>& wall : walls_) {
    if (!wall.scene.motion) continue;
    for (std::size_t k = wall.first; k < wall.last; ++k) {
      const MovedPatch<D> patch(wall, reference_[k], reference_normal_[k], duration_);
      faces_.position[k] = patch.position;
      faces_.normal[k] = patch.normal;
      faces_.velocity[k] = patch.velocity;
      faces_.normal_acceleration[k] = patch.normal_acceleration;
    }
  }
}

template <int D>
WallRates Walls<D>::move_over(double begin, double duration, double last_duration, FollowedWalls<D>& followed) {
  const bool first = last_duration == 0;
  if (first) {
    for (auto* rates : {&followed.shift_rate, &followed.own_shift_rate}) rates->assign(walls_.size(), Vector<D>::Zero());
    for (auto* numbers : {&followed.turn_rate, &followed.own_turn_rate, &followed.angle}) numbers->assign(walls_.size(), 0);
  }
  const double ratio = first ? 1 : duration / last_duration;
  const auto follow = [&]<class Rate>(const Rate& mean, Rate& given, Rate& own) {
    const FollowedVelocity<Rate> next = followed_velocity<Rate>(mean, {given, own}, ratio);
    given = next.given;
    own = next.own;
    return next.given;
  };
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    Wall<D>& wall = walls_[w];
    if (!wall.scene.motion) continue;
    const auto place_at = [&](double time) { return placement<D>(*wall.scene.motion, time); };
    const Placement<D> at_begin = place_at(begin), at_end = place_at(begin + duration);
    wall.now.place = placement<D>(wall.scene, begin + 0.5 * duration);
    // Not of the mean velocity of the patch itself: the chord of an arc is shorter than the way along it.
    const Vector<D> mean_shift_rate = (at_end.shift - at_begin.shift) / duration;
    const double mean_turn_rate = (at_end.angle - at_begin.angle) / duration;
    if (first) {
      // Of the motion through three places, as if it had gone on so before: `own` is of a third of a window before `given`.
      const Vector<D> change = 4 * (at_end.shift - 2 * place_at(begin + 0.5 * duration).shift + at_begin.shift) / duration;
      const double turn_change = 4 * (at_end.angle - 2 * wall.now.place.angle + at_begin.angle) / duration;
      followed.shift_rate[w] = mean_shift_rate - 0.5 * change;
      followed.turn_rate[w] = mean_turn_rate - 0.5 * turn_change;
      followed.own_shift_rate[w] = followed.shift_rate[w] - change / 3;
      followed.own_turn_rate[w] = followed.turn_rate[w] - turn_change / 3;
      followed.angle[w] = wall.now.place.angle;
    }
    // Where it had been shifted to does not matter: all of it has the same shift rate.
    wall.before.place = placed_at<D>(*wall.scene.motion, Vector<D>::Zero(), followed.angle[w]);
    wall.before.shift_rate = followed.shift_rate[w];
    wall.before.turn_rate = followed.turn_rate[w];
    wall.now.shift_rate = follow(mean_shift_rate, followed.shift_rate[w], followed.own_shift_rate[w]);
    wall.now.turn_rate = follow(mean_turn_rate, followed.turn_rate[w], followed.own_turn_rate[w]);
    followed.angle[w] = wall.now.place.angle;
  }
  duration_ = duration;
  place_patches();
  WallRates largest;
  const Vector<D> of_frame = frame_velocity(followed).value_or(Vector<D>::Zero());
  const auto add = [&](const Vector<D>& velocity, double normal_acceleration) {
    largest.speed = std::max(largest.speed, velocity.norm());
    largest.speed_in_frame = std::max(largest.speed_in_frame, (velocity - of_frame).norm());
    largest.acceleration = std::max(largest.acceleration, std::abs(normal_acceleration));
  };
  for (std::size_t k = 0; whole_ && moving_ && k < faces_.size(); ++k) add(faces_.velocity[k], faces_.normal_acceleration[k]);
  for (std::size_t k = 0; k < watched_.wall.size(); ++k) {
    const MovedPatch<D> patch(walls_[watched_.wall[k]], watched_.position[k], watched_.normal[k], duration);
    add(patch.velocity, patch.normal_acceleration);
  }
  return largest;
}

template class Walls<2>;
template class Walls<3>;

}  // namespace tern::fluid
