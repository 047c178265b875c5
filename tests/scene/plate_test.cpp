// Plates in a case file: what is refused, and with which sentence; shells that touch.

#include "case_file_fixture.hpp"
#include "scene/estimate.hpp"
#include "scene/mid_surface.hpp"

namespace tern {
namespace {

constexpr const char* plate_case = R"(title = "plate"
dimension = 3
end_time = 0.5
gravity = [0, 0, 0]
[[structure.body]]
name = "plate"
model = "shell"
shape = { plate = { vertices = [[0, 0, 0], [1, 0, 0], [1, 0, 0.6], [0, 0, 0.8]], thickness = 0.02 } }
spacing = 0.05
density = 1100
young_modulus = 1e6
poisson_ratio = 0.4
clamp = [{ box = { min = [-0.1, -0.1, -0.1], max = [0.01, 0.1, 0.9] } }]
)";

std::string changed(const std::string& old_text, const std::string& new_text) { return replaced(plate_case, old_text, new_text); }

TEST_F(CaseFile, APlateIsAShellWithTheMassOfItsPolygon) {
  const Case scene = read(plate_case);
  double area = 0;
  int held = 0;
  for (const auto& cell : cells_of(mid_surface<3>(scene.structure->bodies[0]))) area += cell.area, held += cell.edge == EdgeKind::clamp;
  EXPECT_NEAR(area, 0.7, 1e-13);
  EXPECT_EQ(held, 16);  // 0.8 m between free corners
  EXPECT_EQ(estimate(scene).bodies[0].clamped, 16u);
}

TEST_F(CaseFile, APlateThatIsNoneIsRefused) {
  expect_refused(changed("[1, 0, 0.6]", "[1, 0.1, 0.6]"), {"off the plane of the others"});
  expect_refused(changed("[1, 0, 0.6], [0, 0, 0.8]", "[0, 0, 0.8], [1, 0, 0.6]"), {"sides of the plate cross"});
  expect_refused(changed("[1, 0, 0], [1, 0, 0.6]", "[1, 0, 0], [1, 0, 0]"), {"corner 3 of the plate repeats the one before"});
  expect_refused(changed(", [1, 0, 0.6], [0, 0, 0.8]", ""), {"at least 3 points"});
  expect_refused(changed("[1, 0, 0.6]", "[1, 0.6]"), {"a list of 3 numbers"});
  expect_refused(changed("[1, 0, 0.6], [0, 0, 0.8]", "[2, 0, 0]"), {"it has no area"});
  expect_refused(replaced(small_case, "{ box = { min = [0.7, -0.1], max = [0.8, 0.5] } }",
                          "{ plate = { vertices = [[0, 0, 0], [1, 0, 0], [1, 0, 1]], thickness = 0.1 } }"),
                 {"a plate has no meaning in 2D"});
  expect_refused(changed("max = [0.01, 0.1, 0.9]", "max = [0.03, 0.1, 0.9]"),
                 {"'plate'", "clamp that reaches farther into it", "at its side 4"});
  expect_refused(changed("max = [0.01, 0.1, 0.9]", "max = [0.01, 0.1, 0.5]"), {"'plate'", "clamp that holds its side 4 in part"});
  expect_refused(changed("max = [0.01, 0.1, 0.9]", "max = [-0.01, 0.1, 0.9]"), {"clamp that contains none of its sides"});
  expect_refused(changed("spacing = 0.05", "spacing = 0.3"), {"has 3 free particles over 1.14 m along its longest side"});
}

// Fluid that a tilted plate stands in is cut by its shape. Seen to fail: with thin shapes of elastic bodies alone.
TEST_F(CaseFile, APlateIsCutOutOfTheFluidThatItStandsIn) {
  const std::string plate = "{ plate = { vertices = [[0, 0, 0], [0.8, 1, 0], [0.8, 1, 0.6], [0, 0, 0.6]], thickness = 0.05 } }";
  const auto with_fluid = [&](const std::string& shape) {
    return changed("{ plate = { vertices = [[0, 0, 0], [1, 0, 0], [1, 0, 0.6], [0, 0, 0.8]], thickness = 0.02 } }", plate) +
           "[fluid]\ndensity = 1000\nspacing = 0.1\n[[fluid.body]]\nshape = " + shape + "\n";
  };
  const std::string water = "{ box = { min = [0, 0, 0], max = [1, 0.5, 0.6] } }";
  expect_refused(with_fluid(water), {"the elastic body 'plate' and fluid body 1 overlap", "cut it out with difference"});
  const Case scene = read(with_fluid("{ difference = [" + water + ", " + plate + "] }"));
  EXPECT_EQ(estimate(scene).fluid_particles, 300 - 4 * 6);  // columns along z; 19.2 particles would have the volume
  expect_refused(plate_case + std::string("[[wall]]\nname = \"block\"\nobstacle = ") + plate + "\n",
                 {"a plate can be in the shape of a [[structure.body]] or a [[fluid.body]] only", "use boxes and balls"});
}

// A wall of a box that shares an edge with the plate; one that stands on it; one a gap away; one that touches it inside a clamp of both.
// Seen to fail: with the points inside a clamp.
TEST_F(CaseFile, ShellsThatTouchAreRefusedByName) {
  const auto both = [](const std::string& second, const std::string& clamp) {
    return std::string(plate_case) + "[[structure.body]]\nname = \"second\"\nmodel = \"shell\"\nshape = " + second +
           "\nspacing = 0.05\ndensity = 1100\nyoung_modulus = 1e6\npoisson_ratio = 0.4\n" + clamp;
  };
  const std::vector<std::string> sentences = {"the shells 'second' and 'plate' touch at", "there are no joints of shells"};
  expect_refused(both("{ plate = { vertices = [[0, 0, 0], [1, 0, 0], [1, 0.5, 0], [0, 0.5, 0]], thickness = 0.02 } }", ""), sentences);
  expect_refused(both("{ box = { min = [0.5, 0.01, 0.2], max = [0.52, 0.5, 0.5] } }", ""), sentences);
  EXPECT_EQ(sentence(both("{ box = { min = [0.5, 0.02, 0.2], max = [0.52, 0.5, 0.5] } }", "")), "");
  EXPECT_EQ(sentence(both("{ box = { min = [-0.5, -0.01, 0], max = [0, 0.01, 0.8] } }",
                          "clamp = [{ box = { min = [-0.02, -0.1, -0.1], max = [0.01, 0.1, 0.9] } }]\n")),
            "");
}

// The clamp ends a roof where its mid-surface leaves the box, found to round-off: held particles may be a hair outside of it.
// Seen to fail: with the particles that are inside a clamp, 18 of them.
TEST_F(CaseFile, ParticlesOnTheEdgesOfABentShellCountAsClamped) {
  const Case scene = read(R"(title = "roof"
dimension = 3
end_time = 0.01
gravity = [0, 0, 0]
[[structure.body]]
name = "roof"
model = "shell"
shape = { tube = { center = [0, 0, 0], axis = "x", length = 1.8, radius = 1, thickness = 0.02, begin = 0.5, end = 2.64 } }
spacing = 0.1
density = 1100
young_modulus = 1e8
poisson_ratio = 0.3
clamp = [{ box = { min = [-0.95, 0.8, -0.1], max = [0.95, 1.1, 0.52] } }, { box = { min = [-0.95, -1.1, -0.1], max = [0.95, -0.8, 0.52] } }]
)");
  EXPECT_EQ(estimate(scene).bodies[0].clamped, 36u);
}

}  // namespace
}  // namespace tern
