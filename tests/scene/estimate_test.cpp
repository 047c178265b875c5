// What a case is foretold to take: steps by all that moves in it, coupling iterations by the lightness of its bodies.

#include "scene/estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "base/error.hpp"
#include "fixtures/scratch_directory.hpp"

namespace tern {
namespace {

Case case_of(const std::string& name, const CaseOptions& options = {}) { return read_case(TERN_SOURCE_DIR "/cases/" + name, options); }

// Also in a tank that is shaken: `sloshing` takes 2662 steps. Seen to fail: with fluid that something is cut out of taken for fluid that is
// free to fall; with water in a tank that moves taken for it (twice the steps).
TEST(Estimate, OfWaterAtRestAroundABodyIsThatOfWaterAtRest) {
  for (const char* name : {"submerged_block", "floating_block", "submerged_block_3d", "rising_disc"}) {
    const Estimate e = estimate(case_of(name));
    EXPECT_TRUE(e.settled) << name;
    const Case c = case_of(name);
    const auto box = c.dimension == 2 ? bounding_box<2>(c.fluid->bodies[0].shape).max[1] : bounding_box<3>(c.fluid->bodies[0].shape).max[1];
    EXPECT_NEAR(e.speed, 0.5 * std::sqrt(9.81 * box), 0.02 * e.speed) << name;
  }
  EXPECT_NEAR(estimate(case_of("sloshing")).steps, 2662, 671);
  EXPECT_FALSE(estimate(case_of("dam_break_plate")).settled);
}

// Held by an obstacle and an elastic body instead of the container, the fluid rests as well; without the obstacle it falls. Seen to fail:
// with the container alone looked at; with nothing looked at; with every body taken to hold; with nothing looked for behind one.
TEST(Estimate, OfWaterThatObstaclesAndBodiesHoldIsThatOfWaterAtRest) {
  Case c = case_of("dam_break_plate");
  EXPECT_FALSE(estimate(c).settled);
  WallCase gate;
  gate.name = "gate";
  gate.shape.min = {0.2, 0, 0}, gate.shape.max = {0.21, 0.6, 0};
  c.walls.push_back(gate);
  const Estimate held = estimate(c);
  EXPECT_TRUE(held.settled);
  EXPECT_LT(held.steps, 0.6 * estimate(case_of("dam_break_plate")).steps);
  c.walls.pop_back();
  StructureBody& body = c.structure->bodies[0];
  body.shape.min = {0.2, -0.01, 0}, body.shape.max = {0.21, 0.5, 0};
  body.clamps[0].min[0] = 0.19, body.clamps[0].max[0] = 0.22;
  EXPECT_FALSE(estimate(c).settled) << "the plate bends away";
  body.young_modulus = 1e12;
  EXPECT_TRUE(estimate(c).settled);
  body.shape.max[1] = 0.3;
  EXPECT_FALSE(estimate(c).settled) << "it runs over";
  body.shape.max[1] = 0.5;
  body.clamps.clear();
  EXPECT_FALSE(estimate(c).settled) << "nothing holds the plate";
  c.fluid->bodies.push_back(c.fluid->bodies[0]);
  c.fluid->bodies[1].shape.min[0] = 0.21, c.fluid->bodies[1].shape.max[0] = 0.8;
  EXPECT_TRUE(estimate(c).settled) << "there is as much behind it";
}

// Seen to fail: with the fluid's own speeds alone; with the largest speed of a wall in place of its mean.
TEST(Estimate, CountsWhatMovesBesidesTheFluid) {
  const Case at_rest = case_of("submerged_block");
  Case c = at_rest;
  c.gravity = {};
  c.structure->bodies[0].velocity = {Expression(0.3), Expression(-0.4), Expression(0.0)};
  EXPECT_NEAR(estimate(c).speed, 0.5, 1e-12);
  EXPECT_NEAR(estimate(c).flow_step, c.fluid->numerics.courant * c.fluid->spacing / 0.5, 1e-12);
  c = at_rest;
  c.gravity = {};
  c.walls[0].motion.emplace();
  c.walls[0].motion->displacement = {Expression("0.2*t^2"), Expression(0.0), Expression(0.0)};  // 0 to 0.8 m/s in 2 s
  EXPECT_NEAR(estimate(c).speed, 0.4, 1e-3);
}

// A tank that is driven with all that is in it takes as long as one at rest; one beside a wall that stays does not. Seen to fail: with the
// speeds to an observer at rest.
TEST(Estimate, GoesAlongWithAScene) {
  const Case at_rest = case_of("submerged_block");
  Case c = at_rest;
  const VectorExpression way = {Expression("30*t"), Expression(0.0), Expression(0.0)};
  const VectorExpression velocity = {Expression(30.0), Expression(0.0), Expression(0.0)};
  for (WallCase& wall : c.walls) wall.motion.emplace().displacement = way;
  for (FluidBody& body : c.fluid->bodies) body.velocity = velocity;
  for (StructureBody& body : c.structure->bodies) {
    body.velocity = velocity, body.clamps.clear();
    ClampCase clamp;
    clamp.body = body.name, clamp.region = body.shape;
    clamp.motion.emplace().displacement = way;
    c.structure->clamps.push_back(clamp);
  }
  EXPECT_NEAR(estimate(c).speed, estimate(at_rest).speed, 1e-9);
  c.walls.push_back(at_rest.walls[0]);
  EXPECT_NEAR(estimate(c).speed, 30, 1e-9);
}

// g H^2/(8 nu) = 0.625 m/s in the middle of a channel, which falling freely reaches after 1.25 of 20 s. Seen to fail: with half of
// sqrt(g H) alone.
TEST(Estimate, KnowsHowFastGravityDrivesAPeriodicChannel) {
  Case c = case_of("taylor_green");
  c.periodic = {true, false, false};
  c.gravity[0] = Expression(0.5);
  c.end_time = 20;
  c.fluid->viscosity = 0.001 * c.fluid->density;
  c.fluid->bodies[0].velocity = {};
  c.fluid->bodies[0].shape.min = {0, 0, 0}, c.fluid->bodies[0].shape.max = {0.1, 0.1, 0};
  c.fluid->spacing = 0.005;
  WallCase floor;
  floor.shape = c.fluid->bodies[0].shape;
  floor.shape.min[1] = -0.1, floor.shape.max[1] = 0;
  c.walls = {floor};
  EXPECT_NEAR(estimate(c).speed, 0.625 * (1 - 1.25 / 40), 1e-3);
  c.walls[0].slip = true;
  EXPECT_NEAR(estimate(c).speed, 5, 1e-9);
}

// A ring that floats keeps the water out of its inside: nothing falls there. Seen to fail with the ring for the shape.
TEST(Estimate, OfAFloatingHullIsThatOfWaterAtRest) {
  Case c = case_of("floating_block");
  Shape& hull = c.structure->bodies[0].shape;
  hull = Shape();
  hull.kind = Shape::Kind::ring;
  hull.center = {0.4, 0.4, 0}, hull.radius = 0.15, hull.thickness = 0.01;
  hull.begin = 0, hull.end = 2 * std::numbers::pi;
  Shape& cut_out = c.fluid->bodies[0].shape.parts[1];
  cut_out.kind = Shape::Kind::ball;
  cut_out.center = hull.center, cut_out.radius = hull.radius + 0.5 * hull.thickness;
  EXPECT_TRUE(estimate(c).settled);
  hull.end = 1.5 * std::numbers::pi;
  EXPECT_FALSE(estimate(c).settled) << "it is open";
}

// 1.8 s of CPU for the shell of `dam_break_plate_3d` in implicit steps to 0.3 s. Seen to fail with the window of a solid in 3D,
// whose factor has neighbours across as well.
TEST(Estimate, KnowsWhatImplicitStepsOfAShellTakeIn3D) {
  const Estimate e = estimate(case_of("dam_break_plate_3d", {{{"structure.numerics.integrator", "implicit"}, {"end_time", "0.3"}}, ""}));
  EXPECT_GT(e.structure_cpu, 1.8 / 1.5);
  EXPECT_LT(e.structure_cpu, 1.8 * 1.5);
}

// A sheet in little water: its points cost more than the particles. In much water it costs no more than the particles hold. Seen to
// fail without the cost of points.
TEST(Estimate, ReckonsWithThePointsOfABodyIn3D) {
  const Case c = case_of("dam_break_plate_3d");
  const Estimate whole = estimate(c);
  Case little = c;
  little.fluid->bodies[0].shape.max = {0.05, 0.05, 0.05};
  const Estimate part = estimate(little);
  ASSERT_LT(part.fluid_particles, whole.fluid_particles / 10);
  const auto a_particle_step = [](const Estimate& of) {
    return of.fluid_cpu / static_cast<double>(of.steps) / static_cast<double>(of.fluid_particles);
  };
  EXPECT_GT(a_particle_step(part), 2 * a_particle_step(whole));
  Case dry = c;
  dry.structure.reset();
  // Fluid without a body takes 0.55 of that.
  EXPECT_NEAR(estimate(dry).fluid_cpu / estimate(dry).steps, 0.55 * whole.fluid_cpu / whole.steps / (1 + 0.4 * (whole.iterations - 1)),
              1e-6);
}

// Of a body of many particles the factor fills up. Seen to fail with the figure of some hundred for all.
TEST(Estimate, KnowsThatImplicitStepsOfManyParticlesTakeMoreThanTheirShare) {
  const Estimate few = estimate(case_of("submerged_block")),
                 many = estimate(case_of("submerged_block", {{{"structure.body.block.spacing", "0.0025"}}, ""}));
  const double particles = static_cast<double>(many.bodies[0].particles) / static_cast<double>(few.bodies[0].particles);
  EXPECT_GT(many.structure_cpu / many.steps, 1.5 * particles * few.structure_cpu / few.steps);
}

// A blade that a small clamp turns is as fast as its ends. Seen to fail with the corners of the clamp alone (0.05 m/s).
TEST(Estimate, CountsTheEndsOfABodyThatItsClampTurns) {
  Case c = case_of("submerged_block");
  c.gravity = {};
  ClampCase hub;
  hub.body = c.structure->bodies[0].name;
  hub.motion.emplace();
  hub.motion->rotation = Expression("t");
  const Bounds<2> bounds = bounding_box<2>(c.structure->bodies[0].shape);
  for (int d = 0; d < 2; ++d) {
    hub.motion->pivot[d] = 0.5 * (bounds.min[d] + bounds.max[d]);
    hub.region.min[d] = hub.motion->pivot[d] - 0.035, hub.region.max[d] = hub.motion->pivot[d] + 0.035;
  }
  c.structure->clamps.push_back(hub);
  EXPECT_NEAR(estimate(c).speed, 0.5 * (bounds.max - bounds.min).norm(), 0.001);
}

// Water about a centre to which gravity draws: the fluid's own measures (fluid/reference.cpp). Seen to fail with gravity in the
// middle, where it is 0: no limit at all.
TEST(Estimate, OfAFieldAboutACentreTakesItsStrongestPlace) {
  Case c = case_of("rotating_square_patch");
  c.gravity = {Expression("-4*x"), Expression("-4*y"), Expression(0.0)};
  c.fluid->bodies[0].velocity = {};
  Shape& disc = c.fluid->bodies[0].shape;
  disc = Shape();
  disc.kind = Shape::Kind::ball;
  disc.radius = 0.5;
  const Estimate e = estimate(c);
  EXPECT_NEAR(e.gravity, 4 * 0.5, 4 * c.fluid->spacing);
  EXPECT_NEAR(e.speed, 0.5 * std::sqrt(e.gravity * 1), 0.02 * e.speed);
  EXPECT_NEAR(e.gravity_step, c.fluid->numerics.gravity_courant * std::sqrt(c.fluid->spacing / e.gravity), 1e-12);
}

// A window does not reach beyond the next frame. Seen to fail: with one step for a scene in which nothing moves yet.
TEST(Estimate, OfASceneAtRestHasAWindowPerFrameAtLeast) {
  Case c = case_of("submerged_block");
  c.gravity = {};
  EXPECT_EQ(estimate(c).steps, std::ceil(c.end_time / c.output.frame_interval));
}

// What runs took, those of plates in splashes. Seen to fail: with one iteration for all; with two for all below half a layer (1 for
// dam_break_plate).
TEST(Estimate, ReckonsWithIterationsForLightBodies) {
  for (const auto& [name, taken] : {std::pair{"dam_break_obstacle", 1.03},
                                    {"hydrostatic_plate", 1.0},
                                    {"piston", 1.0},
                                    {"dam_break_plate", 1.43},
                                    {"dam_break_plate_3d", 1.62},
                                    {"submerged_block", 1.03}})
    EXPECT_NEAR(estimate(case_of(name)).iterations, taken, 0.15 * taken) << name;
  EXPECT_GT(estimate(case_of("submerged_block", {{{"coupling.algorithm", "implicit"}}, ""})).iterations, 1);
  const Estimate heavy = estimate(case_of("rising_disc", {{{"structure.body.disc.density", "1000"}}, ""})),
                 light = estimate(case_of("rising_disc"));
  EXPECT_NEAR(heavy.iterations, 1.07, 0.05);
  EXPECT_GT(light.fluid_cpu, 2 * heavy.fluid_cpu);
}

// What runs took: `./tern run rising_disc --set structure.body.disc.density=...`, and rising_ball_3d at 12.5 mm. A ball of a shell is as
// light as what it keeps the water out of. Seen to fail: with the mass behind the faces alone (2 for a disc of 10, 1 for balls of 100
// to 700).
TEST(Estimate, ReckonsWithTheIterationsOfLooseBodiesThatTheirFluidCarriesOff) {
  const auto iterations = [](const std::string& name, const std::string& body, const char* density) {
    return estimate(case_of(name, {{{"structure.body." + body + ".density", density}}, ""})).iterations;
  };
  for (const auto& [density, taken] : {std::pair{"10", 7.39}, {"100", 3.05}, {"300", 2.35}, {"1000", 1.07}})
    EXPECT_NEAR(iterations("rising_disc", "disc", density), taken, 0.15 * taken) << density;
  for (const auto& [density, taken] : {std::pair{"30", 5.18}, {"100", 3.18}, {"300", 2.18}, {"700", 1.41}, {"1200", 1.13}})
    EXPECT_NEAR(iterations("rising_ball_3d", "ball", density), taken, 0.15 * taken) << density;
  const double whole = 0.05 * 0.05 * 0.05, hollow = 0.045 * 0.045 * 0.045;
  const double displaced = 1000 / 1100.0 * whole / (whole - hollow);
  EXPECT_NEAR(estimate(case_of("ball_drop")).bodies[0].displaced_mass, displaced, 0.05 * displaced);
  EXPECT_EQ(estimate(case_of("dam_break_plate")).bodies[0].displaced_mass, 0);
}

// c_p = sqrt(E (1 - nu)/(rho (1 + nu)(1 - 2 nu))); seen to fail with the plane-stress speed.
TEST(Estimate, IsMadeFromTheStepLimits) {
  const Estimate e = estimate(case_of("dam_break_plate"));
  EXPECT_EQ(e.fluid_particles, 5000);
  ASSERT_EQ(e.bodies.size(), 1u);
  EXPECT_EQ(e.bodies[0].particles, 400);
  EXPECT_EQ(e.bodies[0].clamped, 40);
  EXPECT_EQ(e.bodies[0].surface_points, 184);
  EXPECT_NEAR(e.bodies[0].wave_speed, 106.9, 0.1);
  EXPECT_NEAR(e.bodies[0].sub_step, 2.81e-6, 1e-8);
  EXPECT_NEAR(e.bodies[0].thickness, 0.004, 1e-12);
  EXPECT_NEAR(e.bodies[0].added_mass_ratio, 10.3, 0.1);
  EXPECT_NEAR(e.flow_step, 0.4 * 0.004 / std::sqrt(2 * 9.81 * 0.398), 1e-7);
  EXPECT_TRUE(estimate(case_of("hydrostatic_tank")).settled);
}

// Where a run takes several threads by itself its wall time is less: 0.6 with two, as measured on dam_break_3d. Seen to fail: with the CPU
// time said of any number of cores.
TEST(Estimate, OfTheWallTimeCountsTheThreadsThatARunTakes) {
  Case large = case_of("dam_break_3d");
  const Case small = case_of("dam_break_front");
  large.gauges.clear();  // what they take has costs of its own
  Costs costs;
  costs.fluid *= 100 / estimate(large).fluid_cpu;
  const std::string text = check_text(large, costs, 2);
  EXPECT_NE(text.find("100 s of CPU"), std::string::npos) << text;
  EXPECT_NE(text.find("wall time is about 60 s with 2 threads of the fluid"), std::string::npos) << text;
  EXPECT_EQ(check_text(large, {}, 1).find("threads"), std::string::npos);
  EXPECT_EQ(check_text(small, {}, 2).find("threads"), std::string::npos) << "too few particles for a second one";
}

// A structure alone: a step is a window of at most 100 sub-steps (10 under a load) that ends with an output, as in the run; an
// implicit one costs a window, not a sub-step. tensile_bar has 17 sub-steps between two rows of gauges, in two
// windows; gray_cantilever 109, in two. Seen to fail: with sub-steps counted as steps.
TEST(Estimate, OfAStructureAloneIsInItsWindows) {
  const Case bar = case_of("tensile_bar");
  Estimate e = estimate(bar);
  EXPECT_NEAR(e.steps, 480, 1);
  EXPECT_NEAR(e.step, 5e-5, 1e-12);
  EXPECT_EQ(e.sub_steps, 9);
  EXPECT_NE(check_text(bar).find("about 480 steps"), std::string::npos) << check_text(bar);
  EXPECT_NE(check_text(bar).find(" of the structure in a step, 5e-05 s"), std::string::npos) << check_text(bar);
  e = estimate(case_of("gray_cantilever"));
  EXPECT_NEAR(e.steps, 1600, 1);
  const CaseOptions implicit{.overrides = {{"structure.numerics.integrator", "implicit"}, {"output.gauge_interval", "0"}}, .preset = ""};
  const Estimate by_windows = estimate(case_of("gray_cantilever", implicit));
  EXPECT_LE(by_windows.sub_steps, 100);
  EXPECT_NEAR(by_windows.structure_cpu / e.structure_cpu * e.steps * e.sub_steps, by_windows.steps * implicit_window, 1);
}

// Seen to fail: with the costs of the file read but not used.
TEST(Estimate, TakesTheCostsOfThisMachineWhereTheyAreMeasured) {
  const ScratchDirectory out;
  const std::string path = out / "costs.json";
  std::ofstream(path) << R"({"measured": "2030-01-02", "fluid_s": 4e-6, "structure_s": 1.6e-7, "window_s": 1e-3,
                             "fluid_parts": {"neighbours": 0.25, "pressure_solve": 0.75}})";
  const Case scene = case_of("dam_break_plate");
  const Costs costs = read_costs(path);
  const Estimate typical = estimate(scene), measured = estimate(scene, costs);
  EXPECT_NEAR(measured.fluid_cpu, 2 * typical.fluid_cpu, 1e-9);
  EXPECT_NEAR(measured.structure_cpu, 2 * typical.structure_cpu, 1e-9);
  EXPECT_NEAR(measured.coupler_cpu, 1e-3 * measured.steps, 1e-9);
  EXPECT_EQ(measured.steps, typical.steps);
  EXPECT_NE(explain_text(scene, costs).find("neighbours 25 %, pressure solve 75 %"), std::string::npos) << explain_text(scene, costs);
  EXPECT_NE(explain_text(scene, costs).find("measured on this machine on 2030-01-02"), std::string::npos);
  EXPECT_NE(explain_text(scene).find("typical costs"), std::string::npos);
  EXPECT_EQ(estimate(case_of("hydrostatic_tank"), costs).coupler_cpu, 0);
  std::ofstream(path) << R"({"measured": "2030-01-02", "fluid_s": -1, "structure_s": 1, "window_s": 1, "fluid_parts": {}})";
  EXPECT_THROW(read_costs(path), BadInput);
  std::ofstream(path) << "no json";
  EXPECT_THROW(read_costs(path), BadInput);
  EXPECT_THROW(read_costs(out / "absent.json"), InputOutputError);
}

// Seen to fail: with one pass named for every body.
TEST(Estimate, SaysWhichAlgorithmTheMassBehindAFaceCallsFor) {
  const auto text = [](const char* density) {
    const CaseOptions options{.overrides = {{"structure.body.0.density", density}, {"coupling.algorithm", "auto"}}, .preset = ""};
    return explain_text(case_of("dam_break_plate", options));
  };
  // 31 kg/m^2, a layer of 4 mm has 4
  EXPECT_NE(text("7800").find("one pass a window, repeated where it is not enough"), std::string::npos);
  EXPECT_NE(text("700").find("if both are wet, one pass a window, repeated where it is not enough, and windows half as long"),
            std::string::npos);  // 2.8, 1.4
  EXPECT_NE(text("40").find("every window is repeated, and half as long"), std::string::npos);
}

// A ring that vibrates in fluid at rest takes 202 windows: neither gravity nor the fluid limits them. Seen to fail: with the fluid's limits
// alone (34), without the windows that grow (128).
TEST(Estimate, KnowsTheWindowsOfABodyThatVibratesFromTheStart) {
  const Estimate ring = estimate(case_of("ring_in_annulus"));
  EXPECT_GT(ring.steps, 140);
  EXPECT_LT(ring.steps, 300);
  EXPECT_NE(explain_text(case_of("ring_in_annulus")).find("of a body that vibrates from the start on"), std::string::npos);
  EXPECT_TRUE(std::isinf(estimate(case_of("dam_break_plate")).motion_step));
  EXPECT_TRUE(std::isinf(estimate(case_of("rising_disc")).motion_step));
}

// A disc that spins and drifts keeps its shape; a plate that is held at its foot and moves like that bends. Seen to fail: with the mean
// velocity taken off alone, both vibrate (a square that spins in a patch of water then took 2510 windows by the estimate, 64 in the run).
TEST(Estimate, KnowsThatABodyThatTurnsDoesNotVibrate) {
  const auto moving = [](const char* scene, const std::string& body) {
    return estimate(case_of(scene, {.overrides = {{"structure.body." + body + ".velocity", "[\"1-5*y\", \"5*x\"]"}}, .preset = ""}));
  };
  EXPECT_TRUE(std::isinf(moving("rising_disc", "disc").motion_step));
  EXPECT_LT(moving("dam_break_plate", "plate").motion_step, 1e-2);
}

// The plate swings at 79.2 Hz, held at both ends. Seen to fail: with one end (33 windows by default, and no word of them). What is named
// is what binds, in the halved windows of a light body as well. Seen to fail: with gravity's limit compared with the halved window.
TEST(Estimate, SaysWhenWindowsDoNotShowTheFirstBending) {
  const auto plate_with = [](const char* gravity_courant) {
    return case_of("hydrostatic_plate", {.overrides = {{"fluid.numerics.gravity_courant", gravity_courant}}, .preset = ""});
  };
  const double period = estimate(plate_with("0.1")).bodies[0].bending_period;  // in open water; here a column has to move with it
  EXPECT_GT(period, 0.4 / 79.2);
  EXPECT_LT(period, 1 / 79.2);
  EXPECT_NE(explain_text(plate_with("0.1")).find("its first bending takes about"), std::string::npos);
  EXPECT_EQ(explain_text(plate_with("0.0025")).find("its first bending"), std::string::npos);
  const Case light =
      case_of("hydrostatic_plate",
              {.overrides = {{"structure.body.plate.density", "100"}, {"fluid.numerics.gravity_courant", "0.1"}}, .preset = ""});
  EXPECT_TRUE(estimate(light).light);
  EXPECT_NE(explain_text(light).find("to see them, fluid.numerics.gravity_courant ="), std::string::npos);
  EXPECT_EQ(explain_text(case_of("dam_break_plate")).find("its first bending"), std::string::npos);
}

}  // namespace
}  // namespace tern
