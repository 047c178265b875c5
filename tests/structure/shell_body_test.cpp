// Shells as bodies of a case: windows, energies, surface points, gauges.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "base/error.hpp"
#include "fixtures/structure_scenes.hpp"
#include "scene/shell_sampling.hpp"
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

/// Under a uniform body force across the plate, and damped, so that it comes to rest.
Case pushed_across(Case c) {
  c.structure->bodies[0].mass_damping = 60;
  c.gravity[0] = Expression("0.1");
  return c;
}

template <int D>
void come_to_rest(Structure<D>& structure) {
  const Ticks window = to_ticks(5e-3);
  for (Ticks t = 0; seconds(t) < 0.8; t += window) structure.trial(t, window);
}

template <int D>
void expect_static_reaction(const Case& c, double width) {
  Structure<D> structure(pushed_across(c));
  come_to_rest(structure);
  const double load = 1161.54 * 0.004 * 0.09 * width * 0.1;
  const Reaction held = structure.reaction("plate", "", {0.598, 0, 0});
  EXPECT_NEAR(held.force[0], -load, 1e-6 * load);
  EXPECT_NEAR(held.moment[2], 0.045 * load, 0.01 * 0.045 * load);
}

// Seen to fail: without the couple of the clamp the moment about its face is 0; without the weight of the half cells beside the clamp.
TEST(ShellBody, AClampBearsTheForceAndTheMomentOfTheLoad) {
  expect_static_reaction<2>(shell_plate(), 1);
  expect_static_reaction<3>(shell_strip(), 0.048);
}

/// The plate, or the strip, held at its lower end by a clamp or a hinge and at its upper end by a hinge with a name.
template <int D>
Case propped(Case c, bool clamped) {
  StructureBody& body = c.structure->bodies[0];
  const Shape top = box({0.59, 0.09, -0.01}, {0.606, 0.095, 0.06});
  if (!clamped) {
    body.shape.min[1] = 0;
    body.clamps = body.hinges = {box({0.59, -0.015, -0.01}, {0.606, 0.001, 0.06})};
  }
  body.hinges.push_back(top);
  body.clamps.push_back(top);
  c.structure->clamps = {{"top", "plate", top, {}, true}};
  return c;
}

template <int D>
void expect_propped(const Case& c, double width, bool clamped) {
  Structure<D> structure(pushed_across(propped<D>(c, clamped)));
  come_to_rest(structure);
  const double load = 1161.54 * 0.004 * 0.09 * width * 0.1;
  const Reaction top = structure.reaction("plate", "top", {0.598, 0.09, 0}), all = structure.reaction("plate", "", {0.598, 0.09, 0});
  const double lost = 0.5 / 15 * load;  // what stands on a held edge has no weight
  EXPECT_NEAR(top.force[0], -(clamped ? 0.375 : 0.5) * load, lost);
  EXPECT_NEAR(top.moment[2], 0, 1e-6 * 0.09 * load);
  EXPECT_NEAR(all.force[0], -load, 2 * lost + 1e-4 * load);  // as far as it rests
  // The clamp bears q L^2/8; two hinges bear no couple.
  EXPECT_NEAR(all.moment[2] - 0.09 * all.force[0] + 0.09 * top.force[0], (clamped ? 0.125 : 0) * 0.09 * load, 0.02 * 0.09 * load);
}

// Seen to fail: with a hinge that holds the slope.
TEST(ShellBody, AHingeBearsAForceAndNoMoment) {
  for (const bool clamped : {true, false}) {
    expect_propped<2>(shell_plate(), 1, clamped);
    expect_propped<3>(shell_strip(), 0.048, clamped);
  }
}

/// A strip that hangs from a hinge and swings by a small angle.
template <int D>
double period_of_pendulum(Case c) {
  StructureBody& body = c.structure->bodies[0];
  body.shape.min[1] = 0;
  body.clamps = body.hinges = {box({0.59, 0.09, -0.01}, {0.606, 0.095, 0.06})};
  body.young_modulus = 3.5e7;
  if (D == 3) c.structure->numerics.integrator = Integrator::implicit_steps;  // sub-steps would take a minute
  body.velocity[0] = Expression("(0.09-y)*0.2");
  c.gravity[1] = Expression("-9.81");
  Structure<D> structure(c);
  const auto tip = structure.material_point("plate", {0.598, 0.001, 0.024});
  const Ticks window = to_ticks(2e-3);
  double before = 0, first = 0, last = 0;
  int count = 0;
  for (Ticks t = 0; seconds(t) < 0.8; t += window) {
    structure.trial(t, window);
    const double now = structure.displacement(tip)[0];
    if (before * now < 0) {
      last = seconds(t) + seconds(window) * before / (before - now);
      if (count++ == 0) first = last;
    }
    before = now;
  }
  return 2 * (last - first) / (count - 1);
}

// 2 pi sqrt(2 L/(3 g)) = 0.4915 s.
TEST(ShellBody, SwingsFromAHingeAsAPendulum) {
  EXPECT_NEAR(period_of_pendulum<2>(shell_plate()), 0.4915, 0.003 * 0.4915);
  EXPECT_NEAR(period_of_pendulum<3>(shell_strip()), 0.4915, 0.003 * 0.4915);
}

/// The plate, or the strip, whose clamp turns by 0.4 rad and back and moves up meanwhile, a swing of two first periods.
template <int D>
Case waved(Case c) {
  StructureCase& structure = *c.structure;
  RigidMotion motion;
  motion.rotation = Expression("0.2*(1-cos(15.7*t))");
  motion.displacement[1] = Expression("0.01*(1-cos(15.7*t))");
  motion.pivot = {0.598, 0, 0};
  structure.clamps = {{"hand", "plate", structure.bodies[0].clamps[0], motion}};
  return c;
}

/// Place of the tip every 10 ms of 0.4 s; the account of energy is closed all the time.
template <int D>
std::vector<Vector<D>> path_of_tip(const Case& c, const std::array<double, 3>& tip) {
  Structure<D> structure(c);
  const auto point = structure.material_point("plate", tip);
  std::vector<Vector<D>> path;
  double most = 0;
  for (int n = 1; n <= 400; ++n) {
    structure.trial(structure.time(), to_ticks(1e-3));
    const Energies e = structure.energies();
    most = std::max(most, e.kinetic + e.strain);
    EXPECT_NEAR(e.kinetic + e.strain + e.diffusion, e.clamp_work, 3e-3 * most) << n;
    if (n % 10 == 0) path.push_back(structure.displacement(point));
  }
  return path;
}

/// Largest distance of the paths over the longest way.
template <int D>
double distance(const std::vector<Vector<D>>& one, const std::vector<Vector<D>>& other) {
  double largest = 0, way = 0;
  for (std::size_t n = 0; n < one.size(); ++n) {
    largest = std::max(largest, (one[n].template head<2>() - other[n].template head<2>()).norm());
    way = std::max(way, one[n].norm());
  }
  return largest / way;
}

// Against the solid of four particles across, and in 3D against the line of the same strip. Seen to fail: with the slope of the clamp
// that stays, and without the work of its couple in the account.
TEST(ShellBody, AClampThatTurnsWavesItAsItWavesASolid) {
  const std::array<double, 3> tip{0.598, 0.0885, 0.024};
  Case solid = plate();
  const auto by_solid = path_of_tip<2>(waved<2>(solid), tip);
  EXPECT_LT(distance<2>(path_of_tip<2>(waved<2>(shell_plate()), tip), by_solid), 0.02);
  Case line = shell_plate();
  line.structure->bodies[0].poisson_ratio = 0;
  const auto by_strip = path_of_tip<3>(waved<3>(shell_strip()), tip);
  std::vector<Vector<2>> in_plane;
  for (const auto& d : by_strip) in_plane.emplace_back(d[0], d[1]);
  EXPECT_LT(distance<2>(in_plane, path_of_tip<2>(waved<2>(line), tip)), 0.01);
}

// The account of implicit windows closes with their length: to 3.1, 1.2 and 0.37 % of the largest energy in windows of 1, 0.5 and
// 0.25 ms. Seen to fail: with the work of the couple of the clamp left out.
TEST(ShellBody, AClampThatTurnsWavesItInImplicitStepsToo) {
  const auto by_explicit_steps = path_of_tip<2>(waved<2>(shell_plate()), {0.598, 0.0885, 0});
  Case c = waved<2>(shell_plate());
  c.structure->numerics.integrator = Integrator::implicit_steps;
  Structure<2> structure(c);
  const auto point = structure.material_point("plate", {0.598, 0.0885, 0});
  std::vector<Vector<2>> path;
  double most = 0, off = 0;
  for (int n = 1; n <= 1600; ++n) {
    structure.trial(structure.time(), to_ticks(0.25e-3));
    const Energies e = structure.energies();
    most = std::max(most, e.kinetic + e.strain);
    off = std::max(off, std::abs(e.kinetic + e.strain - e.clamp_work));
    if (n % 40 == 0) path.push_back(structure.displacement(point));
  }
  EXPECT_LT(off, 5e-3 * most);
  EXPECT_LT(distance<2>(path, by_explicit_steps), 5e-3);
}

/// Forces on the rows of a body that its clamp has turned and moved as a whole and carries on round, bent and stretched along y by
/// `bend` y^2 [1/m].
template <int D>
RowVectors<D> forces_in_a_turned_body(const Case& c, double bend, double viscous_time) {
  Reference<D> reference = build_reference<D>(*c.structure);
  reference.shells[0].viscous_time = viscous_time;
  State<D> state = state_at_rest(reference, 0);
  Workspace<D> work = workspace_for(reference);
  const Placement<D> placed = placement<D>(*reference.clamps[0].motion, 0.1);
  state.clamp_angle[0] = placed.angle;
  state.clamp_spin[0] = 1.7;
  for (const auto row : reference.particle_row) {
    const Vector<D> x = reference.position_of(row), bent = x + bend * x[1] * x[1] * (Vector<D>::Unit(0) + Vector<D>::Unit(1));
    const Vector<D> velocity = turning_velocity<D>(1.7, reference.clamps[0].motion->axis, placed.turn * (bent - placed.pivot));
    for (int a = 0; a < D; ++a) {
      state.displacement[a][row] = placed(bent)[a] - x[a];
      state.velocity[a][row] = velocity[a];
    }
  }
  evaluate(reference, state, work);
  return state.internal_force;
}

/// Largest difference of two, over E t.
template <int D>
double largest_difference(const RowVectors<D>& one, const RowVectors<D>& other) {
  double largest = 0;
  for (int a = 0; a < D; ++a)
    for (std::size_t row = 0; row < one[a].size(); ++row) largest = std::max(largest, std::abs(one[a][row] - other[a][row]));
  return largest / (3.5e6 * 0.004);
}

template <int D>
void expect_no_force_when_carried_round(const Case& c) {
  RowVectors<D> none = forces_in_a_turned_body<D>(c, 0, 0);
  for (auto& axis : none) std::fill(axis.begin(), axis.end(), 0.0);
  EXPECT_LT(largest_difference<D>(forces_in_a_turned_body<D>(c, 0, 1e-3), none), 1e-11);
  EXPECT_LT(largest_difference<D>(forces_in_a_turned_body<D>(c, 3, 1e-3), forces_in_a_turned_body<D>(c, 3, 0)), 1e-11);
  EXPECT_GT(largest_difference<D>(forces_in_a_turned_body<D>(c, 3, 0), none), 1e-4);
}

// Seen to fail: with the slope of the clamp that stays, and, where it is bent, without the rate of the clamp's normal.
TEST(ShellBody, FeelsNoViscosityWhereItsClampCarriesItRoundAsAWhole) {
  expect_no_force_when_carried_round<2>(waved<2>(shell_plate()));
  expect_no_force_when_carried_round<3>(waved<3>(shell_strip()));
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

/// The plate rolled up to an arc that is held at one end, or to a ring.
Case shell_arc(bool closed) {
  Case c = shell_plate();
  StructureBody& body = c.structure->bodies[0];
  body.shape.kind = Shape::Kind::ring;
  body.shape.center = {0.598, 0.04};
  body.shape.radius = 0.03;
  body.shape.thickness = 0.004;
  if (!closed) body.shape.end = 2.5;
  body.clamps.clear();
  if (!closed) body.clamps = {box({0.62, 0.03, 0}, {0.635, 0.045, 0})};
  return c;
}

Case shell_tube(bool closed) {
  Case c = shell_strip();
  StructureBody& body = c.structure->bodies[0];
  body.shape.kind = Shape::Kind::tube;
  body.shape.axis = 1;
  body.shape.center = {0.598, 0.04, 0.02};
  body.shape.length = 0.05;
  body.shape.radius = 0.03;
  body.shape.thickness = 0.004;
  if (!closed) body.shape.begin = 0.3, body.shape.end = 2.5;
  body.clamps = {box({0.5, 0, -0.1}, {0.7, 0.02, 0.1})};
  return c;
}

Case shell_ball() {
  Case c = shell_strip();
  StructureBody& body = c.structure->bodies[0];
  Shape outer;
  outer.kind = Shape::Kind::ball;
  outer.center = {0.598, 0.04, 0.02};
  outer.radius = 0.032;
  Shape inner = outer;
  inner.radius = 0.028;
  body.shape = Shape{};
  body.shape.kind = Shape::Kind::difference;
  body.shape.parts = {outer, inner};
  body.clamps.clear();
  return c;
}

TEST(ShellBody, ForcesOnItsFacesHaveThePowerOfTheirPoints) {
  expect_power<2>(shell_plate());
  expect_power<3>(shell_strip());
  for (const bool closed : {false, true}) {
    expect_power<2>(shell_arc(closed));
    expect_power<3>(shell_tube(closed));
  }
  expect_power<3>(shell_ball());
}

/// A floor of a tank of 0.4 m, that reaches 20 mm into its walls, and its clamp ends at three of these; at the fourth it is free.
template <int D>
Case shell_floor() {
  StructureBody b = body("floor", {-0.020, -0.010, -0.020}, {0.420, 0, 0.420}, 0.025);
  b.is_shell = true;
  b.clamps = {box({-1, -1, -1}, {0, 1, 1})};
  if (D == 3) b.clamps.push_back(box({-1, -1, -1}, {1, 1, 0})), b.clamps.push_back(box({-1, -1, 0.4}, {1, 1, 1}));
  Case c = scene(D, {b});
  WallCase tank;
  tank.container = true;
  tank.shape = box({0, -0.5, 0}, {0.4, 0.5, 0.4});
  c.walls.push_back(tank);
  return c;
}

/// Area of its upper face within the walls, and what of it lies in patches that reach past them.
template <int D>
std::array<double, 2> wet_area(const Case& c) {
  std::array<double, 2> area{};
  const SurfacePoints<D> points = sample_shell_surface<D>(c.structure->bodies[0], c.walls, 0.025);
  for (std::size_t k = 0; k < points.area.size(); ++k) {
    const Vector<D>& x = points.position[k];
    if (points.normal[k][1] < 0.5 || x[0] < 0 || x[0] > 0.4 || (D == 3 && (x[D - 1] < 0 || x[D - 1] > 0.4))) continue;
    area[0] += points.area[k];
    // Half the shortest edge that a patch may have: of narrow ones, a fifth of the spacing.
    if (std::min({x[0], 0.4 - x[0], D == 3 ? x[D - 1] : 1, D == 3 ? 0.4 - x[D - 1] : 1}) < 0.0099) area[1] += points.area[k];
  }
  return area;
}

// The part of a face beyond a wall bears no water. In patches of 25 mm that are not cut, 5 % more or less of this floor would.
// Seen to fail: with the box cut evenly (0.391 m, 0.153 m^2).
TEST(ShellBody, BearsNothingBeyondTheWallsThatItReachesInto) {
  const auto line = wet_area<2>(shell_floor<2>()), square = wet_area<3>(shell_floor<3>());
  std::printf("[ wet: %.15g m, %.15g m^2 ]\n", line[0], square[0]);
  EXPECT_NEAR(line[0], 0.4, 1e-12);
  EXPECT_NEAR(square[0], 0.16, 1e-12);
  EXPECT_EQ(line[1], 0);
  EXPECT_EQ(square[1], 0);
  // What no wall and no clamp passes through is cut as ever.
  Case free = shell_floor<3>();
  free.walls.clear();
  free.structure->bodies[0].clamps.clear();
  const auto& b = free.structure->bodies[0];
  const SurfacePoints<3> even = sample_surface<3>(b.shape, 0.025), points = sample_shell_surface<3>(b, free.walls, 0.025);
  EXPECT_EQ(points.position, even.position);
  EXPECT_EQ(points.area, even.area);
}

/// At rest the surface is that of the shape, also turned and moved as a whole.
template <int D>
void expect_surface_at_rest(const Case& c) {
  const Reference<D> reference = build_reference<D>(*c.structure);
  const SurfaceAttachment<D> attachment = attach_surface(reference, c);
  const Body& body = reference.bodies[0];
  const auto sampled = sample_shell_surface<D>(c.structure->bodies[0], c.walls, body.spacing);
  State<D> state = state_at_rest(reference, attachment.row.size());
  Workspace<D> work = workspace_for(reference);
  Matrix<D> turn = Matrix<D>::Identity();
  turn.template topLeftCorner<2, 2>() = Eigen::Rotation2D<double>(0.7).toRotationMatrix();
  for (const bool turned : {false, true}) {
    const Matrix<D> r = turned ? turn : Matrix<D>(Matrix<D>::Identity());
    set_rows<D>(reference, state.displacement, [&](const Vector<D>& x) { return Vector<D>(r * x - x); });
    deformation_gradient(reference, state, work);
    const Surface<D> surface = present_surface(attachment, reference, state, work);
    std::size_t found = 0;
    for (std::size_t k = 0; k < surface.position.size(); ++k) {
      if (attachment.clamp[k] >= 0) continue;
      double nearest = 1;
      std::size_t which = 0;
      for (std::size_t j = 0; j < sampled.position.size(); ++j)
        if (const double distance = (r * sampled.position[j] - surface.position[k]).norm(); distance < nearest)
          nearest = distance, which = j;
      ++found;
      ASSERT_LT(nearest, 1e-12) << k;
      EXPECT_LT((r * sampled.normal[which] - surface.normal[k]).norm(), 1e-11);
      EXPECT_NEAR(surface.area[k], sampled.area[which], 1e-11 * sampled.area[which]);
    }
    EXPECT_GE(found, 29u);
  }
}

// Seen to fail: with the gradient as of a flat reference.
TEST(ShellBody, ItsSurfaceAtRestIsThatOfItsShape) {
  expect_surface_at_rest<2>(shell_plate());
  expect_surface_at_rest<3>(shell_strip());
  for (const bool closed : {false, true}) {
    expect_surface_at_rest<2>(shell_arc(closed));
    expect_surface_at_rest<3>(shell_tube(closed));
  }
  expect_surface_at_rest<3>(shell_ball());
}

/// Loads of a unit pressure on one face of a shell at rest about the origin: what each of its particles bears.
template <int D>
std::vector<Vector<D>> loads_on_a_face(const Case& c, bool inner) {
  const Reference<D> reference = build_reference<D>(*c.structure);
  const SurfaceAttachment<D> attachment = attach_surface(reference, c);
  const ShellLayer<D>& layer = reference.shells[0].layer;
  ShellWork<D> rest;
  rest.x = layer.particles.position;
  rest.derivatives = layer.reference;
  std::vector<Vector<D>> loads(layer.size(), Vector<D>::Zero());
  for (std::size_t k = 0; k < attachment.row.size(); ++k) {
    if (attachment.on_shell[k] < 0 || (attachment.normal[k].dot(reference.position_of(attachment.row[k])) < 0) != inner) continue;
    if (std::abs(attachment.shell[k].z) < 0.499 * layer.thickness) continue;  // an end
    spread_force<D>(layer, rest, attachment.shell[k], -attachment.area[k] * attachment.normal[k],
                    [&](std::size_t j, const Vector<D>& share) { loads[j] += share; });
  }
  return loads;
}

// The particles of a ring bear the same under a uniform pressure, on its inner and on its outer face, with as many points as particles and
// with more. Seen to fail: with faces cut by their own lengths they bear 0.73 to 1.25 of the mean.
TEST(ShellBody, ParticlesOfARingBearAUniformPressureAlike) {
  StructureBody ring = body("ring", {}, {}, 0.01);
  ring.is_shell = true;
  ring.shape.kind = Shape::Kind::ring;
  ring.shape.radius = 0.1, ring.shape.thickness = 0.005;
  for (const double fluid_spacing : {0.0, 0.015}) {
    Case c = scene(2, {ring});
    if (fluid_spacing > 0) {
      c.fluid.emplace();
      c.fluid->spacing = fluid_spacing;
    }
    for (const bool inner : {false, true}) {
      const auto loads = loads_on_a_face<2>(c, inner);
      ASSERT_EQ(loads.size(), 63u);
      const double mean = 2 * std::numbers::pi * (inner ? 0.0975 : 0.1025) / 63;
      Vector<2> sum = Vector<2>::Zero();
      for (const auto& load : loads) {
        EXPECT_NEAR(load.norm(), mean, 2e-3 * mean);  // the chords of the pieces
        sum += load;
      }
      EXPECT_LT(sum.norm(), 1e-12);
    }
  }
}

// The particles of a ball bear a uniform pressure by their areas, on both faces, with as many points as particles, with some in each
// triangle, and with many. Seen to fail: with faces in bands of latitude of their own.
TEST(ShellBody, ParticlesOfABallBearAUniformPressureByTheirAreas) {
  StructureBody ball = body("ball", {}, {}, 0.018);
  ball.is_shell = true;
  ball.shape.kind = Shape::Kind::difference;
  for (const double radius : {0.102, 0.098}) {
    Shape& part = ball.shape.parts.emplace_back();
    part.kind = Shape::Kind::ball;
    part.radius = radius;
  }
  for (const double fluid_spacing : {0.0, 0.02, 0.008}) {
    Case c = scene(3, {ball});
    if (fluid_spacing > 0) {
      c.fluid.emplace();
      c.fluid->spacing = fluid_spacing;
    }
    const auto cells = cells_of(mid_surface<3>(ball));
    double largest = 0, squared = 0;
    for (const bool inner : {false, true}) {
      const auto loads = loads_on_a_face<3>(c, inner);
      ASSERT_EQ(loads.size(), cells.size());
      const double of_face = std::pow(inner ? 0.98 : 1.02, 2) * (inner ? 1 : -1);
      Vector<3> sum = Vector<3>::Zero();
      for (std::size_t i = 0; i < loads.size(); ++i) {
        const Vector<3> wrong = (loads[i] - of_face * cells[i].area * cells[i].place.frame.col(2)) / cells[i].area;
        largest = std::max(largest, wrong.norm());
        squared += wrong.squaredNorm() / static_cast<double>(2 * loads.size());
        sum += loads[i];
      }
      EXPECT_LT(sum.norm(), 1e-12);
    }
    std::printf("[ fluid %g m: %.2g of the load at most, %.2g in the mean ]\n", fluid_spacing, largest, std::sqrt(squared));
    EXPECT_LT(largest, fluid_spacing > 0 ? 0.11 : 1e-9);  // the largest beside the particles that have five neighbours
    EXPECT_LT(std::sqrt(squared), fluid_spacing > 0 ? 0.02 : 1e-9);
  }
}

// A bent line, clamped at one end: every free particle has one point on both faces. Beside the clamp is half a cell more. Seen to fail:
// with faces cut by their own lengths.
TEST(ShellBody, EveryParticleOfALineHasItsOwnPartOfBothFaces) {
  StructureBody line = body("line", {}, {}, 0.01);
  line.is_shell = true;
  line.shape.kind = Shape::Kind::line;
  line.shape.thickness = 0.004;
  for (int n = 0; n <= 40; ++n) {
    const double angle = 0.05 * n;
    line.shape.vertices.push_back({0.1 * std::cos(angle), 0.1 * std::sin(angle)});
  }
  line.clamps = {box({0.09, -0.01, 0}, {0.11, 0.013, 0})};
  const Case c = scene(2, {line});
  const Reference<2> reference = build_reference<2>(*c.structure);
  const SurfaceAttachment<2> attachment = attach_surface(reference, c);
  std::vector<std::array<int, 2>> points(reference.rows);
  for (std::size_t k = 0; k < attachment.row.size(); ++k)
    if (attachment.on_shell[k] >= 0 && std::abs(attachment.shell[k].z) > 0.499 * 0.004)
      ++points[attachment.row[k]][attachment.shell[k].z > 0];
  for (const auto row : reference.particle_row)
    if (reference.inverse_mass[row] > 0 && reference.position[1][row] > 0.025) {
      EXPECT_EQ(points[row], (std::array<int, 2>{1, 1})) << row;
    }
}

// The clamp ends the arc where its face at y = 0.045 cuts the mid-surface, the tube 5 mm from its end.
TEST(ShellBody, ClampsEndWhatIsBentWhereTheyEnd) {
  const MidSurface<2> arc = mid_surface<2>(shell_arc(false).structure->bodies[0]);
  EXPECT_EQ(arc.edges[0][0], EdgeKind::clamp);
  EXPECT_EQ(arc.edges[0][1], EdgeKind::free);
  EXPECT_NEAR(arc.low[0], 0.03 * std::asin(0.005 / 0.03), 1e-9);
  const MidSurface<3> tube = mid_surface<3>(shell_tube(true).structure->bodies[0]);
  EXPECT_EQ(tube.edges[0][0], EdgeKind::clamp);
  EXPECT_NEAR(tube.low[0], 0.005, 1e-9);
  EXPECT_TRUE(tube.closed[1]);
  StructureBody pinned = shell_arc(false).structure->bodies[0];
  pinned.clamps = pinned.hinges = {box({0.62, 0.03, 0}, {0.635, 0.0405, 0})};
  EXPECT_EQ(mid_surface<2>(pinned).edges[0][0], EdgeKind::hinge);
  pinned.clamps = {box({0.58, 0.06, 0}, {0.59, 0.07, 0})};  // in its middle
  pinned.hinges.clear();
  EXPECT_THROW(mid_surface<2>(pinned), BadInput);
}

// Half a circle of straight pieces, with a corner in the middle between two particles. Seen to fail: with 0.01 of the thickness for how far
// the parabola of a particle may be beside it.
TEST(ShellBody, APointOnACornerOfALineIsFound) {
  Case c = shell_plate();
  StructureBody& body = c.structure->bodies[0];
  body.shape.kind = Shape::Kind::line;
  body.shape.thickness = 0.002;
  body.shape.vertices.clear();
  for (int k = 0; k <= 10; ++k)
    body.shape.vertices.push_back({0.05 * std::cos(0.1 * k * std::numbers::pi), 0.05 * std::sin(0.1 * k * std::numbers::pi)});
  body.clamps.clear();
  for (const double spacing : {0.004, 0.0042, 0.0044, 0.0046, 0.0048, 0.005}) {
    body.spacing = spacing;
    Structure<2> structure(c);
    for (std::size_t k = 1; k < 10; ++k) {
      const auto& corner = body.shape.vertices[k];
      const MaterialPoint point = structure.material_point("plate", {corner[0], corner[1], 0});
      EXPECT_NEAR(std::accumulate(point.weight.begin(), point.weight.end(), 0.0), 1, 1e-12) << spacing << ' ' << k;
    }
  }
}

// Of a body that is free all round, one held at one edge, and one held at two edges that meet.
template <int D>
void expect_the_same_particles(StructureBody body, const std::vector<Shape>& clamps) {
  for (std::size_t held = 0; held <= clamps.size(); ++held) {
    body.clamps.assign(clamps.begin(), clamps.begin() + static_cast<std::ptrdiff_t>(held));
    const ShellParticles<D> particles = shell_particles(mid_surface<D>(body));
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
  expect_the_same_particles<2>(shell_arc(false).structure->bodies[0], {box({0.62, 0.03, 0}, {0.635, 0.045, 0})});
  expect_the_same_particles<3>(shell_tube(true).structure->bodies[0], {box({0.5, 0, -0.1}, {0.7, 0.02, 0.1})});
  expect_the_same_particles<3>(shell_ball().structure->bodies[0], {});
}

TEST(ShellBody, AHingeThatMovesTakesItsEdgeAlongAndItsWorkIsCounted) {
  Case c = shell_plate();
  StructureBody& body = c.structure->bodies[0];
  body.shape.min[1] = 0;
  const Shape low = box({0.59, -0.01, 0}, {0.606, 0.001, 0});
  body.clamps = body.hinges = {low};
  RigidMotion motion;
  motion.displacement[0] = Expression("0.02*(1-cos(20*t))");
  motion.rotation = Expression("0.5*(1-cos(20*t))");
  motion.pivot = {0.598, 0, 0};
  c.structure->clamps = {{"hand", "plate", low, motion, true}};
  c.gravity[1] = Expression("9.81");  // it hangs upwards
  Structure<2> structure(c);
  double most = 0;
  for (int n = 1; n <= 300; ++n) {
    structure.trial(structure.time(), to_ticks(1e-3));
    const Energies e = structure.energies();
    most = std::max(most, e.kinetic + e.strain);
    EXPECT_NEAR(e.kinetic + e.strain + e.potential + e.diffusion, e.clamp_work, 3e-3 * most) << n;
  }
  const auto edge = structure.material_point("plate", {0.598, 0, 0});
  EXPECT_NEAR(structure.displacement(edge)[0], 0.02 * (1 - std::cos(20 * 0.3)), 1e-6);
  EXPECT_NEAR(structure.reaction("plate", "hand", {0.598 + structure.displacement(edge)[0], 0, 0}).moment[2], 0, 1e-9);
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
