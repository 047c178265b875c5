// Shells as bodies of a case: windows, energies, surface points, gauges.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "fixtures/structure_scenes.hpp"
#include "scene/mid_surface.hpp"
#include "structure/shell/shell_body.hpp"
#include "structure/surface_points.hpp"

namespace tern::structure::testing {
namespace {

/// The plate of the dam break as a shell of about 18 particles.
Case shell_plate() {
  Case c = plate();
  StructureBody& body = c.structure->bodies[0];
  body.is_shell = true;
  body.spacing = 0.09 / 18.5;
  return c;
}

/// The same in 3D, 48 mm wide, without Poisson's ratio, so that it bends as a strip does.
Case shell_strip() {
  StructureBody b = body("plate", {0.596, -0.010, 0}, {0.600, 0.090, 0.048}, 0.006);
  b.density = 1161.54;
  b.young_modulus = 3.5e6;
  b.poisson_ratio = 0;
  b.clamps = {box({0.59, -0.02, -0.01}, {0.61, 0, 0.06})};
  b.is_shell = true;
  return scene(3, {b});
}

template <int D>
double first_frequency(Case c) {
  c.structure->bodies[0].velocity[0] = Expression("0.003*(cosh(20.83449*y)-cos(20.83449*y)-0.7340955*(sinh(20.83449*y)-sin(20.83449*y)))");
  Structure<D> structure(c);
  const auto tip = structure.material_point("plate", {0.598, 0.089, 0.024});
  const Ticks window = to_ticks(1e-3);
  const double energy = structure.energies().kinetic;
  std::vector<double> times;
  double before = 0;
  for (Ticks t = 0; seconds(t) < 0.6; t += window) {
    structure.trial(t, window);
    const Energies e = structure.energies();
    EXPECT_NEAR(e.kinetic + e.strain + e.diffusion, energy, 1e-3 * energy);
    const double now = structure.displacement(tip)[0];
    if (before * now < 0) times.push_back(seconds(t) + seconds(window) * before / (before - now));
    before = now;
  }
  return 0.5 * static_cast<double>(times.size() - 1) / (times.back() - times.front());
}

// Euler and Bernoulli: 4.9035 Hz with E/(1 - 0.45^2), 4.3789 Hz with E.
TEST(ShellBody, SwingsAtTheFrequencyOfThinPlateTheoryAndKeepsItsEnergy) {
  EXPECT_NEAR(first_frequency<2>(shell_plate()), 4.9035, 0.003 * 4.9035);
  EXPECT_NEAR(first_frequency<3>(shell_strip()), 4.3789, 0.005 * 4.3789);
}

/// A free, bent strip that spins and swings.
template <int D>
Case spinning_strip() {
  Case c = D == 2 ? shell_plate() : shell_strip();
  StructureBody& body = c.structure->bodies[0];
  body.clamps.clear();
  body.velocity[0] = Expression("8*(y-0.04)+3*cos(40*y)");
  body.velocity[1] = Expression("-8*(x-0.598)");
  return c;
}

/// Largest difference of energy with and without what the viscosity has taken, over the first.
template <int D>
void expect_kept_when_spinning() {
  const Case c = spinning_strip<D>();
  Structure<D> structure(c);
  const Energies first = structure.energies();
  const Momentum before = structure.momentum();
  const Ticks window = to_ticks(1e-3);
  for (Ticks t = 0; seconds(t) < 0.2; t += window) structure.trial(t, window);
  const Energies last = structure.energies();
  const Momentum after = structure.momentum();
  EXPECT_GT(last.diffusion, 1e-4 * first.kinetic);
  EXPECT_NEAR(last.kinetic + last.strain + last.diffusion, first.kinetic + first.strain, 1e-4 * first.kinetic);
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(after.linear[a], before.linear[a], 1e-12 * std::abs(before.linear[0]));
    EXPECT_NEAR(after.angular[a], before.angular[a], 1e-12 * std::abs(before.angular[2]));
  }
}

// Seen to fail: with twice the viscous power.
TEST(ShellBody, AFreeSpinningStripKeepsItsMomentaAndLosesWhatTheViscosityTakes) {
  expect_kept_when_spinning<2>();
  expect_kept_when_spinning<3>();
}

/// Uniform body force across the plate, until it has come to rest.
template <int D>
void expect_static_reaction(Case c, double width) {
  c.structure->bodies[0].mass_damping = 60;
  c.gravity[0] = Expression("0.1");
  Structure<D> structure(c);
  const Ticks window = to_ticks(5e-3);
  for (Ticks t = 0; seconds(t) < 0.8; t += window) structure.trial(t, window);
  const double load = 1161.54 * 0.004 * 0.09 * width * 0.1;
  const Reaction held = structure.reaction("plate", "", {0.598, 0, 0});
  const double free = load * (1 - 0.5 / 18.5);  // the face particles have no weight; bounds of it
  EXPECT_NEAR(held.force[0], -load, load - free + 0.04 * load);
  EXPECT_NEAR(held.moment[2], 0.045 * load, 0.05 * 0.045 * load);
}

// Seen to fail: without the couple of the clamp the moment about its face is 0.
TEST(ShellBody, AClampBearsTheForceAndTheMomentOfTheLoad) {
  expect_static_reaction<2>(shell_plate(), 1);
  expect_static_reaction<3>(shell_strip(), 0.048);
}

/// Power of forces on the surface points against that of what the particles get, in a bent state.
template <int D>
void expect_power(const Case& c) {
  const Reference<D> reference = build_reference<D>(*c.structure);
  const SurfaceAttachment<D> attachment = attach_surface(reference, c);
  State<D> state = state_at_rest(reference, attachment.row.size());
  Workspace<D> work = workspace_for(reference);
  set_rows<D>(reference, state.displacement, [](const Vector<D>& x) {
    Vector<D> d = Vector<D>::Zero();
    d[0] = 20 * x[1] * x[1];
    d[1] = -3 * x[1] * x[1] + 0.1 * x[D - 1] * x[1];
    return d;
  });
  set_rows<D>(reference, state.velocity, [](const Vector<D>& x) {
    Vector<D> v = Vector<D>::Zero();
    v[0] = std::sin(40 * x[1]);
    v[1] = std::cos(30 * x[1]);
    v[D - 1] += 7 * x[1];
    return v;
  });
  deformation_gradient(reference, state, work);
  const auto velocity = surface_velocity(attachment, reference, state, work);
  const auto before = present_surface(attachment, reference, state, work).position;
  RowVectors<D> force;
  for (auto& axis : force) axis.assign(reference.rows, 0);
  double power = 0, scale = 0;
  for (std::size_t k = 0; k < velocity.size(); ++k) {
    Vector<D> f = Vector<D>::Constant(0.3);
    f[0] = std::cos(1.0 + static_cast<double>(k));
    if (attachment.clamp[k] >= 0) continue;
    add_point_force<D>(attachment, reference, work, k, f, force);
    power += f.dot(velocity[k]);
    scale += f.norm() * velocity[k].norm();
  }
  for (int a = 0; a < D; ++a)
    for (const auto row : reference.particle_row) power -= force[a][row] * state.velocity[a][row];
  EXPECT_LT(std::abs(power), 1e-14 * scale);
  constexpr double dt = 1e-7;
  drift(reference, dt, state);
  deformation_gradient(reference, state, work);
  const auto after = present_surface(attachment, reference, state, work).position;
  for (std::size_t k = 0; k < velocity.size(); ++k)
    if (attachment.clamp[k] < 0) {
      EXPECT_LT(((after[k] - before[k]) / dt - velocity[k]).norm(), 1e-4) << k;
    }
}

TEST(ShellBody, ForcesOnItsFacesHaveThePowerOfTheirPoints) {
  expect_power<2>(shell_plate());
  expect_power<3>(shell_strip());
}

// Of a body that is free all round, one held at one edge, and one held at two edges that meet.
template <int D>
void expect_the_same_particles(StructureBody body, const std::vector<Shape>& clamps) {
  for (std::size_t held = 0; held <= clamps.size(); ++held) {
    body.clamps.assign(clamps.begin(), clamps.begin() + static_cast<std::ptrdiff_t>(held));
    const ShellParticles<D> particles = shell_particles_of<D>(body);
    const LatticePoints<D> points = fill_body<D>(body);
    ASSERT_EQ(points.size(), particles.position.size()) << held << " clamps";
    std::size_t i = 0;
    for (const Vector<D>& x : points) {
      EXPECT_LT((x - particles.position[i]).norm(), 1e-14) << i;
      const auto holds = [&](const Shape& clamp) { return contains<D>(clamp, x); };
      EXPECT_EQ(std::any_of(body.clamps.begin(), body.clamps.end(), holds), particles.held[i]) << i;
      ++i;
    }
  }
}

// Seen to fail: with cells that divide the whole box, and without the half spacing at a held edge.
TEST(ShellBody, HasTheParticlesThatItsCaseIsCheckedWith) {
  expect_the_same_particles<2>(shell_plate().structure->bodies[0],
                               {box({0.59, -0.02, 0}, {0.61, 0, 0}), box({0.59, 0.08, 0}, {0.61, 0.1, 0})});
  expect_the_same_particles<3>(shell_strip().structure->bodies[0],
                               {box({0.59, -0.02, -0.01}, {0.61, 0, 0.06}), box({0.59, -0.02, 0.04}, {0.61, 0.1, 0.06})});
}

TEST(ShellBody, OtherThanABoxHeldAtAWholeEdgeIsRefused) {
  StructureBody of = shell_strip().structure->bodies[0];
  of.clamps = {box({0.59, -0.02, -0.01}, {0.61, 0, 0.024})};
  EXPECT_THROW(mid_surface<3>(of), BadInput);
  of = shell_plate().structure->bodies[0];
  of.shape.kind = Shape::Kind::ball;
  EXPECT_THROW(mid_surface<2>(of), BadInput);
}

}  // namespace
}  // namespace tern::structure::testing
