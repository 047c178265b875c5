#include "fluid/walls.hpp"

#include <algorithm>

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

bool is_open(const WallCase& wall, int face) {
  return std::count(wall.open.begin(), wall.open.end(), open_names[face / 2][face % 2]) > 0;
}

template <int D>
Vector<D> evaluate(const VectorExpression& expression, double t) {
  Vector<D> value;
  for (int c = 0; c < D; ++c) value[c] = expression[c](t);
  return value;
}

}  // namespace

template <int D>
Walls<D>::Walls(const Case& scene, double fluid_spacing) {
  for (const WallCase& wall : scene.walls) {
    const SurfacePoints<D> points = sample_surface<D>(wall.shape, 0.5 * fluid_spacing);
    Wall entry{wall, faces_.size(), 0};
    for (std::size_t k = 0; k < points.position.size(); ++k) {
      if (wall.container && wall.shape.kind == Shape::Kind::box && is_open(wall, box_face<D>(points.normal[k]))) continue;
      const bool inside_body = scene.structure && std::any_of(scene.structure->bodies.begin(), scene.structure->bodies.end(),
                                                              [&](const StructureBody& body) {
                                                                return contains<D>(body.shape, points.position[k]);
                                                              });
      if (inside_body) continue;
      faces_.position.push_back(points.position[k]);
      faces_.velocity.push_back(Vector<D>::Zero());
      faces_.normal.push_back(wall.container ? Vector<D>(-points.normal[k]) : points.normal[k]);
      faces_.area.push_back(points.area[k]);
      faces_.normal_acceleration.push_back(0);
      faces_.two_sided.push_back(!wall.container);
    }
    entry.last = faces_.size();
    moving_ = moving_ || wall.displacement.has_value();
    any_two_sided_ = any_two_sided_ || !wall.container;
    walls_.push_back(std::move(entry));
  }
  reference_ = faces_.position;
  if (moving_) move_to(0, 1);
}

template <int D>
void Walls<D>::move_to(double time, double duration) {
  for (Wall& wall : walls_) {
    if (!wall.scene.displacement) continue;
    const Vector<D> displacement = evaluate<D>(*wall.scene.displacement, time);
    const Vector<D> velocity = (displacement - evaluate<D>(*wall.scene.displacement, std::max(0.0, time - duration))) / duration;
    const Vector<D> acceleration = time > 0 ? Vector<D>((velocity - wall.velocity) / duration) : Vector<D>::Zero();
    for (std::size_t k = wall.first; k < wall.last; ++k) {
      faces_.position[k] = reference_[k] + displacement;
      faces_.velocity[k] = velocity;
      faces_.normal_acceleration[k] = acceleration.dot(faces_.normal[k]);
    }
    wall.velocity = velocity;
  }
}

template class Walls<2>;
template class Walls<3>;

}  // namespace tern::fluid
