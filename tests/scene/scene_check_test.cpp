// Scenes: what is refused because it makes no sense, with which sentence, and what is warned of.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>

#include "case_file_fixture.hpp"
#include "scene/estimate.hpp"
#include "scene/geometry.hpp"
#include "scene/placement.hpp"

namespace tern {
namespace {

// Each seen to fail with its check left out (but for the limit on particles, which would fill the memory).
TEST_F(CaseFile, WhoseSceneMakesNoSenseIsRefused) {
  expect_refused(with("max = [0.4, 0.5]", "max = [1.1, 0.5]"), {"fluid body 1 reaches out of the container", "room from 0 to 1 m"});
  expect_refused(with("min = [0, 0], max = [0.4, 0.5]", "min = [0, -0.2], max = [0.4, 0.5]"),
                 {"direction y, where there is room from 0 m on"});
  expect_refused(with("max = [0.4, 0.5]", "max = [0.75, 0.5]"), {"'plate' and fluid body 1 overlap"});
  expect_refused(with("max = [0.4, 0.5]", "max = [0.02, 0.02]"), {"holds no particle"});
  expect_refused(with("[0.7, -0.1], max = [0.8, 0.5]", "[0.7, -0.1], max = [1.2, 0.5]"),
                 {"'plate' stands outside the container", "structure.body.plate.shape", "structure.body.plate.clamp"});
  expect_refused(with("{ box = { min = [0.6, -0.2], max = [0.9, 0] } }", ""), {"'plate' stands outside the container"});
  expect_refused(with("min = [0.6, -0.2], max = [0.9, 0]", "min = [2, 2], max = [3, 3]"), {"stands outside"});
  expect_refused(with("[{ box = { min = [0.6", "[{ ball = { center = [9, 9], radius = 1 } }, { box = { min = [0.6"),
                 {"clamp 1 of 'plate' holds none"});
  expect_refused(with("max = [0.9, 0]", "max = [0.9, 1]"), {"hold all of its"});
  expect_refused(with("spacing = 0.025", "spacing = 0.09"), {"1.11 particles across", "at least 2"});
  expect_refused(with("spacing = 0.05", "spacing = 1e-7"), {"at most"});
  expect_refused(with("body = \"plate\"", "body = \"plat\""), {"names the elastic body 'plat'", "only 'plate'"});
  expect_refused(with("at = [0.75, 0.5]", "at = [0.75, 0.6]"), {"no point of the undeformed body"});
  expect_refused(with("at = [0.75, 0.5]\n", ""), {"needs the key 'at'"});
  expect_refused(with("max = [0.4, 0.5]", "max = [0, 0.5]"), {"min has to be less than max"});
  expect_refused(with("open = [", "displacement = [\"t+1\", 0]\nopen = ["), {"1 m at t = 0"});
  expect_refused(with("open = [", "displacement = [\"t*x\", 0]\nopen = ["), {"depends on the place"});
  expect_refused(with("max = [0.4, 0.5] } }", "max = [0.4, 0.5] } }\nvelocity = [\"sin(z)\", 0]"), {"has no z"});
  expect_refused(with("max = [0.4, 0.5] } }", "max = [0.4, 0.5] } }\nvelocity = [\"sin(t)\", 0]"), {"depends on t", "that of the start"});
  const std::string twice = std::string(small_case) + "[[gauge]]\nkind = \"front\"\nname = \"tip\"\n";
  expect_refused(twice, {"'tip' is used twice"});
  const std::string gate =
      std::string(small_case) + "[[wall]]\nname = \"gate\"\nobstacle = { box = { min = [0.3, 0], max = [0.35, 1] } }\n";
  expect_refused(gate, {"fluid body 1 and the obstacle 'gate' overlap"});
  const std::string two = std::string(small_case) + "[[wall]]\nname = \"b\"\ncontainer = { box = { min = [0, 0], max = [1, 1] } }\n";
  expect_refused(two, {"second container"});
  const std::string thin_gate =
      std::string(small_case) + "[[wall]]\nname = \"gate\"\nobstacle = { box = { min = [0.299, 0], max = [0.301, 1] } }\n";
  expect_refused(thin_gate, {"fluid body 1 and the obstacle 'gate' overlap"});  // thinner than the spacing
}

// Seen to fail with the pivot left out of the motion, with the text of the table left out of the hash, and with a domain
// around the initial places alone.
TEST_F(CaseFile, MovesAWallByExpressionsOrByATable) {
  const Case turned = read(with("open = [", "rotation = \"0.1*sin(t)\"\npivot = [0.5, 0.2]\nopen = ["));
  ASSERT_TRUE(turned.walls[0].motion.has_value());
  EXPECT_EQ(turned.walls[0].motion->pivot[1], 0.2);
  EXPECT_NEAR(turned.walls[0].motion->rotation(0.3), 0.1 * std::sin(0.3), 1e-15);

  const std::string by_table = with("open = [", "motion_file = \"motion.csv\"\nopen = [");
  std::ofstream(folder_ / "motion.csv") << "t_s,x_m\n0,0\n1,2\n";
  const Case moved = read(by_table);
  EXPECT_NEAR(placement<2>(*moved.walls[0].motion, 0.5).shift[0], 1, 1e-12);
  EXPECT_EQ(moved.domain_max[0], 1 + 1 + 0.5 * 2) << "around all places of the wall until 0.5 s";
  std::ofstream(folder_ / "motion.csv") << "t_s,x_m\n0,0\n1,2.001\n";
  EXPECT_NE(read(by_table).hash, moved.hash);
}

// With a check left out no sentence comes, or another one.
TEST_F(CaseFile, WhoseMotionMakesNoSenseIsRefused) {
  expect_refused(with("open = [", "motion_file = \"none.csv\"\nopen = ["),
                 {"'none.csv'", "cannot be read (No such file or directory)", "relative to the case file"});
  std::ofstream(folder_ / "motion.csv") << "t_s,angle_rad\n0,0\n1,2\n";
  expect_refused(with("open = [", "motion_file = \"motion.csv\"\nopen = ["), {"is rotated, but has no pivot"});
  expect_refused(with("open = [", "motion_file = \"motion.csv\"\nrotation = \"t\"\nopen = ["), {"both motion_file and rotation"});
  std::ofstream(folder_ / "motion.csv") << "t_s,x_m\n0,1\n1,2\n";
  expect_refused(with("open = [", "motion_file = \"motion.csv\"\nopen = ["), {"motion.csv:2: x_m is not 0 at t = 0"});
  expect_refused(with("open = [", "rotation = \"1+t\"\npivot = [0, 0]\nopen = ["), {"rotation '1+t'", "1 rad at t = 0"});
  expect_refused(with("open = [", "rotation = \"t+\"\npivot = [0, 0]\nopen = ["), {"rotation [rad]", "cannot be read"});
  expect_refused(with("open = [", "pivot = [0, 0]\nopen = ["), {"is not rotated"});
  expect_refused(with("open = [", "rotation = \"t\"\npivot = [0, 0]\naxis = [0, 1]\nopen = ["), {"only turn in the plane"});
}

// With a check left out no sentence comes, or another one.
TEST_F(CaseFile, WhoseGaugesMakeNoSenseIsRefused) {
  const auto gauge = [](const std::string& keys) { return std::string(small_case) + "[[gauge]]\nname = \"g\"\n" + keys; };
  const Case c = read(gauge("kind = \"wall_pressure\"\nwall = \"tank\"\nat = [1, 0.2]\n"));
  EXPECT_EQ(c.gauges[1].number("diameter"), 0.05) << "one spacing";
  read(gauge("kind = \"force\"\nwall = \"tank\"\n"));
  read(gauge("kind = \"flux\"\nfrom = [0.5, 0]\nto = [0.5, 1]\n"));
  expect_refused(gauge("kind = \"force\"\nwall = \"tnk\"\n"), {"names the wall 'tnk'", "only 'tank'"});
  expect_refused(gauge("kind = \"force\"\n"), {"needs the key 'wall'"});
  expect_refused(gauge("kind = \"force\"\nwall = \"tank\"\ndiameter = 1\n"), {"no use for the key 'diameter'"});
  expect_refused(gauge("kind = \"wall_pressure\"\nwall = \"tank\"\nat = [0.9, 0.2]\n"), {"0.1 m away from the surface"});
  expect_refused(gauge("kind = \"wall_pressure\"\nwall = \"tank\"\nat = [0.5, 1]\n"), {"on an open face"});
  expect_refused(gauge("kind = \"flux\"\nfrom = [0.5, 0]\nto = [0.5, 0]\n"), {"length 0"});
  expect_refused(gauge("kind = \"elevation\"\nat = [1.1, 0]\n"), {"'g' at (1.1, 0) m is beside the container"});
  read(gauge("kind = \"elevation\"\nat = [0.9, 7]\n"));
}

// With a check left out no sentence comes, or another one.
TEST_F(CaseFile, WhoseGaugesOfABodyMakeNoSenseIsRefused) {
  const auto pressure = [](const std::string& keys) {
    return std::string(small_case) + "[[gauge]]\nkind = \"body_pressure\"\nname = \"p\"\nbody = \"plate\"\n" + keys;
  };
  EXPECT_EQ(read(pressure("at = [0.7, 0.2]\n")).gauges[1].number("diameter"), 0.05) << "one spacing of the fluid";
  expect_refused(pressure(""), {"needs the key 'at'"});
  expect_refused(pressure("at = [0.72, 0.2]\n"), {"0.02 m away from the surface of the undeformed body 'plate'"});
  expect_refused(pressure("at = [0.7, -0.05]\n"), {"is inside a clamp of 'plate'"});
  const auto frame = [](const std::string& name, const std::string& motion) {
    std::string text = std::string(small_case) + "frame = \"" + name + "\"\n";
    return text.replace(text.find("open = ["), 0, motion);
  };
  const std::string moves = "displacement = [\"t\", 0]\n";
  EXPECT_EQ(read(frame("tank", moves)).gauges[0].text("frame"), "tank");
  expect_refused(frame("tnk", moves), {"the frame of 'tnk'", "no [[wall]] and no [[structure.clamp]]", "what moves is 'tank'"});
  expect_refused(frame("tank", ""), {"the frame of 'tank', which does not move", "nothing in this case moves"});
}

/// The small case with a thin plate as a shell.
std::string shell_case() {
  std::string text = small_case;
  const std::string solid = "shape = { box = { min = [0.7, -0.1], max = [0.8, 0.5] } }";
  return text.replace(text.find(solid), solid.size(), "model = \"shell\"\nshape = { box = { min = [0.74, -0.1], max = [0.76, 0.5] } }");
}

TEST_F(CaseFile, ReadsAShell) {
  const Case c = read(shell_case());
  EXPECT_TRUE(c.structure->bodies[0].is_shell);
  EXPECT_TRUE(c.warnings.empty());
  const BodyEstimate body = estimate(c).bodies[0];
  EXPECT_EQ(body.particles, 21) << "20 spacings of 0.0244 m, the last one a half; one particle on the clamp";
  EXPECT_EQ(body.clamped, 1);
  EXPECT_NEAR(body.thickness, 0.02, 1e-15);
  EXPECT_NEAR(body.wave_speed, std::sqrt(1e6 / (1 - 0.16) / 1100), 1e-12);
}

// With a check left out no sentence comes, or another one.
TEST_F(CaseFile, RefusesWhatAShellDoesNotModel) {
  const auto changed = [](const std::string& old_text, const std::string& new_text) { return replaced(shell_case(), old_text, new_text); };
  expect_refused(changed("{ box = { min = [0.74, -0.1], max = [0.76, 0.5] } }", "{ ball = { center = [0.75, 0.2], radius = 0.1 } }"),
                 {"'plate' has no mid-surface", "model it as a solid"});
  expect_refused(changed("max = [0.9, 0] } }]", "max = [0.75, 0] } }]"), {"clamp that is not a box over one whole edge"});
  expect_refused(changed("max = [0.9, 0] } }]", "max = [0.9, -0.11] } }]"), {"clamp that is not a box over one whole edge"});
  // Seen to fail: without the look at how many ends it holds ("does not hold one end of it").
  const std::string box = "{ box = { min = [0.74, -0.1], max = [0.76, 0.5] } }", clamp = "{ box = { min = [0.6, -0.2], max = [0.9, 0] } }";
  const std::string arch =
      "{ line = { vertices = [[0.6, -0.1], [0.6, 0.5], [0.62, 0.6], [0.7, 0.65], [0.78, 0.6], [0.8, 0.5], [0.8, -0.1]], "
      "thickness = 0.02 } }";
  expect_refused(
      replaced(replaced(changed(box, arch), clamp, "{ box = { min = [0, -0.2], max = [1, 0] } }"), "at = [0.75, 0.5]", "at = [0.6, 0.5]"),
      {"'plate' is held by a clamp that holds 2 of its ends at once"});
  // A hinge.
  const auto hinged = [&](const std::string& region) { return changed("poisson_ratio", "hinge = [" + region + "]\npoisson_ratio"); };
  expect_refused(hinged("{ box = { min = [0.7, 0.4], max = [0.8, 0.6] } }"),
                 {"'plate'", "reaches farther into it than its thickness, 0.02 m"});
  expect_refused(hinged("{ box = { min = [0.7, 0.51], max = [0.8, 0.6] } }"), {"'plate'", "holds none of its edges"});
  expect_refused(replaced(small_case, "poisson_ratio", "hinge = [{ box = { min = [0.6, 0.49], max = [0.9, 0.6] } }]\npoisson_ratio"),
                 {"the solid 'plate' has a hinge", "model = \"shell\""});
  EXPECT_EQ(estimate(read(hinged("{ box = { min = [0.7, 0.49], max = [0.8, 0.6] } }"))).bodies[0].clamped, 2);
  expect_refused(changed("poisson_ratio", "material = \"mooney_rivlin\"\npoisson_ratio"), {"mooney_rivlin", "no law of a layer"});
  expect_refused(changed("spacing = 0.025\n", "spacing = 0.15\n"), {"has 3 free particles over 0.5 m in direction y", "at most 0.111 m"});
  expect_refused(changed("at = [0.75, 0.5]", "at = [0.76, 0.5]"),
                 {"'tip'", "is not on the mid-surface of the shell 'plate', but 0.01 m beside it; move it to [0.75, 0.5]."});
  expect_refused(changed("at = [0.75, 0.5]", "at = [0.75, -0.05]"), {"'tip'", "is inside a clamp of 'plate'"});
}

// Deflection under a uniform load that is missing without shear: 0.8/(1 - nu) (t/L)^2 of a cantilever, 9.6/(1 - nu) (t/L)^2 between two
// clamps.
TEST_F(CaseFile, WarnsOfAShellThatIsTooThickOrHasTooFewParticles) {
  const Case thick = read(with("shape = { box = { min = [0.7", "model = \"shell\"\nshape = { box = { min = [0.7"));
  ASSERT_EQ(thick.warnings.size(), 2u);
  EXPECT_NE(thick.warnings[0].find("is 5 thicknesses long from its clamp on; without transverse shear it bends 5.3 % too little"),
            std::string::npos)
      << thick.warnings[0];
  EXPECT_NE(thick.warnings[1].find("below half of its thickness"), std::string::npos) << thick.warnings[1];
  std::string text = shell_case();
  const std::string clamp = "clamp = [{";
  text.replace(text.find(clamp), clamp.size(), "clamp = [{ box = { min = [0.6, 0.3], max = [0.9, 0.6] } }, {");
  const Case between = read(replaced(text, "at = [0.75, 0.5]", "at = [0.75, 0.2]"));
  ASSERT_EQ(between.warnings.size(), 2u);
  EXPECT_NE(between.warnings[0].find("is 15 thicknesses long between two clamps; without transverse shear it bends 7.1 % too little"),
            std::string::npos)
      << between.warnings[0];
  EXPECT_NE(between.warnings[1].find("has 11 particles between two clamps; it bends 11 % too much"), std::string::npos)
      << between.warnings[1];
}

// A channel that is open at both ends is no channel with inflow. Seen to fail: with no gravity taken for one along x.
TEST_F(CaseFile, WarnsOfFluidThatStartsTowardsAnOpenFace) {
  const auto channel = [this](const std::string& velocity) {
    return read(
        "dimension = 2\nend_time = 1\ngravity = [0, 0]\n[[wall]]\nname = \"channel\"\n"
        "container = { box = { min = [0, 0], max = [1, 0.2] } }\nopen = [\"x_min\", \"x_max\"]\n"
        "[fluid]\ndensity = 1000\nspacing = 0.02\n[[fluid.body]]\nshape = { box = { min = [0, 0], max = [1, 0.2] } }\nvelocity = [" +
        velocity + ", 0]\n");
  };
  const auto warned = [](const Case& c, const std::string& face) {
    return std::any_of(c.warnings.begin(), c.warnings.end(), [&](const std::string& text) {
      return text.find("1.5 m/s towards the open face " + face + " of the container 'channel'") != std::string::npos;
    });
  };
  EXPECT_TRUE(warned(channel("\"1.5*sin(pi*y/0.1)^2\""), "x_max"));
  EXPECT_FALSE(warned(channel("\"1.5*sin(pi*y/0.1)^2\""), "x_min"));
  EXPECT_TRUE(warned(channel("-1.5"), "x_min"));
  EXPECT_FALSE(warned(channel("0"), "x_max"));
}

// Seen to fail: with a sentence for each body.
TEST_F(CaseFile, SaysOnceWhatHoldsOfManyBodies) {
  const auto floats = [this](int bodies, double density_of_last) {
    std::string text =
        "dimension = 2\nend_time = 1\ngravity = [0, -9.81]\n[[wall]]\nname = \"tank\"\n"
        "container = { box = { min = [0, 0], max = [4, 1] } }\n[fluid]\ndensity = 1000\nspacing = 0.05\n"
        "[[fluid.body]]\nshape = { box = { min = [0, 0], max = [4, 0.2] } }\n";
    for (int n = 0; n < bodies; ++n)
      text += fmt::format(
          "[[structure.body]]\nname = \"float {}\"\nshape = {{ box = {{ min = [{}, 0.4], max = [{}, 0.6] }} }}\nspacing = 0.05\n"
          "density = {}\nyoung_modulus = 1e7\npoisson_ratio = 0.3\n",
          n, 0.4 * n + 0.1, 0.4 * n + 0.3, n + 1 < bodies ? 800.0 : density_of_last);
    return read(text).warnings;
  };
  const std::vector<std::string> eight = floats(8, 800);
  ASSERT_EQ(eight.size(), 1u);
  EXPECT_NE(eight[0].find("'float 0' is free and 20 % lighter"), std::string::npos) << eight[0];
  EXPECT_NE(eight[0].find(" The same holds of 'float 1', 'float 2', 'float 3', 'float 4', 'float 5' and 2 more."), std::string::npos)
      << eight[0];
  const std::vector<std::string> other = floats(3, 900);
  ASSERT_EQ(other.size(), 2u);
  EXPECT_NE(other[0].find(" The same holds of 'float 1'."), std::string::npos) << other[0];
  EXPECT_EQ(other[1].find("The same holds"), std::string::npos) << other[1];
}

// It bends from its clamp on; its width bends nothing. Seen to fail: with the width held against the thickness, "from edge to edge".
TEST_F(CaseFile, TakesTheLengthOfACantileverAndNotItsWidth) {
  const auto sheet = [this](const std::string& width) {
    return read(
        "dimension = 3\nend_time = 0.1\ngravity = [0, -9.81, 0]\n[[structure.body]]\nname = \"sheet\"\nmodel = \"shell\"\n"
        "shape = { box = { min = [0, 0, 0], max = [0.2, 0.01, " +
        width +
        "] } }\nspacing = 0.01\ndensity = 1000\n"
        "young_modulus = 1e6\npoisson_ratio = 0.4\nclamp = [{ box = { min = [-0.1, -0.1, -0.1], max = [0, 0.1, 1] } }]\n");
  };
  EXPECT_TRUE(sheet("0.1").warnings.empty()) << sheet("0.1").warnings[0];
  EXPECT_TRUE(sheet("0.04").warnings.empty()) << sheet("0.04").warnings[0];
}

// Two layers bend as four do (TwoLayers.BendAsFourDo). Seen to fail: with a warning of bodies below four.
TEST_F(CaseFile, TakesABodyOfTwoParticlesAcrossWithoutAWarning) {
  EXPECT_TRUE(read(small_case).warnings.empty());
  EXPECT_TRUE(read(with("spacing = 0.025", "spacing = 0.05")).warnings.empty());
}

// A slanting plate as thick as it says, but for the round-off of its corners, is not refused as "2 particles across, but needs at least 2".
// Seen to fail with that limit to the sixth digit.
TEST_F(CaseFile, TakesTheThicknessOfABodyToTheDigitsThatItShows) {
  const std::string slanting = "polygon = { vertices = [[0.55, 0.60], [0.7232, 0.70], [0.7132, 0.7173], [0.54, 0.6173]] }";
  const std::string text = replaced(replaced(replaced(with("box = { min = [0.7, -0.1], max = [0.8, 0.5] }", slanting),
                                                      "clamp = [{ box = { min = [0.6, -0.2], max = [0.9, 0] } }]", ""),
                                             "at = [0.75, 0.5]", "at = [0.6316, 0.6586]"),
                                    "spacing = 0.025", "spacing = 0.01");
  EXPECT_NO_THROW(read(text));
}

// A part of a ring, whose lattice goes along the coordinates, four and eight particles across. A slanting rectangle has a lattice of its
// own, and a disc does not bend. Seen to fail: with the lattice of a polygon along the coordinates.
TEST_F(CaseFile, WarnsOfAThinPartThatItsLatticeCutsAskew) {
  const auto body = [](const std::string& shape, const std::string& spacing) {
    return "title = \"bend\"\ndimension = 2\nend_time = 1\ngravity = [0, 0]\n[[structure.body]]\nname = \"beam\"\nshape = { " + shape +
           " }\nspacing = " + spacing + "\ndensity = 1000\nyoung_modulus = 1e6\npoisson_ratio = 0.3\n";
  };
  const std::string arc = "ring = { center = [0, 0], radius = 1, thickness = 0.1, begin = 0.2, end = 1.3 }";
  const Case coarse = read(body(arc, "0.025"));
  ASSERT_EQ(coarse.warnings.size(), 1u);
  EXPECT_NE(coarse.warnings[0].find("4 particles across, does not: it may bend as much as 9.6 % too far"), std::string::npos)
      << coarse.warnings[0];
  EXPECT_TRUE(read(body(arc, "0.0125")).warnings.empty());
  EXPECT_TRUE(read(body("polygon = { vertices = [[0, 0], [0.8, 0.6], [0.77, 0.64], [-0.03, 0.04]] }", "0.0125")).warnings.empty());
  EXPECT_TRUE(read(body("ball = { center = [0, 0], radius = 0.2 }", "0.0125")).warnings.empty());
}

// 1.3 times 50 kg/m^2 of a layer of water over 110 kg/m^2 of the plate. Seen to fail without look_at_scheme().
TEST_F(CaseFile, WarnsOfTheSchemeThatFeedsVibrations) {
  const std::string fsa = std::string(small_case) + "[coupling]\nscheme = \"fsa\"\n";
  const Case c = read(fsa);
  ASSERT_EQ(c.warnings.size(), 1u);
  EXPECT_NE(c.warnings[0].find("case.toml:"), std::string::npos) << c.warnings[0];
  EXPECT_NE(c.warnings[0].find("the swing of 'plate' grows by about 59 % a period"), std::string::npos) << c.warnings[0];
  EXPECT_TRUE(read(replaced(fsa, "\"fsa\"", "\"pi\"")).warnings.empty());
  EXPECT_TRUE(read(replaced(fsa, "density = 1100", "density = 44000")).warnings.empty()) << "it loses more than it gains";
}

// Seen to fail: without check_mass().
TEST_F(CaseFile, WarnsOfParticlesThatHaveAnotherMassThanTheBody) {
  const Case c = read(with("spacing = 0.025", "spacing = 0.0335"));
  ASSERT_EQ(c.warnings.size(), 1u);
  EXPECT_NE(c.warnings[0].find("the 54 particles of the elastic body 'plate' have 1 % more mass than its shape"), std::string::npos)
      << c.warnings[0];
  EXPECT_NE(c.warnings[0].find("fits better than 0.0335 m"), std::string::npos) << c.warnings[0];
}

// Seen to fail: without fit_spacings_of_bodies() (it is refused).
TEST_F(CaseFile, TakesASpacingAtWhichTheParticlesOfABodyHaveItsMass) {
  const Case c = read(with("spacing = 0.025", "spacing = 0.03"));
  EXPECT_EQ(c.structure->bodies[0].spacing, 0.025);
  ASSERT_EQ(c.warnings.size(), 1u);
  EXPECT_NE(c.warnings[0].find("at the spacing 0.03 m the 60 particles of the elastic body 'plate' have 10 % less mass"), std::string::npos)
      << c.warnings[0];
  EXPECT_NE(c.warnings[0].find("0.025 m is taken"), std::string::npos) << c.warnings[0];
}

// Seen to fail: without each of the two.
TEST_F(CaseFile, AsksWhetherUnitsAreMeant) {
  const auto asks = [&](const std::string& text, const char* words) {
    const Case c = read(text);
    return std::any_of(c.warnings.begin(), c.warnings.end(),
                       [&](const std::string& said) { return said.find(words) != std::string::npos; });
  };
  const char *density = "the density of the fluid is ", *gravity = "gravity is 9810 m/s^2";
  EXPECT_FALSE(asks(small_case, density));
  EXPECT_FALSE(asks(small_case, gravity));
  EXPECT_TRUE(asks(with("density = 1000", "density = 1"), density));
  EXPECT_TRUE(asks(with("-9.81]", "-9810]"), gravity));
}

// Half discs of 5.5 and 6.5 spacings have a layer of particles in their plane face. Seen to fail: without a search for a spacing that fits.
TEST_F(CaseFile, TakesAFinerSpacingWhereTheFluidWouldHaveAnotherMass) {
  for (const double radius : {0.275, 0.325}) {
    Shape half;
    half.kind = Shape::Kind::polygon;
    constexpr int sides = 64;
    for (int k = 0; k <= sides; ++k) {
      const double angle = std::numbers::pi * (1 + double(k) / sides);
      half.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    std::string vertices;
    for (const auto& v : half.vertices) vertices += fmt::format("[{}, {}],", v[0], v[1]);
    const Case c =
        read(fmt::format("dimension = 2\nend_time = 1\ngravity = [0, -10]\n[[wall]]\nname = \"tank\"\n"
                         "container = {{ polygon = {{ vertices = [{0}] }} }}\n[fluid]\ndensity = 1000\n"
                         "spacing = 0.05\n[[fluid.body]]\nshape = {{ polygon = {{ vertices = [{0}] }} }}\n",
                         vertices));
    const double cells = static_cast<double>(fill_with_fluid<2>(half, c.fluid->spacing).size());
    const double area = 0.5 * sides * radius * radius * std::sin(std::numbers::pi / sides);
    EXPECT_LT(c.fluid->spacing, 0.05);
    EXPECT_GE(c.fluid->spacing, 0.7 * 0.05);
    EXPECT_NEAR(cells * c.fluid->spacing * c.fluid->spacing, area, 0.01 * area);
    EXPECT_NE(c.warnings.at(0).find("of fluid body 1 have"), std::string::npos) << c.warnings.at(0);
  }
}

// Seen to fail: with the particles where the lattice has them.
TEST(FillWithFluid, LeavesNoParticleOnASlopedFace) {
  Shape trapezium;
  trapezium.kind = Shape::Kind::polygon;
  trapezium.vertices = {{-0.2, 0}, {0.2, 0}, {0.6, 0.4}, {-0.6, 0.4}};
  const auto points = fill_with_fluid<2>(trapezium, 0.02);
  EXPECT_EQ(points.size(), 820u);
  for (const auto& x : points) EXPECT_LT(signed_distance<2>(trapezium, x), -0.9e-3 * 0.02) << x.transpose();
}

// Seen to fail: with steps that are not stretched.
TEST_F(CaseFile, FitsTheSpacingOfTheFluidToItsBoxes) {
  for (double spacing : {0.05, 0.047, 0.053}) {
    const Case c = read(with("spacing = 0.05", fmt::format("spacing = {}", spacing)));
    const Shape& box = c.fluid->bodies[0].shape;
    const auto points = fill_with_fluid<2>(box, c.fluid->spacing);
    const double area = (box.max[0] - box.min[0]) * (box.max[1] - box.min[1]);
    EXPECT_NEAR(static_cast<double>(points.size()) * c.fluid->spacing * c.fluid->spacing, area, 1e-5 * area);
    for (int d : {0, 1}) {
      double low = 1e30, high = -1e30;
      for (const auto& x : points) low = std::min(low, x[d]), high = std::max(high, x[d]);
      EXPECT_NEAR(low - box.min[d], box.max[d] - high, 1e-9) << "as far from both ends";
      EXPECT_NEAR(low - box.min[d], 0.5 * c.fluid->spacing, 0.03 * c.fluid->spacing);
    }
    const bool said = std::any_of(c.warnings.begin(), c.warnings.end(),
                                  [](const std::string& warning) { return warning.find("no whole multiples") != std::string::npos; });
    EXPECT_EQ(said, std::abs(c.fluid->spacing / spacing - 1) > 0.01);
  }
}

// Seen to fail with the tenth-thinnest part of the whole surface as thickness: the tip of the triangle was too thin.
TEST_F(CaseFile, AllowsBodiesWithSharpEdges) {
  EXPECT_EQ(
      sentence(with("box = { min = [0.7, -0.1], max = [0.8, 0.5] }", "polygon = { vertices = [[0.6, -0.1], [0.9, -0.1], [0.75, 0.5]] }")),
      "");
  expect_refused(
      with("box = { min = [0.7, -0.1], max = [0.8, 0.5] }", "polygon = { vertices = [[0.5, -0.1], [0.9, 0.5], [0.9, -0.1], [0.5, 0.5]] }"),
      {"sides of the polygon cross"});
}

constexpr const char* channel_case = R"(dimension = 2
end_time = 1
gravity = [0.1, 0]
[domain]
min = [0, -1]
max = [1, 2]
periodic = ["x"]
[[wall]]
name = "channel"
container = { box = { min = [0, 0], max = [1, 1] } }
open = ["x_min", "x_max"]
[fluid]
density = 1000
spacing = 0.05
viscosity = 100
[[fluid.body]]
shape = { box = { min = [0, 0], max = [1, 1] } }
)";

TEST_F(CaseFile, WithAPeriodicDirectionThatCannotRepeatItselfIsRefused) {
  const std::string channel = channel_case;
  const auto changed = [&](const std::string& old_text, const std::string& new_text) { return replaced(channel, old_text, new_text); };
  const Case c = read(channel);
  EXPECT_TRUE(c.periodic[0] && !c.periodic[1] && !c.periodic[2]);
  EXPECT_EQ(c.fluid->viscosity, 100);
  EXPECT_FALSE(c.walls[0].slip);
  EXPECT_TRUE(c.warnings.empty());
  EXPECT_NEAR(estimate(c).viscous_step, 0.125 * 0.075 * 0.075 / 0.1, 1e-12);
  EXPECT_TRUE(read(changed("open =", "slip = true\nopen =")).walls[0].slip);
  expect_refused(changed("open =", "slip = 1\nopen ="), {"case.toml:11:", "slip", "true or false"});
  expect_refused(changed("[\"x\"]", "[\"z\"]"), {"case.toml:7:", "direction z", "2D"});
  expect_refused(changed("[\"x\"]", "[\"x\", \"w\"]"), {"case.toml:7:", "periodic of [domain]", "\"x\""});
  expect_refused(changed("spacing = 0.05", "spacing = 0.25"), {"case.toml:7:", "period in direction x is 1 m", "1.5 m"});
  expect_refused(changed("open = [\"x_min\", \"x_max\"]", "open = [\"x_min\"]"), {"case.toml:8:", "closed at x_max", "\"x_max\""});
  expect_refused(changed("min = [0, 0], max = [1, 1]", "min = [-0.1, 0], max = [1, 1]"),
                 {"case.toml:8:", "from -0.1 to 1 m", "from 0 to 1 m"});
  // From end to end of the period it stays where it is; a post does not.
  const Case belt = read(changed("open =", "displacement = [\"0.1*t\", 0]\nopen ="));
  EXPECT_TRUE(belt.walls[0].continues[0] && !belt.walls[0].continues[1]);
  EXPECT_EQ(placement<2>(belt.walls[0], belt.end_time).shift.norm(), 0);
  expect_refused(channel +
                     "[[wall]]\nname = \"post\"\nobstacle = { box = { min = [0.4, 0], max = [0.6, 0.5] } }\n"
                     "displacement = [\"0.1*t\", 0]\n",
                 {"case.toml:18:", "'post' moves in the periodic direction x", "a box from end to end"});
  expect_refused(channel +
                     "[[structure.body]]\nname = \"plate\"\nspacing = 0.05\ndensity = 1000\nyoung_modulus = 1e6\n"
                     "poisson_ratio = 0.4\nshape = { box = { min = [0.4, 0], max = [0.6, 0.5] } }\n",
                 {"case.toml:7:", "periodic", "[structure]"});
  const auto warnings = read(changed("spacing = 0.05", "spacing = 0.03")).warnings;
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("the period in direction x is 33.3"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[1].find("no whole multiples"), std::string::npos) << warnings[1];
}

constexpr const char* pulled_case = R"(dimension = 2
end_time = 1
gravity = [0, 0]
[[structure.body]]
name = "bar"
shape = { box = { min = [0, 0], max = [1, 0.2] } }
spacing = 0.05
density = 1000
young_modulus = 1e6
poisson_ratio = 0.3
material = "st_venant_kirchhoff"
plane = "stress"
mass_damping = 2
[[structure.clamp]]
name = "root"
body = "bar"
region = { box = { min = [-1, -1], max = [0.05, 1] } }
rotation = "0.1*t"
pivot = [0, 0.1]
[[structure.load]]
name = "pull"
body = "bar"
region = { box = { min = [0.99, -1], max = [1.01, 1] } }
traction = ["100*t", "y"]
[[structure.load]]
name = "squeeze"
body = "bar"
pressure = "10*x"
[[gauge]]
kind = "reaction"
name = "hold"
body = "bar"
clamp = "root"
)";

// Seen to fail: without reading `plane`, without the clamp's region among those of its body.
TEST_F(CaseFile, ReadsMaterialsClampsAndLoadsOfAStructure) {
  const Case c = read(pulled_case);
  const StructureCase& structure = c.structure.value();
  EXPECT_EQ(structure.bodies[0].material, "st_venant_kirchhoff");
  EXPECT_TRUE(structure.bodies[0].plane_stress);
  EXPECT_EQ(structure.bodies[0].mass_damping, 2);
  EXPECT_EQ(structure.bodies[0].clamps.size(), 1u);
  ASSERT_EQ(structure.clamps.size(), 1u);
  EXPECT_TRUE(structure.clamps[0].motion.has_value());
  ASSERT_EQ(structure.loads.size(), 2u);
  EXPECT_EQ(structure.loads[0].value[1](0, 0, 0.3), 0.3);
  EXPECT_EQ(structure.loads[1].kind, LoadCase::Kind::pressure);
  EXPECT_FALSE(structure.loads[1].region.has_value());
  EXPECT_EQ(c.gauges[0].text("clamp"), "root");
}

// Seen to fail: with the checks of read_load, check_structure and check_reaction removed, their cases are let through.
TEST_F(CaseFile, WhoseStructureMakesNoSenseIsRefused) {
  const std::string pulled = pulled_case;
  const auto changed = [&](const std::string& old_text, const std::string& new_text) { return replaced(pulled, old_text, new_text); };
  expect_refused(changed("st_venant_kirchhoff", "rubber"), {"case.toml:11:", "material", "\"neo_hookean\""});
  expect_refused(changed("mass_damping = 2", "mass_damping = 0"), {"case.toml:13:", "mass_damping [1/s]", "from 1e-12 to 1e+12"});
  expect_refused(changed("body = \"bar\"\nregion", "body = \"beam\"\nregion"), {"clamp 'root'", "'beam'", "only 'bar'"});
  expect_refused(changed("max = [0.05, 1]", "max = [0.02, 1]"), {"case.toml:14:", "clamp 'root' holds no particle", "0.05 m"});
  expect_refused(changed("pivot = [0, 0.1]", ""), {"case.toml:14:", "the clamp 'root' is rotated, but has no pivot"});
  expect_refused(changed("\"0.1*t\"", "\"0.1+t\""), {"the clamp 'root'", "at t = 0 instead of 0"});
  expect_refused(changed("min = [0.99, -1], max = [1.01, 1]", "min = [0.99, -1], max = [0.999, -0.5]"),
                 {"case.toml:20:", "load 'pull' acts on nothing", "point of the surface"});
  expect_refused(changed("traction =", "pressure = 1\ntraction ="), {"case.toml:20:", "'pull' has several of traction"});
  expect_refused(changed("pressure = \"10*x\"", ""), {"'squeeze' has none of traction"});
  expect_refused(changed("clamp = \"root\"", "clamp = \"tip\""), {"the gauge 'hold' names the clamp 'tip'"});
  expect_refused(changed("name = \"squeeze\"", "name = \"pull\""), {"'pull' is used twice in [[structure.load]]"});
}

// A plate in the water, cut out of it: between two layers of particles, half a spacing beside that, and a disc, which is curved.
// Seen to fail: without the look at the faces; with all particles within half a spacing counted (the disc).
TEST_F(CaseFile, FluidThatBeginsOnAFaceIsSaid) {
  const auto with_hole = [&](const char* hole, const char* plate) {
    const std::string fluid = replaced(small_case, "shape = { box = { min = [0, 0], max = [0.4, 0.5] } }",
                                       std::string("shape = { difference = [{ box = { min = [0, 0], max = [1, 0.5] } }, ") + hole + "] }");
    std::string text = replaced(fluid, "shape = { box = { min = [0.7, -0.1], max = [0.8, 0.5] } }", std::string("shape = ") + plate);
    text = replaced(text, "clamp = [{ box = { min = [0.6, -0.2], max = [0.9, 0] } }]", "");
    return read(replaced(text, "at = [0.75, 0.5]", "at = [0.55, 0.25]")).warnings;
  };
  const auto said = [](const std::vector<std::string>& warnings) {
    return std::any_of(warnings.begin(), warnings.end(),
                       [](const std::string& w) { return w.find("begin on its faces") != std::string::npos; });
  };
  const char *between = "{ box = { min = [0.5, 0], max = [0.6, 0.4] } }", *beside = "{ box = { min = [0.525, 0], max = [0.575, 0.4] } }",
             *disc = "{ ball = { center = [0.55, 0.25], radius = 0.13 } }";
  EXPECT_FALSE(said(with_hole(between, between)));
  EXPECT_TRUE(said(with_hole(beside, beside)));  // its sides are whole multiples of the spacing, their distances from the corner are not
  EXPECT_NE(with_hole(beside, beside)[0].find("its sides and their distances from that corner are whole multiples"), std::string::npos);
  EXPECT_FALSE(said(with_hole(disc, disc)));
  // Seen to fail: without or_move().
  const auto is_moved = [&](const char* hole) {
    return with_hole(hole, hole)[0].find("Here it is enough to move it by 0.025 m along x.") != std::string::npos;
  };
  EXPECT_TRUE(is_moved("{ box = { min = [0.525, 0], max = [0.625, 0.4] } }"));
  EXPECT_FALSE(is_moved("{ box = { min = [0.525, 0], max = [0.6, 0.4] } }")) << "the other face would then lie on a layer";
}

/// Whether a warning of the case holds all the parts.
void expect_warning(const Case& c, const std::vector<std::string>& parts) {
  const bool said = std::any_of(c.warnings.begin(), c.warnings.end(), [&](const std::string& warning) {
    return std::all_of(parts.begin(), parts.end(), [&](const auto& part) { return warning.find(part) != std::string::npos; });
  });
  EXPECT_TRUE(said) << parts[0] << "\nin: " << fmt::format("{}", fmt::join(c.warnings, "\n"));
}

// The small case is silent. Each seen to fail with its look left out.
TEST_F(CaseFile, WarnsOfWhatIsHardlyMeant) {
  EXPECT_TRUE(read(small_case).warnings.empty()) << fmt::format("{}", fmt::join(read(small_case).warnings, "\n"));
  expect_warning(read(with("young_modulus = 1e6", "young_modulus = 1")),
                 {"case.toml:19", "Young's modulus of 'plate' is 1 Pa", "its own weight presses with 6.47e+03 Pa"});
  expect_warning(read(with("spacing = 0.05", "spacing = 0.2")), {"fluid body 1 of", "less than the reach of the kernel"});
  expect_warning(read(with("[0, -9.81]", "[0, 9.81]")), {"draws the fluid to the open face y_max"});
  // Seen to fail: with nothing taken for a floor.
  const std::string hole = with("open = [\"y_max\"]", "open = [\"y_max\", \"y_min\"]"),
                    lid = "[[wall]]\nname = \"lid\"\nobstacle = { box = { min = [-0.1, -0.05], max = [X, 0] } }\n";
  expect_warning(read(hole), {"draws the fluid to the open face y_min"});
  expect_warning(read(hole + replaced(lid, "X", "0.35")), {"draws the fluid to the open face y_min"});
  EXPECT_TRUE(read(hole + replaced(lid, "X", "0.5")).warnings.empty());
  expect_warning(read(with("max = [0.4, 0.5]", "max = [0.4, 1.2]")), {"begins up to 0.2 m beyond the open face y_max"});
  expect_warning(read(with("end_time = 0.5", "end_time = 0.05")), {"nothing falls farther than 0.012 m", "Lengths are in metres"});
  const std::string sensor = "[[gauge]]\nkind = \"pressure\"\nname = \"p\"\nat = [0.75, 0.2]\n";
  expect_warning(read(small_case + sensor), {"the gauge 'p' at (0.75, 0.2) m is inside the elastic body 'plate'"});
  expect_warning(read(with("density = 1000", "density = 1000\nviscosity = 10")), {"does not drag on the elastic body 'plate'", "9.9"});
}

// The same scene in metres and in millimetres, in seconds and in milliseconds, has the same windows over the period of the load.
// Seen to fail: with windows of 1 ms where nothing moves yet.
TEST_F(CaseFile, HasWindowsThatResolveItsLoads) {
  const std::string load = "[[structure.load]]\nname = \"push\"\nbody = \"plate\"\ntraction = [\"F\", 0]\n";
  for (const char* period : {"0.1", "1e-4"}) {
    std::string text = replaced(small_case + replaced(load, "F", "10*sin(2*pi*t/T)"), "/T", std::string("/") + period);
    text = replaced(text, "end_time = 0.5", std::string("end_time = ") + period);
    EXPECT_NEAR(window_of_loads(read(text)) / std::stod(period), 1 / (16 * std::numbers::pi), 1e-5) << period;
  }
  // A load that sets in, and a blow, jump: no window resolves that. A ramp has the time that it takes.
  for (const char* jumps : {"t < 0.2 ? 0 : 10", "t < 1e-6 ? 10 : 0", "abs(t - 0.2) < 1e-3 ? 10 : 0"})
    EXPECT_EQ(window_of_loads(read(small_case + replaced(load, "F", jumps))), std::numeric_limits<double>::infinity()) << jumps;
  EXPECT_NEAR(window_of_loads(read(small_case + replaced(load, "F", "10*min(t/0.1,1)"))), 0.125 * std::sqrt((0.1 / 3 + 0.4) * 0.1), 1e-4);
  const Case constant_load = read(small_case + replaced(load, "F", "10"));
  EXPECT_EQ(window_of_loads(constant_load), std::numeric_limits<double>::infinity());
  EXPECT_LT(first_window(constant_load), 0.1) << "a body that is loaded may vibrate";
  EXPECT_EQ(first_window(read(small_case)), std::numeric_limits<double>::infinity());
  EXPECT_EQ(window_at_rest(read(small_case)), 0.01 * 0.5);
  const Case rammed = read(with("open = [", "displacement = [\"2*t^2\", 0]\nopen = ["));
  EXPECT_NEAR(window_at_rest(rammed), std::min({0.005, 0.1 * std::sqrt(0.05 / 4), 0.4 * 0.05 / 2}), 1e-4);
  const Case pushed = read(with("open = [", "displacement = [\"10*t\", 0]\nopen = ["));
  EXPECT_NEAR(window_at_rest(pushed), 0.4 * 0.05 / 10, 1e-6);
}

// Seen to fail: with faces that gravity does not press on counted; with bodies that hang from a clamp counted.
TEST_F(CaseFile, WarnsOfBodiesThatStandOnSomethingUnclamped) {
  const std::string clamp = "clamp = [{ box = { min = [0.6, -0.2], max = [0.9, 0] } }]\n";
  const std::string free =
      replaced(replaced(replaced(small_case, clamp, ""), "min = [0.7, -0.1]", "min = [0.7, 0]"), "density = 1100", "density = 2000");
  expect_warning(read(free), {"'plate' stands on the wall 'tank' at (", "but has no clamp", "structure.body.plate.clamp"});
  EXPECT_TRUE(read(replaced(free, "min = [0.7, 0]", "min = [0.7, 0.1]")).warnings.empty()) << "it falls";
  const std::string beside = replaced(free, "[0.7, 0], max = [0.8, 0.5]", "[0.9, 0.1], max = [1, 0.5]");
  EXPECT_TRUE(read(replaced(beside, "at = [0.75, 0.5]", "at = [0.95, 0.5]")).warnings.empty()) << "it slides along the wall";
  const std::string hung =
      replaced(with("min = [0.6, -0.2], max = [0.9, 0]", "min = [0.6, 0.4], max = [0.9, 0.6]"), "[0.7, -0.1]", "[0.7, 0]");
  EXPECT_TRUE(read(hung).warnings.empty()) << "its clamp bears it";
  const std::string other =
      "[[structure.body]]\nname = \"lid\"\nshape = { box = { min = [0.65, 0.5], max = [0.85, 0.6] } }\nspacing = 0.025\n"
      "density = 1100\nyoung_modulus = 1e6\npoisson_ratio = 0.4\n";
  expect_warning(read(replaced(small_case, "[[gauge]]", other + "[[gauge]]")), {"'lid' stands on the elastic body 'plate'"});
}

// Seen to fail: without the look at faces that gravity does not press on; with what is clamped looked at.
TEST_F(CaseFile, WarnsOfBodiesThatTouch) {
  const auto with_other = [&](const std::string& left) {
    const std::string other = "[[structure.body]]\nname = \"other\"\nshape = { box = { min = [" + left +
                              ", -0.1], max = [0.9, 0.4] } }\nspacing = 0.025\ndensity = 1100\nyoung_modulus = 1e6\n"
                              "poisson_ratio = 0.4\nclamp = [{ box = { min = [0.6, -0.2], max = [1, 0] } }]\n";
    return replaced(small_case, "[[gauge]]", other + "[[gauge]]");
  };
  expect_warning(read(with_other("0.8")), {"'plate' and 'other' touch at (0.8, ", "not joined", "Leave room"});
  EXPECT_TRUE(read(with_other("0.85")).warnings.empty());
  const std::string held =
      replaced(with_other("0.8"), "max = [1, 0] } }", "max = [1, 0] } }, { box = { min = [0.79, 0], max = [0.85, 0.45] } }");
  for (const std::string& warning : read(held).warnings) EXPECT_EQ(warning.find("touch at"), std::string::npos) << warning;
}

// Seen to fail: without the check.
TEST_F(CaseFile, OfANearlyIncompressibleBodyWarns) {
  expect_warning(read(with("poisson_ratio = 0.4", "poisson_ratio = 0.499")), {"'plate' is nearly incompressible", "0.499"});
  EXPECT_TRUE(read(with("poisson_ratio = 0.4", "poisson_ratio = 0.49")).warnings.empty());
}

// What is known to come out wrong is said beforehand. Seen to fail: without the check; with clamped bodies looked at as well.
TEST_F(CaseFile, WithAFreeBodyOfNearlyTheDensityOfItsFluidWarns) {
  const auto warned = [&](double density, const std::string& text) {
    const Case c = read(replaced(text, "density = 1100", fmt::format("density = {}", density)));
    return std::any_of(c.warnings.begin(), c.warnings.end(),
                       [](const std::string& w) { return w.find("is free and") != std::string::npos; });
  };
  const std::string free = replaced(with("clamp = [{ box = { min = [0.6, -0.2], max = [0.9, 0] } }]\n", ""), "[0.7, -0.1]", "[0.7, 0.1]");
  for (const double density : {900.0, 1020.0}) EXPECT_TRUE(warned(density, free)) << density;
  for (const double density : {500.0, 1000.0, 1500.0}) EXPECT_FALSE(warned(density, free)) << density;
  EXPECT_FALSE(warned(1020, small_case));
}

// Seen to fail: with the motion of the clamp, or of the wall, left out of the comparison.
TEST_F(CaseFile, WarnsOfAClampThatDoesNotMoveWithItsWall) {
  const std::string moving = with("open = [", "displacement = [\"0.4*t^2\", 0]\nopen = [");
  expect_warning(read(moving), {"'plate' is clamped in the wall 'tank'", "they move apart, by 0.1 m at t = 0.5 s"});
  const std::string foot =
      "[[structure.clamp]]\nname = \"foot\"\nbody = \"plate\"\nregion = { box = { min = [0.6, -0.2], max = [0.9, 0] } }\n"
      "displacement = [\"0.4*t^2\", 0]\n";
  const std::string held = replaced(moving, "clamp = [{ box = { min = [0.6, -0.2], max = [0.9, 0] } }]\n", "");
  EXPECT_TRUE(read(held + foot).warnings.empty());
  const std::string at_rest = replaced(small_case, "clamp = [{ box = { min = [0.6, -0.2], max = [0.9, 0] } }]\n", "");
  expect_warning(read(at_rest + foot), {"'plate' is clamped in the wall 'tank'"});
}

// Seen to fail: without the three looks; with the change of the whole interval for the largest one (as fast as the intervals); without the
// floor for round-off, and the ways compared at 4.5 in place of 2.5.
TEST_F(CaseFile, WarnsOfMotionsThatJumpOrStartAtSpeed) {
  const auto warnings = [&](const std::string& x) {
    const std::string text = replaced(with("open = [", "displacement = [\"" + x + "\", 0]\nopen = ["),
                                      "clamp = [{ box = { min = [0.6, -0.2], max = [0.9, 0] } }]\n", "");
    const std::string foot =
        "[[structure.clamp]]\nname = \"foot\"\nbody = \"plate\"\nregion = { box = { min = [0.6, -0.2], max = [0.9, 0] } }\n"
        "displacement = [\"" +
        x + "\", 0]\n";
    return read(text + foot);
  };
  for (const char* smooth : {"0.1*t^2", "0.01*(1-cos(60*t))", "t < 0.2 ? 0 : 0.1*(t-0.2)^2", "0.1*t^3", "1e-3*(1-cos(2020*pi*t))"})
    EXPECT_TRUE(warnings(smooth).warnings.empty()) << smooth << fmt::format("{}", fmt::join(warnings(smooth).warnings, "\n"));
  expect_warning(warnings("t < 0.2 ? 0 : 0.01"), {"the wall 'tank' jumps by 0.01 m at t = 0.2 s"});
  expect_warning(warnings("t < 0.2 ? 0 : 0.01"), {"the clamp 'foot' jumps by 0.01 m at t = 0.2 s"});
  expect_warning(warnings("0.01*sin(60*t)"), {"the wall 'tank' starts at 0.6 m/s"});
  expect_warning(warnings("0.05*t"), {"the clamp 'foot' starts at 0.05 m/s"});
  for (const char* mover : {"wall 'tank'", "clamp 'foot'"})
    expect_warning(warnings("t < 0.2 ? 0.1*t^2 : 0.004 + 0.02*(t-0.2)"),
                   {fmt::format("the velocity of the {} jumps by 0.02 m/s at t = 0.2 s", mover)});
}

}  // namespace
}  // namespace tern
