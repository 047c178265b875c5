#pragma once
// Scenes and states the fluid tests share, built by hand. Density 1000 kg/m^3, gravity 9.81 m/s^2 unless said
// otherwise.

#include <cmath>
#include <numbers>
#include <random>

#include "fluid/fluid.hpp"
#include "particles/parallel.hpp"

namespace tern::fluid::testing {

inline constexpr double density = 1000, gravity = 9.81;

inline Shape box(std::array<double, 3> min, std::array<double, 3> max) {
  Shape shape;
  shape.min = min;
  shape.max = max;
  return shape;
}

inline WallCase tank(std::array<double, 3> min, std::array<double, 3> max, std::vector<std::string> open = {"y_max"}) {
  WallCase wall;
  wall.name = "tank";
  wall.container = true;
  wall.shape = box(min, max);
  wall.open = std::move(open);
  return wall;
}

inline WallCase obstacle(std::array<double, 3> min, std::array<double, 3> max) {
  WallCase wall;
  wall.name = "obstacle";
  wall.shape = box(min, max);
  return wall;
}

inline Case scene(int dimension, double spacing, const std::vector<Shape>& bodies, std::vector<WallCase> walls = {},
                  double g = gravity) {
  Case c;
  c.path = "scene";
  c.dimension = dimension;
  c.gravity[1] = Expression(-g);
  c.domain_min = {-1e3, -1e3, -1e3};
  c.domain_max = {1e3, 1e3, 1e3};
  c.walls = std::move(walls);
  c.fluid.emplace();
  c.fluid->density = density;
  c.fluid->spacing = spacing;
  for (const Shape& shape : bodies) c.fluid->bodies.push_back({shape, {}});
  return c;
}

/// Lets the scene repeat itself in the directions named, with the box as its period.
inline void make_periodic(Case& c, std::array<double, 3> min, std::array<double, 3> max, const std::string& directions) {
  c.domain_min = min;
  c.domain_max = max;
  for (char direction : directions) c.periodic[direction - 'x'] = true;
}

/// Taylor-Green vortices in a periodic square or cube of side 1, n particles a side; without gravity.
inline Case vortices(int dimension, int n) {
  Case c = scene(dimension, 1.0 / n, {box({0, 0, 0}, {1, 1, 1})}, {}, 0);
  make_periodic(c, {0, 0, 0}, {1, 1, 1}, dimension == 2 ? "xy" : "xyz");
  c.fluid->bodies[0].velocity = {Expression("-cos(2*pi*x)*sin(2*pi*y)"), Expression("sin(2*pi*x)*cos(2*pi*y)"), Expression()};
  return c;
}

/// A column of nx by ny particles in the corner of a tank four columns wide.
inline Case dam_break(int nx, int ny) {
  return scene(2, 0.2 / nx, {box({0, 0, 0}, {0.2, 0.2 * ny / nx, 0})}, {tank({0, 0, 0}, {0.8, 1, 0})});
}

/// A column 0.2 m x 0.4 m (3D: 0.2 m deep) that falls on a rigid block half way through a tank of 0.8 m: impact on the
/// block at 0.2 s, on the far wall at 0.4 s.
inline Case dam_break_on_block(int dimension, double spacing) {
  const double depth = dimension == 3 ? 0.2 : 0;
  const double side = 0.25 * depth;
  return scene(dimension, spacing, {box({0, 0, 0}, {0.2, 0.4, depth})},
               {tank({0, 0, 0}, {0.8, 1, depth}), obstacle({0.5, 0, side}, {0.54, 0.08, depth - side})});
}

/// A tank of 0.8 m x 0.6 m (3D: 0.2 m deep) in two by a plate of `thickness` up to the height `top`, water of 0.2 m on one
/// side of it and of 0.1 m on the other, as high on both where the plate ends below. `bend`: how far the plate bulges (2D) [m].
inline Case parted_tank(int dimension, double spacing, double thickness, double top, double bend = 0) {
  const double depth = dimension == 3 ? 0.2 : 0, foot = -0.1, middle = 0.4, end = top < 0.2 ? 0.2 : 0.1;
  WallCase plate = obstacle({middle, foot, 0}, {middle + thickness, top, depth});
  Shape left = box({0, 0, 0}, {middle, 0.2, depth}), right = box({middle + thickness, 0, 0}, {0.8, end, depth});
  std::vector<Shape> waters = {left, right};
  if (top < 0.2) waters.push_back(box({middle, top, 0}, {middle + thickness, 0.2, depth}));
  if (bend > 0) {
    const auto face = [&](double offset, double y) {
      return std::array<double, 2>{middle + offset + bend * std::sin(std::numbers::pi * y / 0.2), y};
    };
    constexpr int pieces = 60;
    const auto add = [&](Shape& shape, double offset, double from, double to) {
      shape.kind = Shape::Kind::polygon;
      for (int k = 0; k <= pieces; ++k) shape.vertices.push_back(face(offset, from + (to - from) * k / pieces));
    };
    add(plate.shape, thickness, foot, top);
    add(plate.shape, 0, top, foot);
    waters.assign(2, {});
    add(waters[0], 0, 0, 0.2);
    waters[0].vertices.insert(waters[0].vertices.end(), {{0, 0.2}, {0, 0}});
    add(waters[1], thickness, end, 0);
    waters[1].vertices.insert(waters[1].vertices.end(), {{0.8, 0}, {0.8, end}});
  }
  return scene(dimension, spacing, waters, {tank({0, 0, 0}, {0.8, 0.6, depth}), plate});
}

/// Moves every particle by up to `size` spacings in each direction.
template <int D>
void jitter(Fluid<D>& fluid, double size, std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-size * fluid.constants().spacing, size * fluid.constants().spacing);
  State<D> state = fluid.state();
  for (auto& x : state.position)
    for (int c = 0; c < D; ++c) x[c] += shift(random);
  fluid.set_state(std::move(state));
}

/// The first half of a window: afterwards the pressure is solved and belongs to the positions at its begin.
template <int D>
void solve(Fluid<D>& fluid, double duration) {
  fluid.begin_window(fluid.state().time, to_ticks(duration));
  fluid.see_surface({});
  fluid.solve_pressure({});
}

template <int D>
void step(Fluid<D>& fluid, double duration) {
  solve(fluid, duration);
  fluid.end_window({});
}

/// Steps as the fluid proposes them until `until` [s]; calls observe() after each.
template <int D, class Observe>
void run(Fluid<D>& fluid, double until, Observe&& observe) {
  StepControl control;
  const Ticks end = to_ticks(until);
  while (fluid.state().time < end) {
    const Ticks now = fluid.state().time;
    const Ticks ticks = control.next(fluid.propose_step().seconds, now, end);
    fluid.begin_window(now, ticks);
    fluid.see_surface({});
    fluid.solve_pressure({});
    fluid.end_window({});
    observe();
  }
}

/// Iterations of the pressure solve over some steps.
struct Iterations {
  double sum = 0;
  int count = 0, most = 0;

  void add(int iterations) {
    sum += iterations, ++count;
    most = std::max(most, iterations);
  }
  double mean() const { return sum / std::max(count, 1); }
};

/// Over twelve steps from 2 % disorder, as long as the fluid proposes.
template <int D>
Iterations count_iterations_from_disorder(Fluid<D>& fluid) {
  std::mt19937 random(20240119);
  jitter(fluid, 0.02, random);
  Iterations iterations;
  for (int k = 0; k < 12; ++k) {
    step(fluid, fluid.propose_step().seconds);
    iterations.add(fluid.last_solve().iterations);
  }
  return iterations;
}

template <int D>
Iterations count_iterations(Fluid<D>& fluid, double until) {
  Iterations iterations;
  run(fluid, until, [&] { iterations.add(fluid.last_solve().iterations); });
  return iterations;
}

/// Least-squares line p = offset + slope y over the particles below `height`, and the deviations from it.
struct PressureLine {
  double slope = 0, offset = 0;
  double noise = 0;    ///< root mean square deviation [Pa]
  double largest = 0;  ///< largest deviation [Pa]
};

template <int D>
PressureLine fit_pressure(const Fluid<D>& fluid, double height) {
  const State<D>& state = fluid.state();
  double n = 0, y = 0, p = 0, yy = 0, yp = 0;
  for (std::size_t i = 0; i < state.size(); ++i) {
    const double yi = state.position[i][1];
    if (yi > height) continue;
    n += 1, y += yi, p += state.pressure[i], yy += yi * yi, yp += yi * state.pressure[i];
  }
  PressureLine line;
  line.slope = (n * yp - y * p) / (n * yy - y * y);
  line.offset = (p - line.slope * y) / n;
  for (std::size_t i = 0; i < state.size(); ++i) {
    if (state.position[i][1] > height) continue;
    const double deviation = state.pressure[i] - line.offset - line.slope * state.position[i][1];
    line.noise += deviation * deviation / n;
    line.largest = std::max(line.largest, std::abs(deviation));
  }
  line.noise = std::sqrt(line.noise);
  return line;
}

}  // namespace tern::fluid::testing
