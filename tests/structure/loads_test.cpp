// Loads, clamps that move, reactions, damping.

#include <gtest/gtest.h>

#include <numbers>

#include "base/error.hpp"
#include "fixtures/structure_scenes.hpp"

namespace tern::structure::testing {
namespace {

/// A bar 20 x 4 along x, clamped at x < 1, with Poisson's ratio 0 unless told.
Case bar(double damping) {
  StructureBody b = body("bar", {0, 0, 0}, {20, 4, 0}, 1);
  b.poisson_ratio = 0;
  b.mass_damping = damping;
  Case c = scene(2, {b});
  const Shape region = box({-1, -1, 0}, {1, 5, 0});
  c.structure->clamps.push_back({"root", "bar", region, std::nullopt});
  c.structure->bodies[0].clamps.push_back(region);
  return c;
}

LoadCase load_on_the_end(LoadCase::Kind kind) {
  LoadCase load;
  load.kind = kind;
  load.name = "pull";
  load.body = "bar";
  load.region = box({19.9, -1, 0}, {21, 5, 0});
  return load;
}

/// Runs to `until` in windows of ten sub-steps.
template <int D>
void run(Structure<D>& structure, double until) {
  while (seconds(structure.time()) < until) structure.trial(structure.time(), to_ticks(10 * structure.largest_sub_step()));
}

// u = s L/E from the face of the clamp on, reaction -s A, moment about the middle of the bar zero. Seen to fail: with the
// reaction of the opposite sign; with the load on the last layer of particles, 0.4 spacings of the length too far.
TEST(Traction, StretchesABarAsHookeSaysAndIsHeldByTheClamp) {
  Case c = bar(5);
  c.structure->bodies[0].spacing = 0.5;
  c.structure->loads.push_back(load_on_the_end(LoadCase::Kind::traction));
  c.structure->loads[0].value[0] = Expression("100");
  Structure<2> structure(c);
  run(structure, 10);
  const double tip = structure.displacement(structure.material_point("bar", {20, 2, 0}))[0];
  RecordProperty("tip_error", std::to_string(tip / (100.0 * 19 / 1e6) - 1));
  EXPECT_NEAR(tip, 100.0 * 19 / 1e6, 0.004 * 1.9e-3);
  const Reaction reaction = structure.reaction("bar", "root", {0, 2, 0});
  EXPECT_NEAR(reaction.force[0], -400, 1e-4 * 400);
  EXPECT_NEAR(reaction.force[1], 0, 1e-4 * 400);
  EXPECT_NEAR(reaction.moment[2], 0, 1e-3 * 400);
  EXPECT_NEAR(structure.reaction("bar", "", {0, 0, 0}).moment[2], 2 * 400, 1e-3 * 400);
  EXPECT_THROW(structure.reaction("bar", "other", {0, 0, 0}), BadInput);
}

// A region loads what of the body is in it, whatever the particles. Seen to fail: with whole particles (72 for 64.8, 60 for 55.5
// and nothing for 2.4 N/m).
TEST(BodyForce, OfARegionIsThatOfItsVolume) {
  const auto total = [](Case c) {  // momentum of the free bar over the time
    c.structure->clamps.clear();
    c.structure->bodies[0].clamps.clear();
    Structure<2> structure(c);
    const Ticks window = to_ticks(structure.largest_sub_step());
    structure.trial(0, window);
    double sum = 0;
    for (const Vector<2>& velocity : structure.fields().velocity) sum += 1000 * velocity[0];
    return sum / seconds(window);
  };
  const auto load = [](double from, double to, double bottom, double top) {
    LoadCase made = load_on_the_end(LoadCase::Kind::body_force);
    made.region = box({from, bottom, 0}, {to, top, 0});
    made.value[0] = Expression("3");
    return made;
  };
  for (const auto& [from, to, bottom, top] : {std::array{10.4, 15.8, -1.0, 5.0}, {10.0, 15.0, -1.0, 3.7}, {7.1, 7.3, -1.0, 5.0}}) {
    Case c = bar(0);
    c.structure->loads.push_back(load(from, to, bottom, top));
    const double expected = 3 * (to - from) * (std::min(top, 4.0) - std::max(bottom, 0.0));
    EXPECT_NEAR(total(c), expected, 1e-9 * expected) << from;
  }
}

// A pressure all round a free body has neither force nor moment and compresses it: in plane strain the strain is
// -p (1 - nu - 2 nu^2)/E in both directions, however few particles it is across. Seen to fail: with the force along the normal instead
// of against it; with the load on the particles behind the faces alone (the thinnest by 0.28 of the strain).
TEST(Pressure, OnAFreeBodyCompressesItWithoutMovingIt) {
  for (const double half : {6.0, 2.0, 1.0}) {
    StructureBody b = body("block", {-6, -half, 0}, {6, half, 0}, 1);
    b.mass_damping = 8;
    Case c = scene(2, {b});
    add_load(c, LoadCase::Kind::pressure, "block", Expression(1000.0));
    Structure<2> structure(c);
    run(structure, 8);
    const Momentum momentum = structure.momentum();
    EXPECT_NEAR(momentum.linear[0], 0, 1e-6);
    EXPECT_NEAR(momentum.angular[2], 0, 1e-6);
    const double strain = -1000 * (1 - 0.3 - 2 * 0.09) / 1e6;
    const auto fields = structure.fields();
    double mean = 0;
    for (const double j : fields.jacobian) mean += (j - 1) / static_cast<double>(fields.jacobian.size());
    EXPECT_NEAR(mean, 2 * strain, 0.002 * 2 * std::abs(strain)) << half;
  }
}

// A pressure follows the surface: on the end of a bar that has been turned by a right angle it presses along the bar. Seen to
// fail: with the normals of the undeformed surface.
TEST(Pressure, TurnsWithTheSurface) {
  StructureBody b = body("bar", {0, 0, 0}, {8, 4, 0}, 1);
  b.velocity[0] = Expression("-0.5*(y-2)");
  b.velocity[1] = Expression("0.5*(x-4)");
  Case c = scene(2, {b});
  c.structure->loads.push_back(load_on_the_end(LoadCase::Kind::pressure));
  c.structure->loads[0].region = box({7.9, -1, 0}, {9, 5, 0});
  c.structure->loads[0].value[0] = Expression("t < pi ? 0 : 100");  // 0.5 rad/s turn it by a right angle in pi s
  Structure<2> structure(c);
  while (seconds(structure.time()) < std::numbers::pi) structure.trial(structure.time(), to_ticks(5 * structure.largest_sub_step()));
  const Momentum before = structure.momentum();
  const double begin = seconds(structure.time());
  structure.trial(structure.time(), to_ticks(5 * structure.largest_sub_step()));
  const double impulse = 400 * (seconds(structure.time()) - begin);
  EXPECT_NEAR(structure.momentum().linear[1] - before.linear[1], -impulse, 0.03 * impulse);
  EXPECT_NEAR(structure.momentum().linear[0] - before.linear[0], 0, 0.05 * impulse);
}

// Seen to fail: with the load per particle instead of per volume.
TEST(BodyForce, EqualsTheWeightOfTheSameDensity) {
  Case heavy = bar(0), loaded = bar(0);
  for (Case* c : {&heavy, &loaded}) c->structure->bodies[0].spacing = 0.5;
  heavy.gravity[1] = Expression(-2.0);
  LoadCase load;
  load.kind = LoadCase::Kind::body_force;
  load.body = "bar";
  load.value[1] = Expression(-2000.0);
  loaded.structure->loads.push_back(load);
  Structure<2> a(heavy), b(loaded);
  const Ticks window = to_ticks(20 * a.largest_sub_step());
  for (int n = 0; n < 5; ++n) {
    a.trial(n * window, window);
    b.trial(n * window, window);
  }
  const auto fa = a.fields(), fb = b.fields();
  for (std::size_t p = 0; p < fa.displacement.size(); ++p) EXPECT_LT((fa.displacement[p] - fb.displacement[p]).norm(), 1e-12);
  EXPECT_NEAR(a.energies().potential, -b.energies().load_work, 1e-9 * std::abs(a.energies().potential));
}

// Clamp and bar begin at the same velocity: nothing pulls. Seen to fail: with a clamp that is at rest until the first window (84 000 N/m).
TEST(Reaction, IsNothingAtTheStartOfABarThatMovesAsItsClamp) {
  Case c = bar(0);
  RigidMotion motion;
  motion.displacement[0] = Expression("2*t");
  c.structure->clamps[0].motion = motion;
  c.structure->bodies[0].velocity[0] = Expression("2");
  const Structure<2> structure(c);
  EXPECT_NEAR(structure.reaction("bar", "root", {0, 0, 0}).force[0], 0, 1e-3);
}

/// The bar whose clamp is turned by a right angle about the origin and then stays.
Case turned_bar(double damping) {
  Case c = bar(damping);
  c.structure->bodies[0].young_modulus = 4e6;
  RigidMotion motion;
  motion.rotation = Expression("t < 4 ? pi/4*(1-cos(pi*t/4)) : pi/2");
  c.structure->clamps[0].motion = motion;
  return c;
}

// Seen to fail: with the particles of the clamp held.
TEST(MovingClamp, TakesTheBodyWithIt) {
  Structure<2> structure(turned_bar(1.4));
  run(structure, 20);
  const Vector<2> d = structure.displacement(structure.material_point("bar", {20, 2, 0}));
  EXPECT_NEAR(20 + d[0], -2, 0.02);
  EXPECT_NEAR(2 + d[1], 20, 0.02);
}

// A clamp whose acceleration sets in gently, under implicit steps of a fortieth of the slowest vibration: what holds the bar is its mass
// times that. A clamp of one velocity through every step is off its place between the ends, and pushes with the stiffness of a spacing.
// Seen to fail: with the clamp aimed at the end of the whole step in the first part of an implicit step; at that of the window in all
// sub-steps.
TEST(MovingClamp, HoldsAnAcceleratedBarByItsMass) {
  for (const Integrator integrator : {Integrator::implicit_steps, Integrator::explicit_steps}) {
    Case c = bar(0);
    c.structure->numerics.integrator = integrator;
    RigidMotion motion;
    motion.displacement[0] = Expression("t < 12 ? 0.5*(t^2/2 + 144/pi^2*(cos(pi*t/12)-1)) : 36 - 144/pi^2 + 6*(t-12) + 0.5*(t-12)^2");
    c.structure->clamps[0].motion = motion;
    Structure<2> structure(c);
    const Ticks window = to_ticks(0.1);
    double largest = 0;
    for (Ticks t = 0; seconds(t) < 18; t += window) {
      structure.trial(t, window);
      const double off = structure.reaction("bar", "", {0, 0, 0}).force[0] / (1000 * 19 * 4) - 1;
      if (seconds(t) > 12.5) largest = std::max(largest, std::abs(off));
    }
    EXPECT_LT(largest, 0.012) << "implicit: " << (integrator == Integrator::implicit_steps);
    std::printf("[ %s: %.4f of the mass times the acceleration off at most ]\n",
                integrator == Integrator::implicit_steps ? "implicit" : "explicit", largest);
  }
}

// Balance of all accounts with a clamp that moves, a traction, a pressure and damping. Seen to fail: without the work of the
// clamp and of the loads, and without the damping.
TEST(Energy, BalanceClosesWithLoadsDampingAndAMovingClamp) {
  Case c = turned_bar(0.3);
  c.structure->loads.push_back(load_on_the_end(LoadCase::Kind::traction));
  c.structure->loads[0].value[1] = Expression("20000*sin(t)");
  c.structure->loads.push_back(load_on_the_end(LoadCase::Kind::pressure));
  c.structure->loads[1].value[0] = Expression("20000");
  Structure<2> structure(c);
  double largest = 0, worst = 0;
  while (seconds(structure.time()) < 5) {
    structure.trial(structure.time(), to_ticks(4 * structure.largest_sub_step()));
    const Energies e = structure.energies();
    largest = std::max(largest, e.kinetic + e.strain);
    worst = std::max(worst, std::abs(e.kinetic + e.strain + e.diffusion + e.damping - e.load_work - e.clamp_work));
  }
  const Energies e = structure.energies();
  EXPECT_LT(worst, 2e-3 * largest);
  EXPECT_GT(std::abs(e.load_work), 0.02 * largest);
  EXPECT_GT(std::abs(e.clamp_work), 0.1 * largest);
  EXPECT_GT(e.damping, 0.02 * largest);
}

/// A shell of 4 x 90 mm above its clamp, loaded as a whole until it rests: what holds it.
Reaction of_loaded_shell(LoadCase::Kind kind, const char* value) {
  Case c = plate();
  StructureBody& body = c.structure->bodies[0];
  body.is_shell = true;
  body.spacing = 0.01;
  body.mass_damping = 60;
  LoadCase load;
  load.kind = kind;
  load.body = "plate";
  load.region = box({0.59, 1e-6, 0}, {0.598, 0.0899, 0});  // its left face
  if (kind == LoadCase::Kind::body_force) load.region.reset();
  load.value[0] = Expression(value);
  c.structure->loads.push_back(load);
  Structure<2> structure(c);
  const Ticks window = to_ticks(5e-3);
  for (Ticks t = 0; seconds(t) < 0.8; t += window) structure.trial(t, window);
  return structure.reaction("plate", "", {0.598, 0, 0});
}

// All of the load, also that on the half cell beside the clamp, whose particle is held. Seen to fail: with the internal forces of the held
// particle alone (5.3 % are missing).
TEST(Reaction, OfAShellBearsAllOfItsLoad) {
  EXPECT_NEAR(of_loaded_shell(LoadCase::Kind::traction, "2").force[0], -0.18, 1e-4 * 0.18);
  EXPECT_NEAR(of_loaded_shell(LoadCase::Kind::body_force, "500").force[0], -0.18, 1e-4 * 0.18);
  EXPECT_NEAR(of_loaded_shell(LoadCase::Kind::traction, "2").moment[2], 0.5 * 0.09 * 0.18, 0.01 * 0.5 * 0.09 * 0.18);
}

}  // namespace
}  // namespace tern::structure::testing
