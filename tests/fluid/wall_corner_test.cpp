// Convex corners of rigid walls: a block in water, particles on their lattice.

#include <gtest/gtest.h>

#include <map>

#include "fixtures/fluid_scenes.hpp"
#include "fluid/gauges/probe.hpp"

namespace tern::fluid::testing {
namespace {

constexpr double dx = 0.05, low = 0.4, high = 0.8, width = 1.2;

/// Water with a block in it, in a tank, or round a step of the tank itself.
Case block_in_water(int dimension, bool step = false, double top = high) {
  const double flat = dimension == 2 ? -1 : 0, deep = dimension == 2 ? 1 : width;
  const Shape all = box({0, 0, flat}, {width, width, deep});
  const Shape block =
      step ? box({high, 0, flat}, {width, low, deep}) : box({low, low, dimension == 2 ? -1 : low}, {high, top, dimension == 2 ? 1 : high});
  Case c = scene(dimension, dx, {all}, {tank({0, 0, flat}, {width, 2 * width, deep})});
  Shape& water = c.fluid->bodies[0].shape;
  water.kind = Shape::Kind::difference;
  water.parts = {all, block};
  if (step) {
    c.walls[0].shape = {};
    c.walls[0].open = {};
    c.walls[0].shape.kind = Shape::Kind::difference;
    c.walls[0].shape.parts = {box({0, 0, flat}, {width, 2 * width, deep}), block};
  } else {
    c.walls.push_back(obstacle(block.min, block.max));
  }
  c.fluid->numerics.density_relaxation = 0;
  return c;
}

/// Over fluid and faces, of particles beside the block: largest dx |sum grad w|, without back-facing faces as well, and by how much the sum
/// of V w is off that of a lattice.
struct Incompleteness {
  double with = 0, without = 0, density = 0;
};

template <int D>
Incompleteness incompleteness(const Case& c) {
  Fluid<D> fluid(c);
  fluid.begin_window(0, to_ticks(1e-9));
  fluid.see_surface({});
  const BoundarySums<D>& sums = fluid.boundary().sums;
  Incompleteness largest;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    if (fluid.state().position[i][1] > width - 3 * dx) continue;
    const Vector<D> without = fluid.neighbours().kernel_gradient[i] + sums.wall_gradient[i];
    largest.with = std::max(largest.with, dx * (without + sums.back_facing_gradient[i]).norm());
    largest.without = std::max(largest.without, dx * without.norm());
    const double lattice = fluid.reference().constants.lattice.density;
    largest.density = std::max(largest.density, std::abs(fluid.neighbours().number_density[i] + sums.number_density[i] - lattice));
  }
  return largest;
}

// Seen to fail: with pairs cut at corners and with back-facing faces left out (0.11); with the cones behind them left in the density.
TEST(WallCorner, HidesWhatItsFacesBound) {
  for (const auto& [name, found] : {std::pair{"block", incompleteness<2>(block_in_water(2))},
                                    {"cube", incompleteness<3>(block_in_water(3))},
                                    {"step", incompleteness<2>(block_in_water(2, true))}}) {
    std::printf("[ %-5s dx |sum grad w| at most %.4f, without back-facing faces %.4f; sum V w off by %.4f ]\n", name, found.with,
                found.without, found.density);
    EXPECT_LT(found.with, 0.01) << name;
    EXPECT_GT(found.without, 0.1) << name;
    EXPECT_LT(found.density, 0.02) << name;
  }
}

/// What the first window does to water that is at rest.
struct Rest {
  double push = 0, apart = 0;  ///< largest velocity that a window makes, over that of gravity; of pressures, over rho g dx
};

template <int D>
Rest rest_of(const Case& c, double below = width - 3 * dx) {
  Fluid<D> fluid(c);
  constexpr double window = 1e-4;
  step(fluid, window);
  Rest rest;
  double lowest = 1e300, highest = -1e300;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    const Vector<D>& x = fluid.state().position[i];
    if (x[1] > below) continue;
    rest.push = std::max(rest.push, fluid.state().velocity[i].norm() / (gravity * window));
    const double excess = fluid.state().pressure[i] / (density * gravity * dx) - (width - x[1]) / dx;
    lowest = std::min(lowest, excess), highest = std::max(highest, excess);
  }
  rest.apart = highest - lowest;
  return rest;
}

// Seen to fail: with T of the faces seen alone (0.130 g), without back-facing faces (0.446 g) or without them in the pressure equation
// (pressures); without them in the gradient at the free surface (0.451 g there).
TEST(WallCorner, LeavesWaterAtRest) {
  struct Row {
    const char* name;
    Rest rest;
    double push, apart;  ///< at most
  };
  for (const Row& row : {Row{"block", rest_of<2>(block_in_water(2)), 0.06, 0.04}, Row{"cube", rest_of<3>(block_in_water(3)), 0.06, 0.04},
                         Row{"step", rest_of<2>(block_in_water(2, true)), 0.06, 0.04},
                         Row{"block below the surface", rest_of<2>(block_in_water(2, false, width - 2 * dx), width), 0.12, 0.3}}) {
    std::printf("[ %s: push %.3f g; pressures %.4f rho g dx apart ]\n", row.name, row.rest.push, row.rest.apart);
    EXPECT_LT(row.rest.push, row.push) << row.name;
    EXPECT_LT(row.rest.apart, row.apart) << row.name;
  }
}

/// Water in a channel that repeats itself, and a block in it that begins at `from`, or has a part on either side of the seam.
Case block_at_seam(double from) {
  const double length = high - low;
  Case c = scene(2, dx, {box({0, 0, -1}, {width, width, 1})}, {tank({0, 0, -1}, {width, 2 * width, 1}, {"x_min", "x_max", "y_max"})});
  make_periodic(c, {0, -1, -1}, {width, 3 * width, 1}, "x");
  Shape& water = c.fluid->bodies[0].shape;
  const Shape all = water;
  water.kind = Shape::Kind::difference;
  water.parts = {all};
  const auto add = [&](double x, double end) {
    c.walls.push_back(obstacle({x, low, -1}, {end, high, 1}));
    water.parts.push_back(c.walls.back().shape);
  };
  add(from, std::min(from + length, width));
  if (from + length > width) {
    add(0, from + length - width);
    c.walls.back().name = "rest";
  }
  c.fluid->numerics.density_relaxation = 0;
  return c;
}

// Seen to fail: with the faces past a corner looked for where they are and not a period away (0.841 g).
TEST(WallCorner, IsPassedAcrossTheSeamOfAPeriod) {
  for (const double from : {0.0, 2 * dx, width - (high - low), width - 3 * dx}) {
    const Rest rest = rest_of<2>(block_at_seam(from));
    std::printf("[ block from %.2f: push %.3f g; pressures %.4f rho g dx apart ]\n", from, rest.push, rest.apart);
    EXPECT_LT(rest.push, 0.06) << from;
    EXPECT_LT(rest.apart, 0.04) << from;
  }
}

// A row of particles is a hair inside a plate half a spacing thick. The face that they are right behind is none past a corner: it would
// take away all that keeps them fluid. Seen to fail: without is_inside() (3 of 24).
TEST(WallCorner, IsNoneForAParticleInTheWall) {
  const Shape all = box({0, 0, -1}, {width, width, 1}), plate = box({0.475, -dx, -1}, {0.5, 2 * width, 1});
  Case c = scene(2, dx, {all}, {tank({0, 0, -1}, {width, 2 * width, 1}), obstacle(plate.min, plate.max)});
  c.fluid->bodies[0].shape.kind = Shape::Kind::difference;
  c.fluid->bodies[0].shape.parts = {all, plate};
  Fluid<2> fluid(c);
  auto state = fluid.state();
  for (Vector<2>& x : state.position)
    if (std::abs(x[0] - plate.min[0]) < 2e-3 * dx) x[0] = plate.min[0] + 0.01 * dx;
  fluid.set_state(std::move(state));
  fluid.begin_window(0, to_ticks(1e-9));
  fluid.see_surface({});
  int inside = 0, at_corner = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    const Vector<2>& x = fluid.state().position[i];
    if (x[0] <= plate.min[0] || x[0] >= plate.max[0]) continue;
    ++inside;
    at_corner += fluid.boundary().sums.back_facing_gradient[i].norm() > 0;
  }
  EXPECT_EQ(inside, 24);
  EXPECT_EQ(at_corner, 0);
}

/// Of the fourth window, where everything falls freely: what it changes velocities by besides, and the largest pressure.
Rest rest_in_free_fall(Case c) {
  for (WallCase& wall : c.walls) wall.motion.emplace().displacement[1] = Expression("-0.5*9.81*t^2");
  Fluid<2> fluid(c);
  constexpr double window = 1e-3;
  for (int n = 0; n < 3; ++n) step(fluid, window);  // the first does not know that walls are accelerated
  std::map<std::uint32_t, Vector<2>> before;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) before[fluid.state().id[i]] = fluid.state().velocity[i];
  step(fluid, window);
  Rest rest;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    const Vector<2> change = fluid.state().velocity[i] - before[fluid.state().id[i]] + Vector<2>(0, gravity * window);
    rest.push = std::max(rest.push, change.norm() / (gravity * window));
    rest.apart = std::max(rest.apart, std::abs(fluid.state().pressure[i]) / (density * gravity * dx));
  }
  return rest;
}

// There is no pressure. Seen to fail: without the acceleration of the faces that are seen (push), and of the back-facing ones (0.066).
TEST(WallCorner, OfABlockThatFallsWithItsWaterPushesNothing) {
  for (const bool step : {false, true}) {
    const Rest rest = rest_in_free_fall(block_in_water(2, step));
    std::printf("[ push %.4f g, pressure %.4f rho g dx ]\n", rest.push, rest.apart);
    EXPECT_LT(rest.push, 0.06);
    EXPECT_LT(rest.apart, 0.05);
  }
}

}  // namespace
}  // namespace tern::fluid::testing
