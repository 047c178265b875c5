// Bodies from light to heavy, thin to thick and soft to stiff under the algorithm that is taken by default; all combinations
// are in ./tern extremes.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>
#include <optional>

#include "fixtures/coupled_scenes.hpp"

namespace tern::coupler::testing {
namespace {

using Verdict = CoupledOutcome::Verdict;

/// All that take part in a scene.
struct Participants {
  explicit Participants(const Case& c)
      : fluid(c), structure(c), coupled(structure, c.coupling.algorithm), coupler(c, structure.surface_properties()) {}
  fluid::Fluid<2> fluid;
  structure::Structure<2> structure;
  structure::CoupledStructure<2> coupled;
  Coupler<2> coupler;
};

// Seen to fail: with one pass by the masses of the formula for light bodies; with the velocity of the structure at the end of a window
// taken as it is; the last, with changes of earlier windows that are new by 1e-3 made use of.
TEST(Stability, IsBoundedByDefaultFromLightToHeavy) {
  for (const CoupledScene& s : {CoupledScene{0.01, 4, 1e7, 2},
                                {0.01, 8, 1e5, 1},
                                {0.1, 4, 1e7, 1},
                                {0.1, 4, 1e5, 2},
                                {1, 4, 1e7, 2},
                                {10, 4, 1e9, 1},
                                {0.1, 2, 1e5, 2}}) {
    SCOPED_TRACE(describe(s));
    const CoupledOutcome outcome = run(s, 0.06);
    EXPECT_EQ(outcome.verdict, Verdict::bounded) << outcome.largest_speed << " " << outcome.unrest << " " << outcome.message;
    EXPECT_EQ(outcome.open_windows, 0);
    std::printf("[ %s: speed %.2f sqrt(gH), %.1f trials per window ]\n", describe(s).c_str(), outcome.largest_speed, outcome.trials);
  }
}

// A soft thick plate, whose layers the elastic wave does not cross in a window: the mass by formula, that of one layer, is too much.
// The default learns what answers, and repeats the few windows after which the two sides do not agree. Measured: 1.1 iterations a window.
// Seen to fail: with the mass by formula and no test of the pass.
TEST(Stability, ASoftThickPlateRunsInOnePassAWindowWithTheMassThatItAnswersWith) {
  const CoupledOutcome learnt = run({2.5, 4, 3e4, 1, Coupling::automatic, 0.2}, 0.06);
  EXPECT_EQ(learnt.verdict, Verdict::bounded) << learnt.message;
  std::printf("[ %.3f iterations a window ]\n", learnt.trials);
  EXPECT_LT(learnt.trials, 1.3);
}

// Particles over the end of a light plate fell into it, one after the other, and later out of its sides.
// Seen to fail: with contacts settled by the mass behind the face, as in the explicit coupling.
TEST(Stability, NoWaterFallsIntoTheEndOfALightPlate) {
  const CoupledScene s{0.01, 4, 1e7, 2};
  EXPECT_EQ(inside_plate(s, 0.06), 0);
}

// A particle that touches a held face in one trial and not in the next changes the answer by its impulse. Measured: 4.1 trials a window.
// Seen to fail: with the contacts of the trial before taken out of the load, instead of its own (6.0).
TEST(Stability, ContactsOfALightPlateTakeNoMoreTrialsThanItsPressure) { EXPECT_LT(run({0.01, 4, 1e7, 2}, 0.06).trials, 5); }

// Water that only an elastic plate gives room, and that begins 1 % too dense: its own density is the one to keep, for the plate cannot
// take it all in, and pressure would go on to rise. Seen to fail: with the density source as in open water (19.3 Pa).
TEST(Stability, SealedWaterThatIsTooDenseDoesNotPress) {
  Case c = case_of({1, 4, 1e7, 1, Coupling::automatic, 1, true});
  c.gravity = constant(0, -0.1);
  c.fluid->spacing = 1.005 * water_spacing;
  Participants all(c);
  auto& [fluid, structure, coupled, coupler] = all;
  double largest = 0;
  const Ticks window = to_ticks(1e-3);
  for (int n = 0; n < 20; ++n) {
    run_window<2>(fluid, coupled, coupler, n * window, window);
    largest = std::max(largest, coupler.total_load(0).norm() / tank_width);
  }
  std::printf("[ pressure on the plate: %.3g Pa ]\n", largest);
  EXPECT_LT(largest, 0.5 * water_depth * 1000 * 0.1);  // half the weight of the water, which the plate begins to bear
}

// A body that does not yield ties no level of the pressure either.
// Seen to fail: with what the level does to particles in the equation of every sealed fluid, whether a body yields or not.
TEST(Stability, SealedWaterRoundABodyThatDoesNotYieldIsFound) {
  const Case c = case_of({1, 4, 1e7, 2, Coupling::explicit_staggering, 1, true});
  fluid::Fluid<2> fluid(c);
  structure::Structure<2> structure(c);
  Coupler<2> coupler(c, structure.surface_properties());
  fluid.begin_window(0, to_ticks(1e-3));
  const Surface<2> surface = structure.surface();
  const InterfaceParticles<2> particles = fluid.see_surface(surface);
  fluid.solve_pressure(coupler.first_exchange(0, 1e-3, surface, particles));
  EXPECT_TRUE(fluid.sealed().any);
}

// Seen to fail: with the level tied wherever a body yields.
TEST(Stability, APlateTiesTheLevelOfSealedWaterWhereItIsWetOnOneFace) {
  for (const int wet_faces : {1, 2}) {
    const Case c = case_of({1, 2, 1e7, wet_faces, Coupling::automatic, 1, true});
    Participants all(c);
    auto& [fluid, structure, coupled, coupler] = all;
    const Ticks window = to_ticks(1e-3);
    for (int n = 0; n < 2; ++n) run_window<2>(fluid, coupled, coupler, n * window, window);  // the first shows how the plate answers
    EXPECT_EQ(fluid.sealed().any, wet_faces == 2) << wet_faces;
  }
}

/// Of an elastic plate in a full box in 0.15 s; one that stands on the floor, as a reed, or one that parts the box in two. The box and what
/// it holds of the plate go along it by `way` [m].
struct MotionInBox {
  double most = 0;  ///< of any point of its surface, along the box [m]
  double mean = 0;  ///< of its left face, at the end [m]
};
MotionInBox motion_in_full_box(double fluid_density, double gravity, bool parts, const std::string& velocity,
                               std::optional<double> tolerance = {}, const std::string& way = {}) {
  constexpr double length = 0.3, height = 0.2, left = 0.14, right = 0.15;
  const double top = parts ? height : 0.5 * height;
  Case c = scene(2, 0.01);
  c.end_time = 1;
  c.gravity = constant(0, -gravity);
  c.fluid->density = fluid_density;
  c.coupling.tolerance = tolerance;
  FluidBody before, behind, above;
  before.velocity = behind.velocity = above.velocity = constant(0);
  before.shape = box({0, 0, 0}, {left, height, 0});
  behind.shape = box({right, 0, 0}, {length, height, 0});
  above.shape = box({left, top, 0}, {right, height, 0});
  c.fluid->bodies = {before, behind};
  if (!parts) c.fluid->bodies.push_back(above);
  WallCase wall;
  wall.name = "box";
  wall.container = true;
  wall.shape = box({0, 0, 0}, {length, height, 0});
  c.walls = {wall};
  StructureBody plate;
  plate.name = "plate";
  plate.shape = box({left, -0.02, 0}, {right, parts ? height + 0.02 : top, 0});
  plate.spacing = 0.0025;
  plate.density = 1000;
  plate.young_modulus = 1e6;
  plate.poisson_ratio = 0.3;
  plate.clamps = {box({-1, -1, -1}, {1, 0, 1}), box({-1, height, -1}, {1, 1, 1})};
  plate.velocity = {Expression(velocity), Expression("0"), Expression()};
  c.structure.emplace();
  c.structure->bodies = {plate};
  if (!way.empty()) {
    c.walls[0].motion.emplace().displacement[0] = Expression(way);
    for (std::size_t n = 0; n < 2; ++n) {
      ClampCase clamp;
      clamp.name = n == 0 ? "below" : "above";
      clamp.body = "plate";
      clamp.region = plate.clamps[n];
      clamp.motion = c.walls[0].motion;
      c.structure->clamps.push_back(clamp);
    }
  }
  c.structure->numerics.integrator = Integrator::automatic;
  Participants all(c);
  auto& [fluid, structure, coupled, coupler] = all;
  const Ticks window = to_ticks(1e-3);
  const std::vector<Vector<2>> start = structure.surface().position;
  MotionInBox motion;
  double gone = 0;
  for (int n = 0; n < 150; ++n) {
    run_window<2>(fluid, coupled, coupler, n * window, window);
    const std::vector<Vector<2>> now = structure.surface().position;
    if (!way.empty()) gone = Expression(way)(seconds((n + 1) * window));
    for (std::size_t k = 0; k < now.size(); ++k) motion.most = std::max(motion.most, std::abs(now[k][0] - gone - start[k][0]));
  }
  const Surface<2> end = structure.surface();
  double area = 0;
  for (std::size_t k = 0; k < start.size(); ++k) {
    if (end.normal[k][0] > -0.5) continue;
    area += end.area[k];
    motion.mean += end.area[k] * (end.position[k][0] - gone - start[k][0]);
  }
  motion.mean /= area;
  return motion;
}

// Of the density of the water. Seen to fail: with the level tied wherever a body yields (2e-4 m, and growing).
TEST(Stability, AReedInAFullBoxStaysAtRest) {
  const double moved = motion_in_full_box(1000, 9.81, false, "0").most;
  std::printf("[ %.1e m ]\n", moved);
  EXPECT_LT(moved, 2e-5);
}

// The fluid of two chambers lets the plate between them bend in no way that would make one of them smaller. A plate alone would go 1 mm.
// Seen to fail: with all of the rate of the swept volume taken away at once (in gas its velocity turns round in every window).
TEST(Stability, APlateBetweenTwoFullChambersKeepsTheirVolumes) {
  for (const double density : {1000.0, 1.2}) {
    const MotionInBox moved = motion_in_full_box(density, 0, true, "0.1*sin(pi*max(y,0)/0.2)");
    std::printf("[ %g kg/m^3: %.1e m, in the mean of a face %.1e m ]\n", density, moved.most, moved.mean);
    EXPECT_LT(moved.most, 4e-4) << density;
    EXPECT_LT(std::abs(moved.mean), 1e-5) << density;
  }
}

// The account of the volume counts the way of the walls as that of the faces, from the middle of a window to the next. Seen to fail: with
// the velocity of the walls in this window (2.5e-4 m, and going on).
TEST(Stability, APlateBetweenTwoFullChambersStaysInItsPlaceInABoxThatIsAccelerated) {
  const MotionInBox moved = motion_in_full_box(1000, 0, true, "0", {}, "t^2");
  std::printf("[ %.1e m, in the mean of a face %.1e m ]\n", moved.most, moved.mean);
  EXPECT_LT(moved.most, 6e-5);
  EXPECT_LT(std::abs(moved.mean), 2e-5);
}

/// A lid that is wider than its channel presses water on an elastic pad by 8 mm in 0.2 s and stops. How far the pad has gone after 0.5 s
/// [m], and whether there was a warning that it lags behind while the lid moves.
std::pair<double, bool> pressed_by_lid(double window_s) {
  Case c = scene(2, 0.02);
  c.end_time = 1;
  c.gravity = constant(0, -9.81);
  FluidBody water;
  water.velocity = constant(0);
  water.shape = box({0, 0.2, 0}, {0.1, 0.6, 0});
  c.fluid->bodies = {water};
  WallCase channel, lid;
  channel.name = "channel";
  channel.container = true;
  channel.shape = box({0, 0, 0}, {0.1, 0.7, 0});
  channel.open = {"y_max"};
  lid.name = "lid";
  lid.shape = box({-0.05, 0.6, 0}, {0.15, 0.7, 0});
  lid.motion.emplace().displacement[1] = Expression("t < 0.2 ? -0.008*(3*(t/0.2)^2 - 2*(t/0.2)^3) : -0.008");
  c.walls = {channel, lid};
  StructureBody pad;
  pad.name = "pad";
  pad.shape = box({0, -0.05, 0}, {0.1, 0.2, 0});
  pad.spacing = 0.025;
  pad.density = 1000;
  pad.young_modulus = 1e6;
  pad.poisson_ratio = 0;
  pad.clamps = {box({-1, -1, -1}, {1, 0, 1})};
  c.structure.emplace();
  c.structure->bodies = {pad};
  c.structure->numerics.integrator = Integrator::automatic;
  Participants all(c);
  auto& [fluid, structure, coupled, coupler] = all;
  const Ticks window = to_ticks(window_s);
  for (int n = 0; n < std::lround(0.5 / window_s); ++n) run_window<2>(fluid, coupled, coupler, n * window, window);
  return {structure.displacement(structure.material_point("pad", {0.05, 0.2, 0}))[1], fluid.sealed().warned_of_lag};
}

// Seen to fail: with the weights with which particles see the patches of the lid as they are (-7.3 mm), and with the patches that the
// channel covers (-9.7 mm).
TEST(Stability, APadUnderFullWaterFollowsTheLidThatPressesIt) {
  for (const auto& [window, lags] : {std::pair{4e-3, false}, {2e-2, true}}) {
    const auto [moved, warned] = pressed_by_lid(window);
    std::printf("[ windows of %g s: %.2f mm ]\n", window, 1e3 * moved);
    EXPECT_NEAR(moved, -0.008, 2e-4);
    EXPECT_EQ(warned, lags) << window;
  }
}

/// A piston goes 1 mm into a pipe full of water that an elastic wall closes, or several one behind the other, with as much water between.
/// The volume that the last of them has given way by at the end, over what the piston or the wall before it has pushed in, and the windows
/// of the run, which are as long as they are wanted.
std::pair<double, int> given_way_to_piston(double young_modulus, double gravity, double end, int walls = 1) {
  constexpr double height = 0.1, length = 0.2, thickness = 0.02;
  Case c = scene(2, 0.01);
  c.end_time = end;
  c.gravity = constant(0, -gravity);
  const double last = walls * (length + thickness);
  c.structure.emplace();
  c.structure->numerics.integrator = Integrator::automatic;
  c.fluid->bodies.clear();
  for (int n = 0; n < walls; ++n) {
    const double from = n * (length + thickness), to = from + length;
    FluidBody& water = c.fluid->bodies.emplace_back();
    water.velocity = constant(0);
    water.shape = box({from, 0, 0}, {to, height, 0});
    StructureBody& wall = c.structure->bodies.emplace_back();
    wall.name = fmt::format("wall {}", n);
    wall.shape = box({to, -0.02, 0}, {to + thickness, height + 0.02, 0});
    wall.spacing = 0.005;
    wall.density = 1200;
    wall.young_modulus = young_modulus;
    wall.poisson_ratio = 0.3;
    wall.clamps = {box({-1, -1, -1}, {2, 0, 1}), box({-1, height, -1}, {2, 1, 1})};
  }
  WallCase pipe, piston;
  pipe.name = "pipe";
  pipe.container = true;
  pipe.shape = box({-0.1, 0, 0}, {last + 0.1, height, 0});
  pipe.open = {"x_min", "x_max"};
  piston.name = "piston";
  piston.shape = box({-0.05, 0, 0}, {0, height, 0});
  piston.motion.emplace().displacement[0] = Expression(fmt::format("0.001*(t < {0} ? (1 - cos(pi*t/{0}))/2 : 1)", 0.5 * end));
  c.walls = {pipe, piston};
  Participants all(c);
  auto& [fluid, structure, coupled, coupler] = all;
  const Surface<2> start = structure.surface();
  StepControl control;
  int windows = 0;
  for (Ticks now = 0; now < to_ticks(end); ++windows) {
    const Ticks window = control.next(coupler.propose(fluid.propose_step().seconds, "").seconds, now, to_ticks(end));
    run_window<2>(fluid, coupled, coupler, now, window);
    now += window;
  }
  const Surface<2> now = structure.surface();
  const auto swept = [&](double face) {  // by the face that was there
    double volume = 0;
    for (std::size_t k = 0; k < start.position.size(); ++k) {
      const Vector<2>& x = start.position[k];
      if (std::abs(x[0] - face) < 1e-9 && x[1] > 0 && x[1] < height) volume += start.area[k] * (now.position[k][0] - x[0]);
    }
    return volume;
  };
  return {swept(last - thickness) / (walls == 1 ? 0.001 * height : swept(last - thickness - length)), windows};
}

// However stiff the wall is, water has nowhere else to go. Windows of water at rest are long beside the motion of a stiff wall: it answers
// as one of a thousand times its mass. Seen to fail: with 0.02 of what has been pushed in given back, whether it lasts or not (0.93 to 0.95
// of the volume without gravity); with a hundred times the guess as the heaviest (3025 windows for steel).
TEST(Stability, AWallGivesWayAsFarAsAPistonPressesWaterAgainstIt) {
  for (const auto& [young_modulus, gravity] : {std::pair{1e7, 0.0}, {1e9, 0.0}, {2e11, 9.81}}) {
    const auto [share, windows] = given_way_to_piston(young_modulus, gravity, 1);
    std::printf("[ E %.0e Pa, g %.2f m/s^2: %.3f of the volume, %d windows ]\n", young_modulus, gravity, share, windows);
    EXPECT_NEAR(share, 1, 0.02) << young_modulus;
    EXPECT_LT(windows, 400) << young_modulus;
  }
}

// The water between two walls lets the second one follow the first, which alone has water on both faces and ties no level. Seen to fail:
// with lumps of both taken for those of one body where a point has no share in one of them (-0.5).
TEST(Stability, AWallBehindAnotherGivesWayAsFarAsAPistonPressesWaterAgainstThem) {
  const auto [share, windows] = given_way_to_piston(1e9, 9.81, 1, 2);
  std::printf("[ %.3f of the volume, %d windows ]\n", share, windows);
  EXPECT_NEAR(share, 1, 0.02);
}

/// Angle [rad] by which a free body, 0.2 m wide, has turned in a full vessel, and the time that has passed [s], after `windows` that grow
/// by a tenth each, from 1 ms to the `longest` [s]. At the start it spins at `spin` [rad/s], and all along `swirl` [1/s^2] times its mass
/// turns it on.
std::pair<double, double> turned_in_full_vessel(double spacing, Shape body_shape, double density, double spin, double swirl, double longest,
                                                int windows) {
  constexpr double radius = 0.3;
  Case c = scene(2, spacing);
  c.end_time = 10;
  c.gravity = constant(0);
  Shape vessel, around;
  vessel.kind = Shape::Kind::ball;
  vessel.radius = radius;
  around.kind = Shape::Kind::difference;
  around.parts = {vessel, body_shape};
  FluidBody water;
  water.velocity = constant(0);
  water.shape = around;
  c.fluid->bodies = {water};
  WallCase wall;
  wall.name = "vessel";
  wall.container = true;
  wall.shape = vessel;
  c.walls = {wall};
  StructureBody body;
  body.name = "body";
  body.shape = std::move(body_shape);
  body.spacing = 0.5 * spacing;
  body.density = density;
  body.young_modulus = 1e8;
  body.poisson_ratio = 0.3;
  body.velocity = {Expression(fmt::format("-{}*y", spin)), Expression(fmt::format("{}*x", spin)), Expression()};
  c.structure.emplace();
  c.structure->bodies = {body};
  LoadCase load;
  load.name = "swirl";
  load.body = "body";
  load.kind = LoadCase::Kind::body_force;
  load.value = {Expression(fmt::format("-{}*y", density * swirl)), Expression(fmt::format("{}*x", density * swirl)), Expression("0")};
  if (swirl > 0) c.structure->loads = {load};
  c.structure->numerics.integrator = Integrator::automatic;
  Participants all(c);
  auto& [fluid, structure, coupled, coupler] = all;
  const auto point = structure.material_point("body", {0.09, 0, 0});
  Ticks now = 0, window = to_ticks(1e-3);
  double turned = 0, before = 0;
  for (int n = 0; n < windows; ++n) {
    run_window<2>(fluid, coupled, coupler, now, window);
    now += window;
    window = std::min(window + window / 10, to_ticks(longest));
    const Vector<2> moved = structure.displacement(point);
    const double angle = std::atan2(moved[1], 0.09 + moved[0]);
    turned += std::remainder(angle - before, 2 * std::numbers::pi);
    before = angle;
  }
  return {turned, seconds(now)};
}

// A disc sweeps no volume, however long the windows are, and nothing brakes it. Seen to fail: with the surface on the chord of the way in a
// window for the account of the volume (0.27 of the angle); without the ratio of the lengths of windows in the velocity that the fluid
// gets (0.45).
TEST(Stability, ADiscThatSpinsInAFullVesselGoesOnSpinning) {
  Shape disc;
  disc.kind = Shape::Kind::ball;
  disc.radius = 0.1;
  const auto [turned, time] = turned_in_full_vessel(0.02, disc, 3000, 3, 0, 0.015, 70);
  std::printf("[ %.4f rad for %.4f rad ]\n", turned, 3 * time);
  EXPECT_NEAR(turned, 3 * time, 6e-3 * time);
}

// The corners of a square that is turned leave gaps in the water behind them. What faces sweep counts there as everywhere. With windows of
// 5 ms it turns by 0.584. Seen to fail: with the volume counted by the wet share of the faces (0.484).
TEST(Stability, ASquareThatSpinsInAFullVesselIsNotBraked) {
  const auto [turned, time] = turned_in_full_vessel(0.01, box({-0.1, -0.1, 0}, {0.1, 0.1, 0}), 1000, 0, 2, 0.04, 52);
  std::printf("[ %.4f rad after %.4f s ]\n", turned, time);
  EXPECT_NEAR(turned, 0.584, 0.03);
}

// What the level leaves of the rate is that of the first pass, however often the window is repeated.
// Seen to fail: with half of the rate taken away in every pass anew.
TEST(Stability, APlateBetweenTwoFullChambersKeepsTheirVolumesInRepeatedWindows) {
  const MotionInBox once = motion_in_full_box(1000, 0, true, "0.1*sin(pi*max(y,0)/0.2)");
  const MotionInBox often = motion_in_full_box(1000, 0, true, "0.1*sin(pi*max(y,0)/0.2)", 1e-4);
  std::printf("[ one pass: %.2e m, repeated: %.2e m, in the mean of a face %.1e m ]\n", once.most, often.most, often.mean);
  EXPECT_NEAR(often.most, once.most, 0.3 * once.most);
  EXPECT_LT(std::abs(often.mean), 1e-5);
}

// Nothing ties the level of the pressure but the squeezing of the plate. Measured: 2.7 Pa.
TEST(Stability, TheLevelOfSealedWaterRoundALightPlateIsQuiet) {
  const CoupledOutcome outcome = run({0.1, 4, 1e7, 2, Coupling::automatic, 1, true}, 0.1);
  EXPECT_EQ(outcome.verdict, Verdict::bounded) << outcome.message;
  EXPECT_LT(outcome.unrest, 0.01);
}

StructureBody ring_shell(const std::array<double, 3>& centre, double radius, double thickness) {
  StructureBody ring;
  ring.name = "ring";
  ring.is_shell = true;
  ring.shape.kind = Shape::Kind::ring;
  ring.shape.center = centre;
  ring.shape.radius = radius;
  ring.shape.thickness = thickness;
  return ring;
}

// Inside a soft shell under water the pressure has every level that it has outside. What pushes the shell is the difference of two large
// loads: what the equation of the fluid has either of them off, and what it has the motion under them off, sets the water around it in
// motion. Measured: 0.005 of the mean in the last 60 windows.
// Seen to fail: with the motion that R has in what is left behind, instead of that which the rows count (turns round at 39 ms).
TEST(Stability, ASoftShellFullOfWaterUnderWaterIsQuiet) {
  constexpr double radius = 0.15, thickness = 0.01, half_width = 0.5, depth = 0.7;
  const auto disc = [](double r) {
    Shape shape;
    shape.kind = Shape::Kind::ball;
    shape.center = {0, 0.5 * depth, 0};
    shape.radius = r;
    return shape;
  };
  Case c = scene(2, 0.0125);
  c.end_time = 1;
  c.gravity = constant(0, -9.81);
  FluidBody inside, outside;
  inside.velocity = outside.velocity = constant(0);
  inside.shape = disc(radius - 0.5 * thickness);
  outside.shape.kind = Shape::Kind::difference;
  outside.shape.parts = {box({-half_width, 0, 0}, {half_width, depth, 0}), disc(radius + 0.5 * thickness)};
  c.fluid->bodies = {outside, inside};
  WallCase wall;
  wall.name = "tank";
  wall.container = true;
  wall.shape = box({-half_width, 0, 0}, {half_width, 1, 0});
  c.walls = {wall};
  StructureBody ring = ring_shell({0, 0.5 * depth, 0}, radius, thickness);
  ring.spacing = 0.0125;
  ring.density = 1000;
  ring.young_modulus = 1e6;
  ring.poisson_ratio = 0.4;
  c.structure.emplace();
  c.structure->bodies = {ring};
  c.structure->numerics.integrator = Integrator::automatic;
  Participants all(c);
  auto& [fluid, structure, coupled, coupler] = all;
  const Ticks window = to_ticks(1.5e-3);
  double sum = 0, squares = 0;
  constexpr int windows = 120, counted = 60;
  for (int n = 0; n < windows; ++n) {
    run_window<2>(fluid, coupled, coupler, n * window, window);
    double pressure = 0;
    int particles = 0;
    for (std::size_t i = 0; i < fluid.state().size(); ++i)
      if ((fluid.state().position[i] - Vector<2>(0, 0.5 * depth)).norm() < 0.5 * radius) pressure += fluid.state().pressure[i], ++particles;
    pressure /= particles;
    if (n < windows - counted) continue;
    sum += pressure;
    squares += pressure * pressure;
  }
  const double mean = sum / counted, unrest = std::sqrt(squares / counted - mean * mean);
  std::printf("[ %.0f +- %.0f Pa ]\n", mean, unrest);
  EXPECT_NEAR(mean, 0.5 * depth * 1000 * 9.81, 0.15 * mean);
  EXPECT_LT(unrest, 0.05 * mean);
  EXPECT_FALSE(fluid.sealed().warned_of_lag);
}

// A thin ring full of water that swings between two ellipses, slowly for the windows, and that is stiff for them along itself. Nothing
// takes from it but the fluid. Measured: 0.43 of its energy is left, and there was never more.
// Seen to fail: with 0.65 of the rate and 0.25 of what has been pushed in taken away (4.5 times the energy).
TEST(Stability, ARingFullOfWaterGainsNoEnergy) {
  constexpr double radius = 0.1, thickness = 0.004;
  Case c = scene(2, 0.0065);
  c.end_time = 10;
  c.gravity = constant(0, 0);
  FluidBody water;
  water.velocity = {Expression("2*x"), Expression("-2*y"), Expression()};
  water.shape.kind = Shape::Kind::ball;
  water.shape.radius = radius - 0.5 * thickness;
  c.fluid->bodies = {water};
  StructureBody ring = ring_shell({}, radius, thickness);
  ring.spacing = 0.006;
  ring.density = 1200;
  ring.young_modulus = 1e8;
  ring.poisson_ratio = 0.3;
  ring.velocity = water.velocity;
  c.structure.emplace();
  c.structure->bodies = {ring};
  c.structure->numerics.integrator = Integrator::automatic;
  Participants all(c);
  auto& [fluid, structure, coupled, coupler] = all;
  const Ticks window = to_ticks(2.8e-3);
  const auto energy = [&, &fluid = fluid, &structure = structure] {
    const structure::Energies of_ring = structure.energies();
    return fluid.energies().kinetic + of_ring.kinetic + of_ring.strain;
  };
  const double start = energy();
  double most = 0, last = 0;
  for (int n = 0; n < 300; ++n) {
    run_window<2>(fluid, coupled, coupler, n * window, window);
    last = energy();
    most = std::max(most, last);
  }
  std::printf("[ %.3f of its energy, at most %.3f ]\n", last / start, most / start);
  EXPECT_LT(most, 1.1 * start);
  EXPECT_LT(last, 0.9 * start);
}

/// Windows that an elastic ring round nothing runs in an annulus of fluid, pushed into an ellipse: all of 40, or less.
long windows_of_ring(double fluid_density) {
  const auto disc = [](double radius) {
    Shape shape;
    shape.kind = Shape::Kind::ball;
    shape.radius = radius;
    return shape;
  };
  const auto between = [&](double inner, double outer) {
    Shape shape;
    shape.kind = Shape::Kind::difference;
    shape.parts = {disc(outer), disc(inner)};
    return shape;
  };
  Case c = scene(2, 0.025);
  c.fluid->density = fluid_density;
  FluidBody annulus;
  annulus.shape = between(1.05, 1.5);
  annulus.velocity = constant(0);
  c.fluid->bodies.push_back(annulus);
  WallCase wall;
  wall.name = "tank";
  wall.container = true;
  wall.shape = disc(1.5);
  c.walls.push_back(wall);
  StructureBody ring;
  ring.name = "ring";
  ring.shape = between(0.95, 1.05);
  ring.spacing = 0.025;
  ring.density = 1000;
  ring.young_modulus = 1e6;
  ring.poisson_ratio = 0.3;
  ring.velocity = {Expression("0.016*x^3"), Expression("-0.016*y^3"), Expression()};
  c.structure.emplace();
  c.structure->bodies.push_back(ring);
  c.structure->numerics.integrator = Integrator::automatic;
  c.coupling.riemann_limiter = 3;
  Participants all(c);
  auto& [fluid, structure, coupled, coupler] = all;
  const Ticks window = to_ticks(0.025);
  try {
    for (int n = 0; n < 40; ++n) run_window<2>(fluid, coupled, coupler, n * window, window);
  } catch (const NumericalFailure& failure) {
    std::printf("[ %s ]\n", failure.what());
    return coupler.state().totals.windows;
  }
  return 40;
}

// A circle cuts the lattice, and the disorder beside it is no free surface. The ring ties the level of the pressure, and answers it with
// all of its mass. Seen to fail: with every deficit above 0.08 taken for a surface.
TEST(Stability, AnElasticRingHoldsTheFluidAroundIt) {
  for (const double density : {14.0, 1400.0}) EXPECT_EQ(windows_of_ring(density), 40) << density << " kg/m^3";
}

// The negative control. Seen to fail: with the Robin condition set for explicit coupling too.
TEST(Stability, IsLostByExplicitCouplingOfALightBody) {
  EXPECT_NE(run({0.1, 4, 1e7, 1, Coupling::explicit_staggering}, 0.06).verdict, Verdict::bounded);
}

}  // namespace
}  // namespace tern::coupler::testing
