// The state is all that a later step needs: a fresh fluid that is given it at the end of a window goes on with the same bits.

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <numeric>

#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

constexpr unsigned seed = 20261122;

/// A scene, and how many windows it is run before the fresh fluid takes over.
struct Continuation {
  std::string name;
  Case scene;
  int windows_before = 20;
  double jitter = 0;          ///< of the start, in spacings
  bool with_surface = false;  ///< a block on the floor that swings, loads the fluid and yields to it
};

/// A block 0.04 m wide and 0.08 m high that stands at x = 0.2 on average, with the velocity of its motion.
Surface<2> swinging_block(double t) {
  constexpr double size = 0.005, left = 0.2, width = 0.04, height = 0.08, amplitude = 0.004, omega = 30;
  const Vector<2> shift(amplitude * std::sin(omega * t), 0), velocity(amplitude * omega * std::cos(omega * t), 0);
  Surface<2> surface;
  const auto add = [&](const Vector<2>& x, const Vector<2>& normal) {
    surface.position.push_back(x + shift);
    surface.velocity.push_back(velocity);
    surface.normal.push_back(normal);
    surface.area.push_back(size);
  };
  for (double y = 0.5 * size; y < height; y += size) add({left, y}, {-1, 0}), add({left + width, y}, {1, 0});
  for (double x = 0.5 * size; x < width; x += size) add({left + x, height}, {0, 1});
  return surface;
}

/// One window as long as the fluid proposes.
template <int D>
void advance(Fluid<D>& fluid, bool with_surface) {
  const Ticks now = fluid.state().time, duration = to_ticks(fluid.propose_step().seconds);
  fluid.begin_window(now, duration);
  Surface<D> surface;
  if constexpr (D == 2)
    if (with_surface) surface = swinging_block(seconds(now) + 0.5 * seconds(duration));
  const auto particles = fluid.see_surface(surface);
  const std::size_t points = surface.position.size(), seen = particles.id.size();
  InterfaceCondition<D> load;
  load.force.assign(seen, Vector<D>::Zero());
  load.reference_pressure.assign(points, 200);
  load.response.share.assign(points, 1);
  load.response.lump.resize(points);
  std::iota(load.response.lump.begin(), load.response.lump.end(), 0u);
  load.response.mass.assign(points, 0.2);
  const auto pressure = fluid.solve_pressure(load);
  InterfaceForce<D> force;
  for (std::size_t m = 0; m < seen; ++m) force.force.push_back(Vector<D>::Unit(0) * 1e-4 * pressure.pressure[m]);
  fluid.end_window(force);
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// Names of what differs; of the fields of the particles alone, or of all.
template <int D>
std::string differences(const State<D>& a, const State<D>& b, bool fields_only) {
  std::string names;
  const auto note = [&](bool same, const char* name) { names += same ? "" : std::string(" ") + name; };
  for_each_particle_field(a, [&](const char* name, const char*, const auto& values) {
    for_each_particle_field(b, [&]<class Values>(const char* other, const char*, const Values& others) {
      if constexpr (std::is_same_v<std::decay_t<decltype(values)>, Values>)
        if (std::strcmp(name, other) == 0) note(same_bits(values, others), name);
    });
  });
  if (fields_only) return names;
  note(a.time == b.time, "time");
  note(same_bits(a.walls.angle, b.walls.angle) && same_bits(a.walls.own_shift_rate, b.walls.own_shift_rate), "walls");
  note(a.has_pressure == b.has_pressure, "has_pressure");
  note(a.fills_enclosure == b.fills_enclosure, "fills_enclosure");
  note(a.enclosed.any == b.enclosed.any && a.enclosed.largest_flux == b.enclosed.largest_flux &&
           a.enclosed.volume_error == b.enclosed.volume_error && a.enclosed.warned == b.enclosed.warned &&
           a.enclosed.way == b.enclosed.way && a.enclosed.warned_of_lag == b.enclosed.warned_of_lag &&
           same_bits(a.enclosed.pushed, b.enclosed.pushed),
       "enclosed");
  note(a.reference_speed == b.reference_speed, "reference_speed");
  note(a.windows_of_collapse == b.windows_of_collapse, "windows_of_collapse");
  note(a.windows_of_lost_volume == b.windows_of_lost_volume, "windows_of_lost_volume");
  note(a.fallback_solves == b.fallback_solves, "fallback_solves");
  note(a.removed == b.removed && a.leaked == b.leaked, "removed or leaked");
  note(a.potential == b.potential, "potential");
  return names;
}

/// What differs after ten further windows between a fluid that went on and a fresh one that was given its state, as `change`
/// leaves it. `at_the_copy`: looks at that state.
template <int D>
std::string differences_after_ten_windows(
    const Continuation& c, bool fields_only, const std::function<void(State<D>&)>& change = [](State<D>&) {},
    const std::function<void(const State<D>&)>& at_the_copy = [](const State<D>&) {}) {
  Fluid<D> uninterrupted(c.scene);
  std::mt19937 random(seed);
  if (c.jitter > 0) jitter(uninterrupted, c.jitter, random);
  for (int n = 0; n < c.windows_before; ++n) advance(uninterrupted, c.with_surface);
  at_the_copy(uninterrupted.state());
  Fluid<D> fresh(c.scene);
  State<D> state = uninterrupted.state();
  change(state);
  fresh.set_state(std::move(state));
  for (int n = 0; n < 10; ++n) {
    advance(uninterrupted, c.with_surface);
    advance(fresh, c.with_surface);
    const std::string found = differences(uninterrupted.state(), fresh.state(), fields_only);
    if (!found.empty()) return found;
  }
  return "";
}

Continuation falling_column() { return {"dam break", dam_break(10, 20), 150}; }

Continuation viscous() {
  Continuation c{"viscous", dam_break(10, 20), 40};
  c.scene.fluid->viscosity = 1;
  return c;
}

Continuation periodic() { return {"periodic", vortices(2, 16), 30}; }

/// A closed box full of water that turns in it.
Continuation enclosed() {
  Continuation c{"enclosed", scene(2, 0.05, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {1, 1, 0}, {})}), 30, 0.05};
  c.scene.fluid->bodies[0].velocity = {Expression("-sin(pi*x)*cos(pi*y)"), Expression("cos(pi*x)*sin(pi*y)"), Expression()};
  return c;
}

Continuation moving_walls() {
  WallCase wall = tank({0, 0, 0}, {0.4, 0.5, 0});
  wall.motion.emplace().displacement[0] = Expression("0.02*sin(20*t)");
  wall.motion->rotation = Expression("0.1*sin(15*t)");
  return {"moving walls", scene(2, 0.02, {box({0, 0, 0}, {0.4, 0.2, 0})}, {wall})};
}

/// A piston moves into a full box.
Continuation piston() {
  WallCase face = obstacle({1, -0.2, 0}, {1.1, 1.2, 0});
  face.motion.emplace().displacement[0] = Expression("-0.1*t");
  return {"piston", scene(2, 0.05, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {1, 1, 0}, {"x_max"}), face}, 0)};
}

Continuation in_3d() { return {"3D", dam_break_on_block(3, 0.2 / 6), 60}; }

/// Water that flows over the edge of the domain.
Continuation leaving() {
  Continuation c{"leaving", dam_break(10, 20), 80};
  c.scene.domain_max[0] = 0.26;
  return c;
}

/// A drop so fast that the run is about to be stopped.
Continuation fast_drop() {
  Continuation c{"fast drop",
                 scene(2, 0.01, {box({0, 0, 0}, {0.1, 0.1, 0}), box({0.05, 9, 0}, {0.06, 9.01, 0})}, {tank({0, 0, 0}, {0.1, 0.1, 0})})};
  c.scene.fluid->bodies[1].velocity[1] = Expression(10);
  return c;
}

Continuation with_surface() {
  Continuation c{"with a surface", dam_break(10, 20), 30};
  c.scene = scene(2, 0.01, {box({0, 0, 0}, {0.2, 0.2, 0}), box({0.24, 0, 0}, {0.4, 0.1, 0})}, {tank({0, 0, 0}, {0.4, 1, 0})});
  c.with_surface = true;
  return c;
}

class StateOfFluid : public ::testing::TestWithParam<std::function<Continuation()>> {};

// Seen to fail: with particle_class, walls or enclosed.pushed left out of the copy, each in the scenes
// named in the test below.
TEST_P(StateOfFluid, IsAllThatAFreshFluidNeedsToGoOnWithTheSameBits) {
  const Continuation c = GetParam()();
  SCOPED_TRACE(c.name);
  if (c.scene.dimension == 2)
    EXPECT_EQ(differences_after_ten_windows<2>(c, false), "");
  else
    EXPECT_EQ(differences_after_ten_windows<3>(c, false), "");
}

INSTANTIATE_TEST_SUITE_P(OfScenes, StateOfFluid,
                         ::testing::Values(falling_column, viscous, periodic, enclosed, moving_walls, piston, in_3d, leaving,
                                           with_surface));

// What is not in the fields of the particles at the copy shows in them later.
TEST(StateOfFluid, HasNoPartThatCouldBeLeftOut) {
  const auto fields_differ = [](const Continuation& c, const std::function<void(State<2>&)>& leave_out) {
    return !differences_after_ten_windows<2>(c, true, leave_out).empty();
  };
  EXPECT_TRUE(fields_differ(falling_column(), [](State<2>& s) { s.pressure.assign(s.size(), 0); }));
  EXPECT_TRUE(fields_differ(moving_walls(), [](State<2>& s) { s.walls.angle.assign(s.walls.angle.size(), 0); }));
  EXPECT_NE(differences_after_ten_windows<2>(piston(), false, [](State<2>& s) { s.enclosed.pushed.clear(); }), "");
}

// Each scene has in it what it is for.
TEST(StateOfFluid, IsCopiedWhereItMatters) {
  const auto look = [](const Continuation& c, const std::function<void(const State<2>&)>& at_the_copy) {
    differences_after_ten_windows<2>(
        c, true, [](State<2>&) {}, at_the_copy);
  };
  look(fast_drop(), [](const State<2>& s) {
    EXPECT_TRUE(std::any_of(s.particle_class.begin(), s.particle_class.end(), [](ParticleClass own) { return own.spray(); }));
  });
  look(enclosed(), [](const State<2>& s) { EXPECT_TRUE(s.fills_enclosure); });
  look(piston(), [](const State<2>& s) { EXPECT_GT(s.enclosed.volume_error, 0); });
  look(leaving(), [](const State<2>& s) { EXPECT_GT(s.removed, 0u); });
}

// The count of windows goes on where it was: the fresh fluid stops in the same window.
TEST(StateOfFluid, StopsACollapsedRunInTheSameWindow) {
  const Case pool = scene(2, 0.01, {box({0, 0, 0}, {0.1, 0.1, 0})}, {tank({0, 0, 0}, {0.1, 0.1, 0})});
  Fluid<2> fluid(pool);
  State<2> state = fluid.state();
  state.position.back() = {0.05, 10};
  state.velocity.back() = {0, 150 * std::sqrt(gravity * 0.1)};
  fluid.set_state(std::move(state));
  for (int n = 0; n < 6; ++n) advance(fluid, false);
  ASSERT_EQ(fluid.state().windows_of_collapse, 6);
  Fluid<2> fresh(pool);
  fresh.set_state(fluid.state());
  for (int n = 0; n < 3; ++n) advance(fresh, false);
  EXPECT_THROW(advance(fresh, false), NumericalFailure);
}

}  // namespace
}  // namespace tern::fluid::testing
