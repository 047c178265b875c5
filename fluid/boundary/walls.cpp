#include "fluid/boundary/walls.hpp"

#include <algorithm>
#include <cmath>

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
void add_with_images(const Case& scene, const Shape& shape, const Vector<D>& x, const Vector<D>& normal, double slack, double support,
                     Add&& add) {
  std::vector<Vector<D>> places = {x};
  for (int c = 0; c < D; ++c) {
    if (!scene.periodic[c]) continue;
    const double low = scene.domain_min[c], high = scene.domain_max[c];
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

}  // namespace

template <int D>
Walls<D>::Walls(const Case& scene, double fluid_spacing, double support) {
  for (const WallCase& wall : scene.walls) {
    const SurfacePoints<D> points = sample_surface<D>(wall.shape, 0.5 * fluid_spacing);
    Wall<D> entry{wall, faces_.size(), 0, {}, 0, Vector<D>::Zero()};
    for (std::size_t k = 0; k < points.position.size(); ++k) {
      if (wall.container && wall.shape.kind == Shape::Kind::box && is_open(wall, box_face<D>(points.normal[k]))) continue;
      const int original = static_cast<int>(faces_.size());
      add_with_images<D>(scene, wall.shape, points.position[k], points.normal[k], 0.01 * fluid_spacing, support, [&](const Vector<D>& x) {
        faces_.position.push_back(x);
        faces_.velocity.push_back(Vector<D>::Zero());
        faces_.normal.push_back(wall.container ? Vector<D>(-points.normal[k]) : points.normal[k]);
        faces_.area.push_back(points.area[k]);
        faces_.normal_acceleration.push_back(0);
        faces_.two_sided.push_back(!wall.container);
        faces_.original.push_back(original);
        slip_.push_back(wall.slip);
      });
    }
    entry.last = faces_.size();
    moving_ = moving_ || wall.motion.has_value();
    any_two_sided_ = any_two_sided_ || !wall.container;
    walls_.push_back(std::move(entry));
  }
  for (auto* v : {&faces_.position, &faces_.velocity, &faces_.normal}) v->shrink_to_fit();
  for (auto* v : {&faces_.area, &faces_.normal_acceleration}) v->shrink_to_fit();
  if (!moving_) {
    if (!std::count(scene.periodic.begin(), scene.periodic.begin() + D, true)) find_planes();
    return;
  }
  reference_ = faces_.position;
  reference_normal_ = faces_.normal;
}

template <int D>
void Walls<D>::find_planes() {
  if constexpr (D == 3) {
    for (std::size_t w = 0; w < walls_.size(); ++w) {
      const auto& [scene, begin, end, place, turn_rate, shift_rate] = walls_[w];
      if (!scene.container || scene.shape.kind != Shape::Kind::box) {
        not_plane_.push_back(static_cast<int>(w));
        continue;
      }
      for (std::size_t k = begin; k < end;) {  // a side; its patches have one normal
        PlaneWall plane;
        faces_.normal[k].cwiseAbs().maxCoeff(&plane.axis);
        plane.side = faces_.normal[k][plane.axis];
        plane.place = faces_.position[k][plane.axis];
        plane.along = {(plane.axis + 1) % D, (plane.axis + 2) % D};
        plane.first = static_cast<int>(k);
        while (k < end && faces_.normal[k] == faces_.normal[plane.first]) ++k;
        plane.count[0] = 0;
        while (plane.first + plane.count[0] < static_cast<int>(k) &&
               faces_.position[plane.first + plane.count[0]][plane.along[1]] == faces_.position[plane.first][plane.along[1]])
          ++plane.count[0];
        plane.count[1] = (static_cast<int>(k) - plane.first) / plane.count[0];
        for (int c = 0; c < 2; ++c) {
          plane.low[c] = scene.shape.min[plane.along[c]];
          plane.high[c] = scene.shape.max[plane.along[c]];
          plane.step[c] = (plane.high[c] - plane.low[c]) / plane.count[c];
        }
        planes_.push_back(plane);
      }
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
double Walls<D>::move_over(double begin, double duration, std::vector<Vector<D>>& velocity_of) {
  double largest = 0;
  for (Wall<D>& wall : walls_) {
    if (!wall.scene.motion) continue;
    const Placement<D> before = placement<D>(*wall.scene.motion, begin), after = placement<D>(*wall.scene.motion, begin + duration);
    wall.place = placement<D>(*wall.scene.motion, begin + 0.5 * duration);
    // Not the mean velocity of the patch itself: the chord of an arc is shorter than the way along it.
    wall.shift_rate = (after.shift - before.shift) / duration;
    wall.turn_rate = (after.angle - before.angle) / duration;
    for (std::size_t k = wall.first; k < wall.last; ++k) {
      faces_.position[k] = wall.place(reference_[k]);
      faces_.normal[k] = wall.place.turn * reference_normal_[k];
      // The change of the patch's own velocity has the tangential and the centripetal part of its acceleration.
      const Vector<D> velocity = wall.velocity(faces_.position[k]);
      faces_.normal_acceleration[k] = begin > 0 ? (velocity - velocity_of[k]).dot(faces_.normal[k]) / duration : 0;
      largest = std::max(largest, std::abs(faces_.normal_acceleration[k]));
      faces_.velocity[k] = velocity_of[k] = velocity;
    }
  }
  return largest;
}

template class Walls<2>;
template class Walls<3>;

}  // namespace tern::fluid
