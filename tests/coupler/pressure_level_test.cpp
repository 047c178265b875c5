// What the pressure does beside a body, with what the interface gives back. Its level does nothing, and the pressure of water at rest bears
// the weight of every particle.

#include <gtest/gtest.h>

#include <map>

#include "fixtures/interface_scenes.hpp"
#include "fluid/boundary/interface_reaction.hpp"
#include "fluid/fluid.hpp"
#include "fluid/pressure/pressure_gradient.hpp"
#include "structure/structure.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double window = 1e-3, dx = 0.01, low = 0.1, high = 0.18, width = 0.28;

enum class Place { middle, floor, channel, enclosed, enclosed_floor };

bool is_enclosed(Place place) { return place == Place::enclosed || place == Place::enclosed_floor; }

/// A block in the middle of water, on its floor, or with one spacing of water between each side of it and the tank; in open water or in a
/// closed tank.
template <int D>
Case block_in_water(InterfaceScheme scheme, Place place, double gravity) {
  Case c = testing::scene(D, dx);
  c.end_time = 1;
  c.gravity = constant(0, -gravity);
  FluidBody below;
  below.velocity = constant(0);
  below.shape = box({0, 0, 0}, {width, low, width});
  FluidBody above = below, left = below, right = below, behind = below, before = below;
  above.shape = box({0, high, 0}, {width, width, width});
  left.shape = box({0, low, 0}, {low, high, width});
  right.shape = box({high, low, 0}, {width, high, width});
  behind.shape = box({low, low, 0}, {high, high, low});
  before.shape = box({low, low, high}, {high, high, width});
  c.fluid->bodies = {below, above, left, right};
  if (D == 3) c.fluid->bodies.insert(c.fluid->bodies.end(), {behind, before});
  StructureBody& block = c.structure->bodies[0];
  block.shape = box({low, low, low}, {high, high, high});
  if (is_enclosed(place)) {
    WallCase tank;
    tank.name = "tank";
    tank.container = true;
    tank.shape = box({0, 0, 0}, {width, width, width});
    c.walls.push_back(tank);
  }
  if (place == Place::floor || place == Place::enclosed_floor) {
    WallCase floor;
    floor.name = "floor";
    floor.shape = box({-width, -1, -width}, {2 * width, low, 2 * width});
    c.walls.push_back(floor);
    c.fluid->bodies.erase(c.fluid->bodies.begin());
  }
  if (place == Place::channel) {
    WallCase tank;
    tank.name = "tank";
    tank.container = true;
    tank.shape = box({0, 0, 0}, {width, 2 * width, width});
    tank.open = {"y_max"};
    c.walls.push_back(tank);
    left.shape = box({0, low, 0}, {dx, high, width});
    right.shape = box({width - dx, low, 0}, {width, high, width});
    c.fluid->bodies = {below, above, left, right};
    block.shape = box({dx, low, 0}, {width - dx, high, width});
  }
  block.spacing = 0.5 * dx;
  block.young_modulus = 1e9;
  block.poisson_ratio = 0.3;
  block.velocity = constant(0);
  c.coupling.scheme = scheme;
  return c;
}

/// Fluid of particles out of order beside the block under this pressure.
template <int D>
struct Beside {
  Case c;
  fluid::Fluid<D> fluid;
  structure::Structure<D> structure;
  fluid::State<D> state;
  InterfaceParticles<D> particles;
  std::vector<int> rows;  ///< of these in the state

  template <class Pressure>
  Beside(InterfaceScheme scheme, Place place, double gravity, Pressure pressure)
      : c(block_in_water<D>(scheme, place, gravity)), fluid(c), structure(c) {
    std::mt19937 random(20261126);
    std::uniform_real_distribution<double> shift(-0.15 * dx, 0.15 * dx);
    state = fluid.state();
    for (auto& x : state.position)
      for (int a = 0; a < D; ++a) x[a] += shift(random);
    if (is_enclosed(place))
      for (auto& u : state.velocity)
        for (int a = 0; a < D; ++a) u[a] += 100 * shift(random);
    fluid.set_state(std::move(state));
    fluid.begin_window(0, to_ticks(window));
    particles = fluid.see_surface(surface());
    fluid.prepare_pressure();
    state = fluid.state();
    for (std::size_t i = 0; i < state.size(); ++i) state.pressure[i] = pressure(state.position[i]);
    std::map<std::uint32_t, int> row;
    for (std::size_t i = 0; i < state.size(); ++i) row[state.id[i]] = static_cast<int>(i);
    for (const std::uint32_t id : particles.id) rows.push_back(row[id]);
  }

  /// The block stretches, turns and moves away, unevenly.
  Surface<D> surface() const {
    Surface<D> result = structure.surface();
    std::mt19937 random(7);
    std::uniform_real_distribution<double> part(-1, 1);
    for (std::size_t k = 0; k < result.position.size(); ++k)
      for (int a = 0; a < D; ++a) result.velocity[k][a] = 0.3 + 2 * result.position[k][0] + part(random);
    return result;
  }

  /// What the coupler gives back to the particles, and the load of the surface [N].
  std::pair<std::vector<Vector<D>>, std::vector<Vector<D>>> exchange() const {
    InterfacePressure<D> at_interface;
    for (const int i : rows) at_interface.pressure.push_back(state.pressure[i]);
    at_interface.velocity = particles.velocity;
    Coupler<D> coupler(c, structure.surface_properties());
    coupler.first_exchange(0, window, structure.surface(), particles);
    const std::vector<Vector<D>> force = coupler.last_exchange(at_interface).force;
    return {force, coupler.surface_load().force};
  }
  std::vector<Vector<D>> given_back() const { return exchange().first; }
};

/// Accelerations of all particles beside the block by this pressure [m/s^2]. `ordered`: with the springs that keep particles in order.
template <int D, class Pressure>
std::vector<Vector<D>> accelerations(InterfaceScheme scheme, Place place, double gravity, bool ordered, Pressure pressure) {
  const Beside<D> water(scheme, place, gravity, pressure);
  const fluid::Fluid<D>& fluid = water.fluid;
  std::vector<Vector<D>> velocity(water.state.size(), Vector<D>::Zero());
  apply_pressure_gradient(fluid.reference(), window, fluid.neighbours(), fluid.boundary(), fluid.correction(), water.state, &water.rows,
                          velocity, ordered ? &velocity : nullptr);
  const std::vector<Vector<D>> force = water.given_back();
  std::vector<Vector<D>> result;
  for (std::size_t m = 0; m < force.size(); ++m) result.push_back(velocity[water.rows[m]] / window + force[m] / water.particles.mass[m]);
  return result;
}

template <int D>
double largest_change(InterfaceScheme scheme, Place place) {
  constexpr double level = 1e5;
  const auto under = [&](double of) {
    return accelerations<D>(scheme, place, 0, true,
                            [&](const Vector<D>& x) { return of + 10 * std::sin(40 * x[0]) * std::cos(30 * x[1]); });
  };
  const std::vector<Vector<D>> without = under(0), with = under(level);
  EXPECT_GT(without.size(), 70u);
  double largest = 0;
  for (std::size_t i = 0; i < with.size(); ++i) largest = std::max(largest, (with[i] - without[i]).norm());
  return 1000 * dx * largest / level;
}

/// Volume that the pressure equation of enclosed water takes away in its first window, less what it has to for a block that sweeps the
/// power of a uniform pressure on it over that pressure, over the volume that its faces sweep one way or the other.
template <int D>
double volume_without_work(InterfaceScheme scheme, Place place) {
  constexpr double level = 1e4;
  Beside<D> water(scheme, place, 0, [](const Vector<D>&) { return level; });
  const Surface<D> surface = water.surface();
  Coupler<D> coupler(water.c, water.structure.surface_properties());
  water.fluid.solve_pressure(coupler.first_exchange(0, window, surface, water.particles));
  const double told = seconds(to_ticks(window)) / 1000 * ordered_sum(water.fluid.pressure_source());
  const std::vector<Vector<D>> load = water.exchange().second;
  double power = 0, either_way = 0;
  for (std::size_t k = 0; k < load.size(); ++k) {
    power -= load[k].dot(surface.velocity[k]);
    either_way += surface.area[k] * std::abs(surface.velocity[k].dot(surface.normal[k]));
  }
  EXPECT_FALSE(water.fluid.sealed().any);
  EXPECT_GT(std::abs(power / level), 0.01 * either_way);
  return std::abs(told - fluid::level_taken_away(power / level, 0.5 * power / level, 1)) / either_way;
}

/// Volume that enclosed water takes away in the last of `windows` for a block that turns about its centre, over the square of the speed
/// of its faces times half a window. Faces stand where they are in the middle of a window, and move as they do at its end.
double volume_of_turning_block(int windows) {
  constexpr double rate = 20;
  const Case c = block_in_water<2>(InterfaceScheme::riemann, Place::enclosed, 0);
  fluid::Fluid<2> fluid(c);
  const structure::Structure<2> structure(c);
  const Surface<2> rest = structure.surface();
  const Vector<2> centre = Vector<2>::Constant(0.5 * (low + high));
  const auto turned = [&](double middle) {
    const auto turn = [&](double time, const Vector<2>& v) -> Vector<2> { return Eigen::Rotation2Dd(rate * time) * v; };
    Surface<2> result = rest;
    for (std::size_t k = 0; k < rest.area.size(); ++k) {
      result.position[k] = centre + turn(middle, rest.position[k] - centre);
      result.normal[k] = turn(middle, rest.normal[k]);
      const Vector<2> at_end = turn(middle + 0.5 * window, rest.position[k] - centre);
      result.velocity[k] = rate * Vector<2>(-at_end[1], at_end[0]);
    }
    return result;
  };
  double told = 0;
  for (int n = 0; n < windows; ++n) {
    Coupler<2> coupler(c, structure.surface_properties());
    const Surface<2> surface = turned((n + 0.5) * window);
    fluid.begin_window(n * to_ticks(window), to_ticks(window));
    const InterfaceParticles<2> particles = fluid.see_surface(surface);
    fluid.solve_pressure(coupler.first_exchange(n * window, window, surface, particles));
    told = window / 1000 * ordered_sum(fluid.pressure_source());
    fluid.end_window({std::vector<Vector<2>>(particles.id.size(), Vector<2>::Zero())});
  }
  double squares = 0;
  for (std::size_t k = 0; k < rest.area.size(); ++k)
    squares += 0.5 * window * rate * rate * rest.area[k] * (rest.position[k] - centre).dot(rest.normal[k]);
  return told / squares;
}

/// Largest acceleration of a particle beside the block in water at rest, over that of gravity.
template <int D>
double largest_unrest(InterfaceScheme scheme, Place place) {
  constexpr double g = 9.81;
  const auto hydrostatic = [&](const Vector<D>& x) { return 1000 * g * (width - x[1]); };
  double largest = 0;
  for (const Vector<D>& a : accelerations<D>(scheme, place, g, false, hydrostatic))
    largest = std::max(largest, (a - g * Vector<D>::Unit(1)).norm());
  return largest / g;
}

/// Largest part along the reaction of the interface of what keeps the particles beside the block in order, over the largest of it.
template <int D>
double order_across_faces() {
  const auto pressure = [](const Vector<D>& x) { return 1000 * 9.81 * (width - x[1]); };
  const std::vector<Vector<D>> with = accelerations<D>(InterfaceScheme::riemann, Place::middle, 9.81, true, pressure);
  const std::vector<Vector<D>> without = accelerations<D>(InterfaceScheme::riemann, Place::middle, 9.81, false, pressure);
  const Beside<D> water(InterfaceScheme::riemann, Place::middle, 9.81, pressure);
  double across = 0, most = 0;
  for (std::size_t m = 0; m < with.size(); ++m) {
    const Vector<D> order = with[m] - without[m];
    across = std::max(across, std::abs(order.dot(water.fluid.boundary().sums.reaction[water.rows[m]].normalized())));
    most = std::max(most, order.norm());
  }
  return across / most;
}

// What pushed layers away from a face would have no reaction on the body, and the pressure that answers it would push that.
// Seen to fail: with order kept across the faces, too (0.6).
TEST(Order, BesideABodyIsKeptAlongItsFacesAlone) { EXPECT_LT(order_across_faces<2>(), 1e-9); }

// On particles 15 % out of their lattice. Measured: 1e-15 of the level.
// Seen to fail: with the level left in (0.3); with the fluid's own sums over the faces in place of the reaction (0.05); without faces past
// corners (0.2); without images (0.06 on the floor).
TEST(PressureLevel, DoesNotMoveParticlesBesideABody) {
  for (const auto& [scheme, name, meaning] : interface_schemes) {
    const double middle = largest_change<2>(scheme, Place::middle), floor = largest_change<2>(scheme, Place::floor);
    std::printf("[ %-7s %.1e of the level, on the floor %.1e ]\n", name, middle, floor);
    EXPECT_LT(middle, 1e-11) << name;
    EXPECT_LT(floor, 1e-11) << name;
  }
  EXPECT_LT(largest_change<3>(InterfaceScheme::riemann, Place::middle), 1e-11);
}

// The level of an enclosed pressure is what lets bodies sweep no volume. Its work on them is then none, and it makes no energy, if the
// volume is counted as the load is, and if it does not push the fluid. Measured: 5e-16 of the level.
// Seen to fail: with the sum of the divergences in place of the volume that the faces sweep; with the fluid's own sums over the
// faces in place of the shares of the load (0.007).
TEST(PressureLevel, OfEnclosedWaterWorksByTheVolumeThatTheBodySweeps) {
  for (const Place place : {Place::enclosed, Place::enclosed_floor}) {
    for (const auto& [scheme, name, meaning] : interface_schemes) {
      const double volume = volume_without_work<2>(scheme, place), push = largest_change<2>(scheme, place);
      std::printf("[ %-7s %.1e of the volume, push %.1e of the level ]\n", name, volume, push);
      EXPECT_LT(volume, 1e-12) << name;
      EXPECT_LT(push, 1e-11) << name;
    }
  }
  EXPECT_LT(volume_without_work<3>(InterfaceScheme::riemann, Place::enclosed), 1e-12);
  EXPECT_LT(largest_change<3>(InterfaceScheme::riemann, Place::enclosed), 1e-11);
}

// A block that turns sweeps no volume, though its faces are where they were half a window before the velocity that they have. Measured:
// 0.17, given back of the first window. Seen to fail: without what A n changes by in half a window (1.03).
TEST(PressureLevel, OfEnclosedWaterKeepsTheVolumeOfABlockThatTurns) {
  const double volume = volume_of_turning_block(8);
  std::printf("[ %.1e of half a window of the square of the velocity ]\n", volume);
  EXPECT_LT(std::abs(volume), 0.25);
}

// On the same particles. Measured: 6e-15 of gravity. Seen to fail: without what balances the weight (0.2), and with what it balances taken
// before loads are made up (0.02).
TEST(PressureLevel, BearsTheWeightOfParticlesBesideABody) {
  for (const auto& [scheme, name, meaning] : interface_schemes) {
    if (scheme == InterfaceScheme::fsa) continue;  // carries pressures by a gradient of its own
    const double middle = largest_unrest<2>(scheme, Place::middle), floor = largest_unrest<2>(scheme, Place::floor);
    std::printf("[ %-7s %.1e of gravity, on the floor %.1e ]\n", name, middle, floor);
    EXPECT_LT(middle, 1e-9) << name;
    EXPECT_LT(floor, 1e-9) << name;
  }
  EXPECT_LT(largest_unrest<3>(InterfaceScheme::riemann, Place::middle), 1e-9);
}

// Particles in single file between a body and a wall tell the gradient along the file alone. Seen to fail: with all of T in the balance
// (0.06; 0.6 without C^F along the file).
TEST(PressureLevel, BearsTheWeightOfParticlesInSingleFile) {
  const double unrest = largest_unrest<2>(InterfaceScheme::riemann, Place::channel);
  std::printf("[ %.1e of gravity ]\n", unrest);
  EXPECT_LT(unrest, 1e-9);
}

// Twice the pressure of water at rest. Seen to fail: without C^F along the file (0.46).
TEST(PressureLevel, PushesParticlesInSingleFileAlongTheirChannel) {
  constexpr double g = 9.81;
  const auto pressure = [&](const Vector<2>& x) { return 2000 * g * (width - x[1]); };
  const std::vector<Vector<2>> pushed = accelerations<2>(InterfaceScheme::riemann, Place::channel, g, false, pressure);
  const Beside<2> water(InterfaceScheme::riemann, Place::channel, g, pressure);
  double sum = 0;
  int count = 0;
  for (std::size_t m = 0; m < pushed.size(); ++m) {
    const Vector<2>& x = water.particles.position[m];
    if (x[1] < low + 2 * dx || x[1] > high - 2 * dx || (x[0] > dx && x[0] < width - dx)) continue;
    sum += pushed[m][1] / g - 1;
    ++count;
  }
  std::printf("[ %.3f of gravity more, mean of %d particles ]\n", sum / count, count);
  EXPECT_NEAR(sum / count, 1, 0.1);
}

/// Largest difference between what the coupler gives back and what the fluid takes that to be, over the largest force.
template <int D>
double largest_surprise(InterfaceScheme scheme, Place place) {
  const Beside<D> water(scheme, place, 9.81, [&](const Vector<D>& x) { return 1e4 * (width - x[1]) + 500 * std::sin(40 * x[0]); });
  std::vector<Vector<D>> velocity(water.state.size(), Vector<D>::Zero());
  add_interface_reaction(water.fluid.constants(), window, water.fluid.boundary(), water.state, water.rows, velocity);
  const std::vector<Vector<D>> force = water.given_back();
  double largest = 0, error = 0;
  for (std::size_t m = 0; m < force.size(); ++m) {
    largest = std::max(largest, force[m].norm());
    error = std::max(error, (force[m] - water.particles.mass[m] / window * velocity[water.rows[m]]).norm());
  }
  EXPECT_GT(largest, 0);
  return error / largest;
}

// What a pressure solve leaves behind is that of the velocity with the force of the interface, which the fluid has to know before the
// coupler has answered. On the same particles. Measured: 5e-16. Seen to fail: with the weight of the fluid up to the faces left out (0.03).
TEST(InterfaceReaction, IsWhatTheCouplerGivesBack) {
  for (const InterfaceScheme scheme : {InterfaceScheme::pi, InterfaceScheme::riemann}) {
    const double middle = largest_surprise<2>(scheme, Place::middle), floor = largest_surprise<2>(scheme, Place::floor);
    std::printf("[ %.1e of the largest force, on the floor %.1e ]\n", middle, floor);
    EXPECT_LT(middle, 1e-11);
    EXPECT_LT(floor, 1e-11);
  }
  EXPECT_LT(largest_surprise<3>(InterfaceScheme::riemann, Place::middle), 1e-11);
}

}  // namespace
}  // namespace tern::coupler::testing
