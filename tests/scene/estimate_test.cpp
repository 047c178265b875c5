// What a case is foretold to take: steps by all that moves in it, coupling iterations by the lightness of its bodies.

#include "scene/estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tern {
namespace {

Case case_of(const std::string& name, const CaseOptions& options = {}) { return read_case(TERN_SOURCE_DIR "/cases/" + name, options); }

// Seen to fail: with fluid that something is cut out of taken for fluid that is free to fall (4556 steps).
TEST(Estimate, OfWaterAtRestAroundABodyIsThatOfWaterAtRest) {
  for (const char* name : {"submerged_block", "floating_block", "submerged_block_3d", "rising_disc"}) {
    const Estimate e = estimate(case_of(name));
    EXPECT_TRUE(e.settled) << name;
    const Case c = case_of(name);
    const auto box = c.dimension == 2 ? bounding_box<2>(c.fluid->bodies[0].shape).max[1] : bounding_box<3>(c.fluid->bodies[0].shape).max[1];
    EXPECT_NEAR(e.speed, 0.5 * std::sqrt(9.81 * box), 0.02 * e.speed) << name;
  }
  EXPECT_FALSE(estimate(case_of("dam_break_plate")).settled);
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

// A window does not reach beyond the next frame. Seen to fail: with one step for a scene in which nothing moves yet.
TEST(Estimate, OfASceneAtRestHasAWindowPerFrameAtLeast) {
  Case c = case_of("submerged_block");
  c.gravity = {};
  EXPECT_EQ(estimate(c).steps, std::ceil(c.end_time / c.output.frame_interval));
}

// Seen to fail: with one iteration for all.
TEST(Estimate, ReckonsWithIterationsForLightBodies) {
  EXPECT_EQ(estimate(case_of("submerged_block")).iterations, 1);
  EXPECT_GT(estimate(case_of("submerged_block", {{{"coupling.algorithm", "implicit"}}, ""})).iterations, 1);
  const Estimate heavy = estimate(case_of("rising_disc", {{{"structure.body.disc.density", "1000"}}, ""})),
                 light = estimate(case_of("rising_disc"));
  EXPECT_EQ(heavy.iterations, 1);
  EXPECT_GT(light.iterations, 3);
  EXPECT_GT(light.fluid_cpu, 2 * heavy.fluid_cpu);
}

}  // namespace
}  // namespace tern
