// Case files: what is read, what is refused and with which sentence.

#include "scene/case_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/error.hpp"
#include "fixtures/scratch_directory.hpp"
#include "scene/estimate.hpp"
#include "scene/parameter_table.hpp"

namespace tern {
namespace {

namespace fs = std::filesystem;

constexpr const char* small_case = R"(title = "small"
dimension = 2
end_time = 0.5
gravity = [0, -9.81]
[[wall]]
name = "tank"
container = { box = { min = [0, 0], max = [1, 1] } }
open = ["y_max"]
[fluid]
density = 1000
spacing = 0.05
[[fluid.body]]
shape = { box = { min = [0, 0], max = [0.4, 0.5] } }
[[structure.body]]
name = "plate"
shape = { box = { min = [0.7, -0.1], max = [0.8, 0.5] } }
spacing = 0.025
density = 1100
young_modulus = 1e6
poisson_ratio = 0.4
clamp = [{ box = { min = [0.6, -0.2], max = [0.9, 0] } }]
[[gauge]]
kind = "displacement"
name = "tip"
body = "plate"
at = [0.75, 0.5]
)";

class CaseFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("tern_case_file_test_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Case read(const std::string& text, const CaseOptions& options = {}) {
    std::ofstream(folder_ / "case.toml") << text;
    return read_case(folder_.string(), options);
  }

  // The small case with one piece of its text replaced.
  static std::string with(const std::string& old_text, const std::string& new_text) {
    std::string text = small_case;
    const auto at = text.find(old_text);
    EXPECT_NE(at, std::string::npos) << old_text;
    return text.replace(at, old_text.size(), new_text);
  }

  std::string sentence(const std::string& text, const CaseOptions& options = {}) {
    try {
      read(text, options);
    } catch (const BadInput& fault) {
      return fault.what();
    }
    return "";
  }

  void expect_refused(const std::string& text, const std::vector<std::string>& parts, const CaseOptions& options = {}) {
    const std::string found = sentence(text, options);
    for (const std::string& part : parts) EXPECT_NE(found.find(part), std::string::npos) << part << "\nin: " << found;
    EXPECT_TRUE(found.ends_with(".") || found.ends_with("?")) << found;
  }

  fs::path folder_;
};

// Seen to fail with the reader of poisson_ratio pointed at young_modulus.
TEST_F(CaseFile, IsReadIntoTheCase) {
  const Case c = read(small_case);
  EXPECT_EQ(c.dimension, 2);
  EXPECT_EQ(c.end_time, 0.5);
  EXPECT_EQ(c.gravity[1](0), -9.81);
  EXPECT_EQ(c.name, folder_.filename().string());
  ASSERT_EQ(c.walls.size(), 1u);
  EXPECT_TRUE(c.walls[0].container);
  EXPECT_EQ(c.walls[0].open, std::vector<std::string>{"y_max"});
  EXPECT_FALSE(c.walls[0].motion.has_value());
  ASSERT_TRUE(c.fluid && c.structure);
  EXPECT_EQ(c.fluid->bodies[0].shape.max[1], 0.5);
  const StructureBody& plate = c.structure->bodies.at(0);
  EXPECT_EQ(plate.poisson_ratio, 0.4);
  EXPECT_EQ(plate.young_modulus, 1e6);
  EXPECT_EQ(plate.clamps.size(), 1u);
  EXPECT_FALSE(c.coupling.vem_coefficient.has_value());
  EXPECT_EQ(c.gauges.at(0).point("at")[0], 0.75);
  EXPECT_EQ(c.domain_min[0], -0.5) << "half of the longest side of the walls";
}

// Seen to fail with the defaults of a table not taken: the numbers were whatever stood in memory.
TEST_F(CaseFile, HasTheDefaultsOfACaseBuiltInCode) {
  const Case c = read(small_case), built;
  const FluidCase fluid;
  const FluidNumerics &f = fluid.numerics, &g = c.fluid->numerics;
  EXPECT_EQ(g.smoothing_length_ratio, f.smoothing_length_ratio);
  EXPECT_EQ(g.gradient, f.gradient);
  EXPECT_EQ(g.blend_theta, f.blend_theta);
  EXPECT_EQ(g.density_relaxation, f.density_relaxation);
  EXPECT_EQ(g.shifting, f.shifting);
  EXPECT_EQ(g.noise_damping, f.noise_damping);
  EXPECT_EQ(g.courant, f.courant);
  EXPECT_EQ(g.courant, 0.15);
  EXPECT_EQ(g.gravity_courant, f.gravity_courant);
  EXPECT_EQ(g.viscous_courant, f.viscous_courant);
  EXPECT_EQ(g.contact_distance, f.contact_distance);
  EXPECT_EQ(g.pressure_tolerance, f.pressure_tolerance);
  const StructureCase structure;
  const StructureNumerics &s = structure.numerics, &t = c.structure->numerics;
  EXPECT_EQ(t.smoothing_length_ratio, s.smoothing_length_ratio);
  EXPECT_EQ(t.riemann_diffusion, s.riemann_diffusion);
  EXPECT_EQ(t.hourglass_penalty, s.hourglass_penalty);
  EXPECT_EQ(t.courant, s.courant);
  EXPECT_EQ(t.integrator, Integrator::automatic) << "beside a fluid";
  EXPECT_EQ(s.integrator, Integrator::explicit_steps);
  EXPECT_EQ(c.coupling.algorithm, built.coupling.algorithm);
  EXPECT_EQ(c.coupling.acceleration, built.coupling.acceleration);
  EXPECT_EQ(c.coupling.tolerance, built.coupling.tolerance);
  EXPECT_EQ(c.coupling.scheme, built.coupling.scheme);
  EXPECT_EQ(c.coupling.vem_form, built.coupling.vem_form);
  EXPECT_EQ(c.coupling.riemann_limiter, built.coupling.riemann_limiter);
  EXPECT_EQ(c.coupling.robin_mass_factor, built.coupling.robin_mass_factor);
  EXPECT_EQ(c.output.frame_interval, built.output.frame_interval);
}

// Each key of every table of numbers is set to another value by hand and found in its member. Seen to fail with two members of
// the fluid's numerics exchanged in their rows.
TEST_F(CaseFile, FillsTheMemberOfEachKey) {
  const Case c = read(small_case, {{{"fluid.numerics.smoothing_length_ratio", "1.6"},
                                    {"fluid.numerics.gradient", "sum"},
                                    {"fluid.numerics.blend_theta", "0.41"},
                                    {"fluid.numerics.density_relaxation", "0.03"},
                                    {"fluid.numerics.shifting", "0.7"},
                                    {"fluid.numerics.noise_damping", "0.31"},
                                    {"fluid.numerics.courant", "0.16"},
                                    {"fluid.numerics.gravity_courant", "0.17"},
                                    {"fluid.numerics.viscous_courant", "0.11"},
                                    {"fluid.numerics.contact_distance", "0.26"},
                                    {"fluid.numerics.pressure_tolerance", "1e-5"},
                                    {"structure.numerics.smoothing_length_ratio", "1.3"},
                                    {"structure.numerics.riemann_diffusion", "0.8"},
                                    {"structure.numerics.hourglass_penalty", "0.05"},
                                    {"structure.numerics.courant", "0.25"},
                                    {"structure.numerics.integrator", "implicit"},
                                    {"coupling.tolerance", "1e-3"},
                                    {"coupling.riemann_limiter", "2.5"},
                                    {"coupling.robin_mass_factor", "0.9"},
                                    {"coupling.vem.coefficient", "2"},
                                    {"coupling.vem.form", "sum"},
                                    {"output.frame_interval", "0.2"},
                                    {"output.gauge_interval", "0.3"}},
                                   ""});
  const FluidNumerics& f = c.fluid->numerics;
  EXPECT_EQ(f.gradient, GradientForm::sum);
  const std::vector<double> of_fluid{f.smoothing_length_ratio, f.blend_theta,       f.density_relaxation, f.shifting,
                                     f.noise_damping,          f.courant,           f.gravity_courant,    f.viscous_courant,
                                     f.contact_distance,       f.pressure_tolerance};
  EXPECT_EQ(of_fluid, (std::vector<double>{1.6, 0.41, 0.03, 0.7, 0.31, 0.16, 0.17, 0.11, 0.26, 1e-5}));
  const StructureNumerics& s = c.structure->numerics;
  EXPECT_EQ((std::vector<double>{s.smoothing_length_ratio, s.riemann_diffusion, s.hourglass_penalty, s.courant}),
            (std::vector<double>{1.3, 0.8, 0.05, 0.25}));
  EXPECT_EQ(s.integrator, Integrator::implicit_steps);
  EXPECT_EQ((std::vector<double>{c.coupling.tolerance, c.coupling.riemann_limiter, c.coupling.robin_mass_factor,
                                 c.coupling.vem_coefficient.value(), c.output.frame_interval, c.output.gauge_interval}),
            (std::vector<double>{1e-3, 2.5, 0.9, 2, 0.2, 0.3}));
  EXPECT_EQ(c.coupling.vem_form, VemForm::sum);
}

// Seen to fail with the list of valid keys of the parent table searched.
TEST_F(CaseFile, WithAnUnknownKeyIsRefusedWithItsPlaceAndTheNearestKey) {
  expect_refused(with("spacing = 0.05", "spacng = 0.05"), {"case.toml:11:1", "unknown key 'spacng' in [fluid]", "'spacing'?"});
  expect_refused(with("density = 1000", "density = 1000\nyoung_modulus = 3"), {"it belongs in [structure.body]"});
  expect_refused(with("[fluid]\n", "[fluid]\nsurface_tension = 0.07\n"), {":10:1", "the keys here are density, spacing"});
  expect_refused(with("box = { min = [0, 0], max = [0.4", "bux = { min = [0, 0], max = [0.4"), {":13:", "'bux'", "'box'?"});
}

// Seen to fail with the type check of numbers left out.
TEST_F(CaseFile, WithAMissingWrongOrOutOfRangeValueIsRefusedWithTableKeyUnitAndRange) {
  expect_refused(with("density = 1000\n", ""), {"case.toml:9:", "density [kg/m^3] of [fluid] is missing", "from 1e-09 to 1e+09"});
  expect_refused(with("density = 1000", "density = 0"), {":10:1", "density [kg/m^3] of [fluid] is 0", "from 1e-09 to 1e+09"});
  expect_refused(with("density = 1000", "density = \"heavy\""), {":10:1", "is \"heavy\"", "a number"});
  expect_refused(with("poisson_ratio = 0.4", "poisson_ratio = 0.5"), {"poisson_ratio", "0.5 (excluded)"});
  expect_refused(with("dimension = 2", "dimension = 2.0"), {":2:1", "a whole number from 2 to 3"});
  expect_refused(with("end_time = 0.5", "end_time = nan"), {"end_time [s]", "from 1e-09 to 2097152 (excluded)"});
  expect_refused(with("gravity = [0, -9.81]", "gravity = [0, -9.81, 0]"), {":4:1", "a list of 2 numbers or expressions"});
  expect_refused(with("gravity = [0, -9.81]", "gravity = [0, \"2*u\"]"), {":4:", "'2*u'", "position 3"});
  expect_refused(with("spacing = 0.05", "spacing = -0.05"), {"from 1e-09 to 1e+09"});
  expect_refused(with("[\"y_max\"]", "[\"y_mx\"]"), {":8:", "one of", "the nearest is \"y_max\""});
  expect_refused(with("dimension = 2\n", ""), {"dimension is missing"});
  expect_refused(with("dimension = 2", "dimension = 2\ncoupling = 3"), {":3:1", "[coupling] is 3", "has to be a table"});
}

// Seen to fail with the parser's own exception let through: the sentence had no remedy.
TEST_F(CaseFile, ThatIsNotTomlIsRefusedWithTheLine) {
  expect_refused(with("dimension = 2", "dimension = 2\ndimension = 3"), {"case.toml:3:", "not valid TOML"});
  expect_refused(with("[fluid]", "[fluid"), {"case.toml:9:", "not valid TOML"});
  expect_refused(with("[fluid]", "[=fluid]"), {"case.toml:9:", "not valid TOML", "'='"});
  expect_refused(with("dimension = 2", "gr\xc3\xb6\xc3\x9f\x65 = 2"), {"case.toml:2:", "not valid TOML"});  // an assumption of toml++ 3.3
  EXPECT_THROW(read_case("/nonexistent/case"), BadInput);
}

// Seen to fail with overrides applied after validation.
TEST_F(CaseFile, TakesOverridesFromTheCommandLineAndValidatesThem) {
  const Case c = read(small_case, {{{"fluid.spacing", "0.1"},
                                    {"structure.body.plate.spacing", "0.02"},
                                    {"structure.body.young_modulus", "2e6"},
                                    {"coupling.algorithm", "explicit"},
                                    {"coupling.scheme", "fsa"},
                                    {"coupling.vem.coefficient", "1"},
                                    {"coupling.vem.form", "sum"}},
                                   ""});
  EXPECT_EQ(c.fluid->spacing, 0.1);
  EXPECT_EQ(c.structure->bodies[0].spacing, 0.02);
  EXPECT_EQ(c.structure->bodies[0].young_modulus, 2e6);
  EXPECT_EQ(c.coupling.algorithm, CouplingAlgorithm::explicit_staggering);
  EXPECT_EQ(c.coupling.scheme, InterfaceScheme::fsa);
  EXPECT_EQ(c.coupling.vem_coefficient, 1.0);
  EXPECT_EQ(c.coupling.vem_form, VemForm::sum);
  expect_refused(small_case, {"--set fluid.spacng: unknown key", "'spacing'?"}, {{{"fluid.spacng", "1"}}, ""});
  expect_refused(small_case, {"--set fluid.density", "from 1e-09 to 1e+09"}, {{{"fluid.density", "-1"}}, ""});
  expect_refused(small_case, {"--set title.x", "not a table"}, {{{"title.x", "1"}}, ""});
  expect_refused(small_case, {"--preset fast", "standard", "paper"}, {{}, "fast"});
}

// Seen to fail: with the preset applied after --set; with keys of the case kept; with --set preset=paper not among what chooses it.
TEST_F(CaseFile, ThePaperPresetReplacesTheInteractionOfTheCaseButNotWhatIsSet) {
  const Case c = read(small_case, {{{"coupling.vem.coefficient", "2"}}, "paper"});
  EXPECT_EQ(c.coupling.algorithm, CouplingAlgorithm::explicit_staggering);
  EXPECT_EQ(c.coupling.vem_form, VemForm::seed);
  EXPECT_EQ(c.coupling.vem_coefficient, 2.0);
  const Case set = read(small_case, {{{"coupling.vem.coefficient", "2"}, {"preset", "paper"}}, ""});
  EXPECT_EQ(set.settings, c.settings);
  EXPECT_EQ(read(small_case, {}).coupling.algorithm, CouplingAlgorithm::automatic);
  EXPECT_EQ(
      read(small_case, {{{"coupling.algorithm", "implicit"}, {"coupling.acceleration", "aitken"}, {"coupling.tolerance", "0.01"}}, ""})
          .coupling.acceleration,
      Acceleration::aitken);
}

// Seen to fail: with the factors of draft and reference exchanged; with a body coarsened below four particles across; with an
// option of the case replaced; with the preset applied after --set.
TEST_F(CaseFile, DraftAndReferenceScaleTheSpacingsAndKeepTheOptionsOfTheCase) {
  const Case draft = read(small_case, {{}, "draft"}), reference = read(small_case, {{}, "reference"});
  EXPECT_EQ(draft.fluid->spacing, 0.1);
  EXPECT_EQ(draft.structure->bodies[0].spacing, 0.025) << "four across: as coarse as it may be";
  EXPECT_EQ(reference.fluid->spacing, 0.025);
  EXPECT_EQ(reference.structure->bodies[0].spacing, 0.0125);
  EXPECT_EQ(read(with("spacing = 0.025", "spacing = 0.0125"), {{}, "draft"}).structure->bodies[0].spacing, 0.025);
  EXPECT_EQ(read(small_case, {{{"fluid.spacing", "0.05"}}, "draft"}).fluid->spacing, 0.05);
  EXPECT_EQ(draft.fluid->numerics.courant, 0.3);
  EXPECT_EQ(draft.fluid->numerics.gravity_courant, 0.1) << "not beside a structure";
  EXPECT_EQ(read_case(TERN_SOURCE_DIR "/cases/hydrostatic_tank", {{}, "draft"}).fluid->numerics.gravity_courant, 0.2);
  EXPECT_EQ(draft.structure->numerics.integrator, Integrator::automatic);
  EXPECT_EQ(draft.coupling.algorithm, CouplingAlgorithm::automatic);
  EXPECT_EQ(reference.coupling.algorithm, CouplingAlgorithm::implicit);
  const std::string stated = with(
      "[[gauge]]", "[fluid.numerics]\npressure_tolerance = 1e-7\ncourant = 0.11\n[coupling]\nalgorithm = \"semi-implicit\"\n[[gauge]]");
  for (const std::string preset : {"draft", "reference"}) {
    const Case c = read(stated, {{}, preset});
    EXPECT_EQ(c.fluid->numerics.pressure_tolerance, 1e-7);
    EXPECT_EQ(c.fluid->numerics.courant, 0.11);
    EXPECT_EQ(c.coupling.algorithm, CouplingAlgorithm::semi_implicit);
  }
  EXPECT_NE(check_text(draft).find("fluid.spacing = 0.1 (0.05 in the case)"), std::string::npos) << check_text(draft);
  EXPECT_NE(explain_text(draft).find("Changed by the preset draft"), std::string::npos);
  EXPECT_EQ(check_text(read(small_case)).find("preset"), std::string::npos);
  EXPECT_NE(draft.settings.find("\"spacing\":0.1"), std::string::npos) << draft.settings;
}

// Seen to fail with the hash taken of the file's text: a comment changed it, an override did not.
TEST_F(CaseFile, HasAHashOfTheEffectiveSettings) {
  const std::string hash = read(small_case).hash;
  EXPECT_EQ(hash.size(), 16u);
  EXPECT_EQ(read(std::string("# a comment\n") + small_case).hash, hash);
  EXPECT_EQ(read(with("density = 1000", "density = 1000.0")).hash, hash);
  EXPECT_EQ(read(with("[[gauge]]", "[fluid.numerics]\ncourant = 0.15\n[[gauge]]")).hash, hash) << "a default, spelled out";
  EXPECT_NE(read(small_case, {{{"fluid.density", "1001"}}, ""}).hash, hash);
  EXPECT_NE(read(with("density = 1000", "density = 1000.0000001")).hash, hash);
}

// Each seen to fail with its check left out (but for the limit on particles, which would fill the memory).
TEST_F(CaseFile, WhoseSceneMakesNoSenseIsRefused) {
  expect_refused(with("max = [0.4, 0.5]", "max = [1.1, 0.5]"), {"fluid body 1 reaches out of the container"});
  expect_refused(with("max = [0.4, 0.5]", "max = [0.75, 0.5]"), {"'plate' and fluid body 1 overlap"});
  expect_refused(with("max = [0.4, 0.5]", "max = [0.02, 0.02]"), {"holds no particle"});
  expect_refused(with("[0.7, -0.1], max = [0.8, 0.5]", "[0.7, -0.1], max = [1.2, 0.5]"),
                 {"'plate' stands outside the container", "structure.body.plate.shape", "structure.body.plate.clamp"});
  expect_refused(with("{ box = { min = [0.6, -0.2], max = [0.9, 0] } }", ""), {"'plate' stands outside the container"});
  expect_refused(with("min = [0.6, -0.2], max = [0.9, 0]", "min = [2, 2], max = [3, 3]"), {"stands outside"});
  expect_refused(with("[{ box = { min = [0.6", "[{ ball = { center = [9, 9], radius = 1 } }, { box = { min = [0.6"),
                 {"clamp 1 of 'plate' holds none"});
  expect_refused(with("max = [0.9, 0]", "max = [0.9, 1]"), {"hold all of its"});
  expect_refused(with("spacing = 0.025", "spacing = 0.06"), {"1.67 particles across", "at least 2"});
  expect_refused(with("spacing = 0.05", "spacing = 1e-7"), {"at most"});
  expect_refused(with("body = \"plate\"", "body = \"plat\""), {"names the elastic body 'plat'", "only 'plate'"});
  expect_refused(with("at = [0.75, 0.5]", "at = [0.75, 0.6]"), {"no point of the undeformed body"});
  expect_refused(with("at = [0.75, 0.5]\n", ""), {"needs the key 'at'"});
  expect_refused(with("max = [0.4, 0.5]", "max = [0, 0.5]"), {"min has to be less than max"});
  expect_refused(with("open = [", "displacement = [\"t+1\", 0]\nopen = ["), {"1 m at t = 0"});
  expect_refused(with("open = [", "displacement = [\"t*x\", 0]\nopen = ["), {"depends on the place"});
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
  EXPECT_EQ(c.structure->numerics.integrator, Integrator::explicit_steps);
  EXPECT_TRUE(c.warnings.empty());
  const BodyEstimate body = estimate(c).bodies[0];
  EXPECT_EQ(body.particles, 21) << "20 spacings of 0.0244 m, the last one a half; one particle on the clamp";
  EXPECT_EQ(body.clamped, 1);
  EXPECT_NEAR(body.thickness, 0.02, 1e-15);
  EXPECT_NEAR(body.wave_speed, std::sqrt(1e6 / (1 - 0.16) / 1100), 1e-12);
}

// With a check left out no sentence comes, or another one.
TEST_F(CaseFile, RefusesWhatAShellDoesNotModel) {
  const auto changed = [](const std::string& old_text, const std::string& new_text) {
    std::string text = shell_case();
    const auto at = text.find(old_text);
    EXPECT_NE(at, std::string::npos) << old_text;
    return text.replace(at, old_text.size(), new_text);
  };
  expect_refused(shell_case() + "[structure.numerics]\nintegrator = \"implicit\"\n", {"case.toml:14", "'plate'", "explicit steps only"});
  expect_refused(changed("{ box = { min = [0.74, -0.1], max = [0.76, 0.5] } }", "{ ball = { center = [0.75, 0.2], radius = 0.1 } }"),
                 {"'plate' is not a box", "model it as a solid"});
  expect_refused(changed("max = [0.9, 0] } }]", "max = [0.75, 0] } }]"), {"clamp that is not a box over one whole edge"});
  expect_refused(changed("max = [0.9, 0] } }]", "max = [0.9, -0.11] } }]"), {"clamp that is not a box over one whole edge"});
  expect_refused(changed("poisson_ratio", "material = \"mooney_rivlin\"\npoisson_ratio"), {"mooney_rivlin", "no law of a layer"});
  expect_refused(changed("spacing = 0.025\n", "spacing = 0.15\n"), {"has 3 free particles over 0.5 m in direction y", "at most 0.111 m"});
  expect_refused(changed("at = [0.75, 0.5]", "at = [0.76, 0.5]"), {"'tip'", "is not on the mid-surface of the shell 'plate', x = 0.75 m"});
  expect_refused(changed("clamp = [{ box = { min = [0.6, -0.2], max = [0.9, 0] } }]\n",
                         "[[structure.clamp]]\nname = \"hand\"\nbody = \"plate\"\nregion = { box = { min = [0.6, -0.2], max = [0.9, 0] } "
                         "}\ndisplacement = [\"t\", 0]\n"),
                 {"the clamp 'hand' of the shell 'plate' moves"});
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
  const Case between = read(text);
  ASSERT_EQ(between.warnings.size(), 2u);
  EXPECT_NE(between.warnings[0].find("is 15 thicknesses long between two clamps; without transverse shear it bends 7.1 % too little"),
            std::string::npos)
      << between.warnings[0];
  EXPECT_NE(between.warnings[1].find("has 11 particles between two clamps; it bends 11 % too much"), std::string::npos)
      << between.warnings[1];
}

// Seen to fail with the warning's limit at 3.
TEST_F(CaseFile, WarnsOfABodyFewerThanFourParticlesThick) {
  EXPECT_TRUE(read(small_case).warnings.empty());
  const Case c = read(with("spacing = 0.025", "spacing = 0.0334"));
  ASSERT_EQ(c.warnings.size(), 1u);
  EXPECT_NE(c.warnings[0].find("2.99 particles across"), std::string::npos) << c.warnings[0];
}

// Seen to fail: without check_mass().
TEST_F(CaseFile, WarnsOfParticlesThatHaveAnotherMassThanTheBodyAndRefusesThemFromFivePercentOn) {
  const Case c = read(with("spacing = 0.025", "spacing = 0.0335"));
  ASSERT_EQ(c.warnings.size(), 2u);
  EXPECT_NE(c.warnings[1].find("the 54 particles of the elastic body 'plate' have 1 % more mass than its shape"), std::string::npos)
      << c.warnings[1];
  EXPECT_NE(c.warnings[1].find("fits better than 0.0335 m"), std::string::npos) << c.warnings[1];
  expect_refused(with("spacing = 0.025", "spacing = 0.03"), {"10 % less mass than its shape", "a spacing of 0.025 m"});
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

// Seen to fail with [coupling] filled in whatever the case has.
TEST_F(CaseFile, WithoutATableIsWithoutItsModel) {
  std::string text = small_case;
  text = text.substr(0, text.find("[[structure.body]]"));
  const Case fluid = read(text);
  EXPECT_FALSE(fluid.structure.has_value());
  EXPECT_EQ(fluid.settings.find("coupling"), std::string::npos);
  expect_refused(text + "[coupling]\nalgorithm = \"semi-implicit\"\n", {"[coupling] has no meaning in a case without [structure]"});
  expect_refused("dimension = 2\nend_time = 1\ngravity = [0, 0]\n", {"neither [fluid] nor [structure]"});
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
  const auto changed = [&](const std::string& old_text, const std::string& new_text) {
    std::string text = channel;
    const auto at = text.find(old_text);
    EXPECT_NE(at, std::string::npos) << old_text;
    return text.replace(at, old_text.size(), new_text);
  };
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
  expect_refused(changed("open =", "displacement = [\"0.1*t\", 0]\nopen ="), {"case.toml:8:", "moves in the periodic direction x"});
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
  const auto changed = [&](const std::string& old_text, const std::string& new_text) {
    std::string text = pulled;
    const auto at = text.find(old_text);
    EXPECT_NE(at, std::string::npos) << old_text;
    return text.replace(at, old_text.size(), new_text);
  };
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

// c_p = sqrt(E (1 - nu)/(rho (1 + nu)(1 - 2 nu))); seen to fail with the plane-stress speed.
TEST_F(CaseFile, IsEstimatedFromItsStepLimits) {
  const Estimate e = estimate(read_case(TERN_SOURCE_DIR "/cases/dam_break_plate"));
  EXPECT_EQ(e.fluid_particles, 5000);
  ASSERT_EQ(e.bodies.size(), 1u);
  EXPECT_EQ(e.bodies[0].particles, 400);
  EXPECT_EQ(e.bodies[0].clamped, 40);
  EXPECT_EQ(e.bodies[0].surface_points, 184);
  EXPECT_NEAR(e.bodies[0].wave_speed, 106.9, 0.1);
  EXPECT_NEAR(e.bodies[0].sub_step, 2.81e-6, 1e-8);
  EXPECT_NEAR(e.bodies[0].thickness, 0.004, 1e-12);
  EXPECT_NEAR(e.bodies[0].added_mass_ratio, 10.3, 0.1);
  EXPECT_NEAR(e.flow_step, 0.15 * 0.004 / std::sqrt(2 * 9.81 * 0.398), 1e-7);
  EXPECT_TRUE(estimate(read_case(TERN_SOURCE_DIR "/cases/hydrostatic_tank")).settled);
}

// A structure alone: a step is a window of at most 100 sub-steps (10 under a load) that ends with an output, as in the run; an
// implicit one costs a window, not a sub-step. tensile_bar has 17 sub-steps between two rows of gauges, in two
// windows; gray_cantilever 109, in two. Seen to fail: with sub-steps counted as steps.
TEST_F(CaseFile, AloneTheStructureIsEstimatedInItsWindows) {
  const Case bar = read_case(TERN_SOURCE_DIR "/cases/tensile_bar");
  Estimate e = estimate(bar);
  EXPECT_NEAR(e.steps, 480, 1);
  EXPECT_NEAR(e.step, 5e-5, 1e-12);
  EXPECT_EQ(e.sub_steps, 9);
  EXPECT_NE(check_text(bar).find("about 480 steps"), std::string::npos) << check_text(bar);
  EXPECT_NE(check_text(bar).find(" of the structure in a step, 5e-05 s"), std::string::npos) << check_text(bar);
  e = estimate(read_case(TERN_SOURCE_DIR "/cases/gray_cantilever"));
  EXPECT_NEAR(e.steps, 1600, 1);
  const CaseOptions implicit{.overrides = {{"structure.numerics.integrator", "implicit"}, {"output.gauge_interval", "0"}}, .preset = ""};
  const Estimate by_windows = estimate(read_case(TERN_SOURCE_DIR "/cases/gray_cantilever", implicit));
  EXPECT_LE(by_windows.sub_steps, 100);
  EXPECT_NEAR(by_windows.structure_cpu / e.structure_cpu * e.steps * e.sub_steps, by_windows.steps * implicit_window, 1);
}

// Seen to fail: with the costs of the file read but not used.
TEST(Estimate, TakesTheCostsOfThisMachineWhereTheyAreMeasured) {
  const ScratchDirectory out;
  const std::string path = out / "costs.json";
  std::ofstream(path) << R"({"measured": "2030-01-02", "fluid_s": 4e-6, "structure_s": 1.6e-7, "window_s": 1e-3,
                             "fluid_parts": {"neighbours": 0.25, "pressure_solve": 0.75}})";
  const Case scene = read_case(TERN_SOURCE_DIR "/cases/dam_break_plate");
  const Costs costs = read_costs(path);
  const Estimate typical = estimate(scene), measured = estimate(scene, costs);
  EXPECT_NEAR(measured.fluid_cpu, 2 * typical.fluid_cpu, 1e-9);
  EXPECT_NEAR(measured.structure_cpu, 2 * typical.structure_cpu, 1e-9);
  EXPECT_NEAR(measured.coupler_cpu, 1e-3 * measured.steps, 1e-9);
  EXPECT_EQ(measured.steps, typical.steps);
  EXPECT_NE(explain_text(scene, costs).find("neighbours 25 %, pressure solve 75 %"), std::string::npos) << explain_text(scene, costs);
  EXPECT_NE(explain_text(scene, costs).find("measured on this machine on 2030-01-02"), std::string::npos);
  EXPECT_NE(explain_text(scene).find("typical costs"), std::string::npos);
  EXPECT_EQ(estimate(read_case(TERN_SOURCE_DIR "/cases/hydrostatic_tank"), costs).coupler_cpu, 0);
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
    return explain_text(read_case(TERN_SOURCE_DIR "/cases/dam_break_plate", options));
  };
  // 31 kg/m^2, half a layer of 4 mm has 2
  EXPECT_NE(text("7800").find("one pass a window, repeated where it is not enough"), std::string::npos);
  EXPECT_NE(text("700").find("every window is repeated if both are wet"), std::string::npos);  // 2.8, 1.4
  EXPECT_NE(text("100").find("it is light, so that every window is repeated"), std::string::npos);
}

// Seen to fail with a key added to the table and the document left as it was.
TEST(ParameterReference, IsTheCommittedDocument) {
  std::ifstream file(TERN_SOURCE_DIR "/docs/PARAMETERS.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), parameter_reference()) << "Run: tern-case parameters > docs/PARAMETERS.md";
}

}  // namespace
}  // namespace tern
