#pragma once
// Scenes and states the structure tests share, built by hand.

#include <random>

#include "structure/structure.hpp"
#include "structure/time_step.hpp"

namespace tern::structure::testing {

inline Shape box(std::array<double, 3> min, std::array<double, 3> max) {
  Shape shape;
  shape.min = min;
  shape.max = max;
  return shape;
}

inline StructureBody body(const std::string& name, std::array<double, 3> min, std::array<double, 3> max, double spacing) {
  StructureBody b;
  b.name = name;
  b.shape = box(min, max);
  b.spacing = spacing;
  b.density = 1000;
  b.young_modulus = 1e6;
  b.poisson_ratio = 0.3;
  return b;
}

inline Case scene(int dimension, std::vector<StructureBody> bodies) {
  Case c;
  c.dimension = dimension;
  c.structure.emplace();
  c.structure->bodies = std::move(bodies);
  return c;
}

/// A free block of n particles a side, unit spacing.
template <int D>
StructureCase block(double n) {
  return *scene(D, {body("block", {0, 0, 0}, {n, n + 1, n}, 1.0)}).structure;
}

/// The plate of the dam break (4 mm x 90 mm above a clamp of 10 mm), `across` particles thick.
inline Case plate(int across = 4) {
  StructureBody b = body("plate", {0.596, -0.010, 0}, {0.600, 0.090, 0}, 0.004 / across);
  b.density = 1161.54;
  b.young_modulus = 3.5e6;
  b.poisson_ratio = 0.45;
  b.clamps = {box({0.59, -0.02, 0}, {0.61, 0, 0})};
  return scene(2, {b});
}

template <int D, class Map>
void set_rows(const Reference<D>& reference, RowVectors<D>& values, const Map& map) {
  for (const auto row : reference.particle_row) {
    const Vector<D> v = map(reference.position_of(row));
    for (int a = 0; a < D; ++a) values[a][row] = v[a];
  }
}

template <int D>
Vector<D> row_vector(const RowVectors<D>& values, std::int32_t row) {
  Vector<D> v;
  for (int a = 0; a < D; ++a) v[a] = values[a][row];
  return v;
}

template <int D>
Vector<D> random_vector(std::mt19937& random, double size) {
  std::normal_distribution<double> normal(0, size);
  Vector<D> v;
  for (int a = 0; a < D; ++a) v[a] = normal(random);
  return v;
}

/// Internal force and everything it needs, at the present displacement and velocity.
template <int D>
void evaluate(const Reference<D>& reference, State<D>& state, Workspace<D>& work, double dt = 0) {
  internal_forces(reference, 0, dt, state, work);
}

/// Sum over the particles of f and of x cross f (2D: last component only).
template <int D>
std::pair<Eigen::Vector3d, Eigen::Vector3d> force_and_moment(const Reference<D>& reference, const State<D>& state) {
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  for (const auto row : reference.particle_row) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero(), f = x;
    x.head<D>() = reference.position_of(row) + row_vector<D>(state.displacement, row);
    f.head<D>() = row_vector<D>(state.internal_force, row);
    force += f;
    moment += x.cross(f);
  }
  return {force, moment};
}

}  // namespace tern::structure::testing
