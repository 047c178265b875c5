// What the pressure does beside a body, with what the interface gives back. Its level does nothing, and the pressure of water at rest bears
// the weight of every particle.

#include <gtest/gtest.h>

#include <map>

#include "fixtures/interface_scenes.hpp"
#include "fluid/fluid.hpp"
#include "fluid/pressure/pressure_gradient.hpp"
#include "structure/structure.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double window = 1e-3, dx = 0.01, low = 0.1, high = 0.18, width = 0.28;

enum class Place { middle, floor };

/// A block in the middle of a tank, water on all sides; or on its floor.
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
  if (place == Place::floor) {
    WallCase floor;
    floor.name = "floor";
    floor.shape = box({-width, -1, -width}, {2 * width, low, 2 * width});
    c.walls.push_back(floor);
    c.fluid->bodies.erase(c.fluid->bodies.begin());
  }
  block.spacing = 0.5 * dx;
  block.young_modulus = 1e9;
  block.poisson_ratio = 0.3;
  block.velocity = constant(0);
  c.coupling.scheme = scheme;
  return c;
}

/// Accelerations of all particles beside the block by this pressure [m/s^2]. `ordered`: with the springs that keep particles in order.
template <int D, class Pressure>
std::vector<Vector<D>> accelerations(InterfaceScheme scheme, Place place, double gravity, bool ordered, Pressure pressure) {
  const Case c = block_in_water<D>(scheme, place, gravity);
  fluid::Fluid<D> fluid(c);
  structure::Structure<D> structure(c);
  std::mt19937 random(20261126);
  std::uniform_real_distribution<double> shift(-0.15 * dx, 0.15 * dx);
  fluid::State<D> state = fluid.state();
  for (auto& x : state.position)
    for (int a = 0; a < D; ++a) x[a] += shift(random);
  fluid.set_state(std::move(state));
  fluid.begin_window(0, to_ticks(window));
  const Surface<D> surface = structure.surface();
  const InterfaceParticles<D> particles = fluid.see_surface(surface);

  state = fluid.state();
  for (std::size_t i = 0; i < state.size(); ++i) state.pressure[i] = pressure(state.position[i]);
  std::map<std::uint32_t, int> row;
  for (std::size_t i = 0; i < state.size(); ++i) row[state.id[i]] = static_cast<int>(i);
  std::vector<int> beside;
  InterfacePressure<D> at_interface;
  for (const std::uint32_t id : particles.id) {
    beside.push_back(row[id]);
    at_interface.pressure.push_back(state.pressure[beside.back()]);
  }
  at_interface.velocity = particles.velocity;
  std::vector<Vector<D>> velocity(state.size(), Vector<D>::Zero());
  apply_pressure_gradient(fluid.reference(), window, fluid.neighbours(), fluid.boundary(), fluid.correction(), state, &beside, velocity,
                          ordered ? &velocity : nullptr);

  Coupler<D> coupler(c, structure.surface_properties());
  coupler.first_exchange(0, window, surface, particles);
  const InterfaceForce<D> force = coupler.last_exchange(at_interface);
  std::vector<Vector<D>> result;
  for (std::size_t m = 0; m < beside.size(); ++m) result.push_back(velocity[beside[m]] / window + force.force[m] / particles.mass[m]);
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

}  // namespace
}  // namespace tern::coupler::testing
