// Structure as the coupling uses it: windows, loads, accounts, failures.

#include <gtest/gtest.h>
#include <omp.h>

#include <cstring>

#include "base/error.hpp"
#include "fixtures/structure_scenes.hpp"

namespace tern::structure::testing {
namespace {

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}

template <int D>
bool same_state(const Structure<D>& a, const Structure<D>& b) {
  const auto fa = a.fields(), fb = b.fields();
  const Energies ea = a.energies(), eb = b.energies();
  return same_bits(fa.position, fb.position) && same_bits(fa.velocity, fb.velocity) && same_bits(fa.stress, fb.stress) &&
         std::memcmp(&ea, &eb, sizeof ea) == 0;
}

SurfaceLoad<2> pressure_from_the_left(const Structure<2>& structure, double pressure) {
  SurfaceLoad<2> load;
  const auto surface = structure.surface();
  for (std::size_t k = 0; k < surface.position.size(); ++k)
    load.force.push_back(surface.normal[k][0] < -0.5 ? Vector<2>(pressure * surface.area[k], 0.0) : Vector<2>(0.0, 0.0));
  return load;
}

const Ticks window = to_ticks(1e-4);

// Seen to fail: with displacement, force and time restored but velocities and energy accounts not.
TEST(Window, RepeatedUnderAnotherLoadEqualsOneDoneOnce) {
  Structure<2> once(plate()), twice(plate());
  for (int n = 0; n < 3; ++n) {
    const auto load = pressure_from_the_left(once, 100.0 + n), other = pressure_from_the_left(once, -500);
    once.trial(n * window, window);
    once.advance(load);
    twice.trial(n * window, window);
    twice.advance(other);
    twice.advance(load);
    ASSERT_TRUE(same_state(once, twice)) << "window " << n;
  }
  EXPECT_EQ(once.time(), 3 * window);
  EXPECT_GT(once.energies().kinetic, 0);
}

// Seen to fail: with no load in trial() instead of the last one.
TEST(Window, KeepsItsTrialStateWhenTheLoadIsTheSame) {
  Structure<2> kept(plate()), redone(plate());
  const auto load = pressure_from_the_left(kept, 100), other = pressure_from_the_left(kept, 50);
  for (int n = 0; n < 2; ++n) {
    kept.trial(n * window, window);
    kept.advance(load);
    redone.trial(n * window, window);
    redone.advance(other);
    redone.advance(load);
  }
  EXPECT_TRUE(same_state(kept, redone));
}

// Seen to fail: with the sub-steps done all the same (the count); with a body that counts as at rest for ever.
TEST(Window, IsPassedOverWhileNothingHasMovedOrLoadedTheBody) {
  Structure<2> structure(plate());
  const SurfaceLoad<2> nothing{std::vector<Vector<2>>(structure.surface_points(), Vector<2>::Zero())};
  const auto at_start = structure.fields().position;
  Ticks now = 0;
  const auto advance = [&](const SurfaceLoad<2>& load) {
    structure.trial(now, window);
    structure.advance(load);
    now += window;
  };
  for (int n = 0; n < 3; ++n) advance(nothing);
  EXPECT_EQ(structure.evaluations().windows_at_rest, 3);
  EXPECT_TRUE(same_bits(structure.fields().position, at_start));
  EXPECT_EQ(structure.time(), now);
  advance(pressure_from_the_left(structure, 100));
  for (int n = 0; n < 3; ++n) advance(nothing);
  EXPECT_EQ(structure.evaluations().windows_at_rest, 4) << "the trial of the loaded window, and none after it";
  EXPECT_GT(structure.energies().kinetic + structure.energies().strain, 0);
  EXPECT_EQ(structure.time(), now);

  Case falls = plate();
  falls.gravity[1] = Expression(-1.0);
  Structure<2> falling(falls);
  falling.trial(0, window);
  EXPECT_EQ(falling.evaluations().windows_at_rest, 0) << "its weight acts on it";
}

// 80 x 80 particles are enough blocks for the parallel loops. Seen to fail: with energy accounts that several
// blocks share.
TEST(Window, HasTheSameBitsForOneAndTwoThreads) {
  StructureBody b = body("block", {0, 0, 0}, {80, 80, 0}, 1);
  b.velocity[0] = Expression("sin(0.1*x)*cos(0.2*y)");
  const Case c = scene(2, {b});
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  Structure<2> one(c);
  one.trial(0, to_ticks(5 * one.largest_sub_step()));
  omp_set_num_threads(2);
  Structure<2> two(c);
  two.trial(0, to_ticks(5 * two.largest_sub_step()));
  omp_set_num_threads(before);
  EXPECT_TRUE(same_state(one, two));
}

// Seen to fail: without counting the diffusion, and with the work of gravity counted as that of the load.
TEST(Energy, BalanceClosesUnderLoadAndGravity) {
  Case c = plate();
  c.gravity[0] = Expression("20*cos(300*t)");
  c.gravity[1] = Expression(-9.81);
  c.structure->numerics.courant = 0.15;  // what sub-steps miss of the energy of a sudden load falls with their length
  Structure<2> structure(c);
  double largest = 0;
  for (int n = 0; n < 30; ++n) {
    structure.trial(n * window, window);
    structure.advance(pressure_from_the_left(structure, 2000 * std::sin(0.3 * n)));
    const Energies e = structure.energies();
    largest = std::max(largest, e.kinetic + e.strain);
    EXPECT_LT(std::abs(e.kinetic + e.strain + e.potential + e.diffusion - e.interface_work), 1e-3 * largest);
    EXPECT_GE(e.diffusion, 0);
  }
  EXPECT_GT(structure.energies().interface_work, 0);
}

// The coupler counts f . u with the velocities of the surface points. Seen to fail: with the velocity of another particle.
TEST(Energy, InterfaceWorkIsThatOfTheSurfaceVelocities) {
  Structure<2> structure(plate());
  const auto load = pressure_from_the_left(structure, 100);
  structure.trial(0, window);
  structure.advance(load);
  const Ticks short_window = to_ticks(2e-7);
  const double before = structure.energies().interface_work;
  structure.trial(window, short_window);
  structure.advance(load);
  const auto surface = structure.surface();
  double power = 0;
  for (std::size_t k = 0; k < surface.velocity.size(); ++k) power += load.force[k].dot(surface.velocity[k]);
  const double work = structure.energies().interface_work - before;
  EXPECT_NEAR(work, power * seconds(short_window), 1e-2 * work);
}

// Seen to fail: with the stabilising force added at one end of the pairs only.
TEST(Momentum, OfAFreeBodyIsKept) {
  StructureBody b = body("block", {0, 0, 0}, {10, 12, 0}, 1);
  b.velocity[0] = Expression("sin(x)+0.3*y");
  b.velocity[1] = Expression("cos(2*y)-0.3*x");
  Case c = scene(2, {b});
  c.structure->numerics.riemann_diffusion = 0;
  Structure<2> structure(c);
  const Momentum before = structure.momentum();
  structure.trial(0, to_ticks(200 * structure.largest_sub_step()));
  const Momentum after = structure.momentum();
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(after.linear[a], before.linear[a], 1e-12 * 120e3);
    EXPECT_NEAR(after.angular[a], before.angular[a], 1e-11 * 120e3);
  }
}

// Two bodies that touch. Seen to fail: with the neighbours of the second looked up
// in the rows of the first.
TEST(Bodies, DoNotSeeEachOther) {
  StructureBody moving = body("moving", {0, 0, 0}, {6, 7, 0}, 1), still = body("still", {6, 0, 0}, {9, 7, 0}, 0.5);
  moving.velocity[0] = Expression("sin(y)");
  Structure<2> structure(scene(2, {moving, still}));
  structure.trial(0, to_ticks(50 * structure.largest_sub_step()));
  const auto fields = structure.fields();
  double moved = 0;
  for (std::size_t p = 0; p < fields.body.size(); ++p) {
    if (fields.body[p] == 0) {
      moved += fields.displacement[p].norm();
    } else {
      ASSERT_EQ(fields.displacement[p].norm(), 0) << p;
    }
  }
  EXPECT_GT(moved, 0);
}

// Seen to fail: without the check the run goes on with not-a-number in every field.
TEST(Failure, NamesParticlePlaceTimeAndRemedy) {
  Structure<2> structure(plate());
  try {
    for (int n = 0; n < 50; ++n) {
      structure.trial(n * window, window);
      structure.advance(pressure_from_the_left(structure, 3e7));
    }
    FAIL() << "survived";
  } catch (const NumericalFailure& error) {
    for (const char* part :
         {"particle", "'plate'", "J = det F", " m has ", "at t = ", "Refine", "must stay positive", "its stress", "Likely cause"})
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

// Seen to fail: with Shepard weights (no linear part) the corner is off by 0.06.
TEST(MaterialPoint, FollowsALinearFieldExactlyOutsideTheParticlesToo) {
  StructureBody b = body("block", {0, 0, 0}, {6, 7, 0}, 1);
  b.velocity[0] = Expression("0.5+0.1*x-0.2*y");
  Structure<2> structure(scene(2, {b}));
  const auto corner = structure.material_point("block", {6, 7, 0});
  const Ticks dt = to_ticks(1e-6);  // so short that no force acts: d = v dt
  structure.trial(0, dt);
  EXPECT_NEAR(structure.displacement(corner)[0] / seconds(dt), 0.5 + 0.6 - 1.4, 1e-6);
  EXPECT_THROW(structure.material_point("block", {6.01, 0, 0}), BadInput);
  EXPECT_THROW(structure.material_point("other", {1, 1, 0}), BadInput);
}

// What check accepts: the corner of a block that its lattice does not fill is 1.41 spacings from the nearest particle, and 2.2 from the
// next ones. Seen to fail: with points farther than a spacing from the particles refused; with a kernel as wide everywhere.
TEST(MaterialPoint, IsFoundAtACornerThatNoParticleIsNearTo) {
  StructureBody b = body("block", {0, 0, 0}, {5.499, 5.499, 0}, 1);
  b.velocity[0] = Expression("0.5+0.1*x-0.2*y");
  Structure<2> structure(scene(2, {b}));
  const auto corner = structure.material_point("block", {5.499, 5.499, 0});
  const auto edge = structure.material_point("block", {3, 5.499, 0});
  const Ticks dt = to_ticks(1e-6);
  structure.trial(0, dt);
  EXPECT_NEAR(structure.displacement(corner)[0] / seconds(dt), 0.5 - 0.5499, 1e-5);
  EXPECT_NEAR(structure.displacement(edge)[0] / seconds(dt), 0.5 + 0.3 - 1.0998, 1e-5);
}

}  // namespace
}  // namespace tern::structure::testing
