// Case files: what is read from them, what is refused as no case file, presets, defaults and the hash.

#include "scene/case_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "case_file_fixture.hpp"
#include "scene/estimate.hpp"

namespace tern {
namespace {

// Seen to fail with the reader of poisson_ratio pointed at young_modulus.
TEST_F(CaseFile, IsReadIntoTheCase) {
  const Case c = read(small_case);
  EXPECT_EQ(c.dimension, 2);
  EXPECT_EQ(c.end_time, 0.5);
  EXPECT_EQ(c.gravity[1](0), -9.81);
  EXPECT_EQ(c.name, std::filesystem::path(folder_.path()).filename().string());
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
  EXPECT_EQ(g.courant, 0.4);
  EXPECT_EQ(g.gravity_courant, f.gravity_courant);
  EXPECT_EQ(g.viscous_courant, f.viscous_courant);
  EXPECT_EQ(g.contact_distance, f.contact_distance);
  EXPECT_EQ(g.pressure_tolerance, f.pressure_tolerance);
  const StructureCase structure;
  const StructureNumerics &s = structure.numerics, &t = c.structure->numerics;
  EXPECT_EQ(t.smoothing_length_ratio, s.smoothing_length_ratio);
  EXPECT_EQ(t.riemann_diffusion, s.riemann_diffusion);
  EXPECT_EQ(t.courant, s.courant);
  EXPECT_EQ(t.integrator, Integrator::automatic) << "beside a fluid";
  EXPECT_EQ(s.integrator, Integrator::explicit_steps);
  EXPECT_EQ(c.coupling.algorithm, built.coupling.algorithm);
  EXPECT_EQ(c.coupling.max_iterations, built.coupling.max_iterations);
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
  EXPECT_EQ((std::vector<double>{s.smoothing_length_ratio, s.riemann_diffusion, s.courant}), (std::vector<double>{1.3, 0.8, 0.25}));
  EXPECT_EQ(s.integrator, Integrator::implicit_steps);
  EXPECT_EQ((std::vector<double>{c.coupling.tolerance.value(), c.coupling.riemann_limiter, c.coupling.robin_mass_factor,
                                 c.coupling.vem_coefficient.value(), c.output.frame_interval, c.output.gauge_interval}),
            (std::vector<double>{1e-3, 2.5, 0.9, 2, 0.2, 0.3}));
  EXPECT_EQ(c.coupling.vem_form, VemForm::sum);
}

// Seen to fail with the list of valid keys of the parent table searched.
TEST_F(CaseFile, WithAnUnknownKeyIsRefusedWithItsPlaceAndTheNearestKey) {
  expect_refused(with("spacing = 0.05", "spacng = 0.05"), {"case.toml:11:1", "unknown key 'spacng' in [fluid]", "'spacing'?"});
  expect_refused(with("density = 1000", "density = 1000\nyoung_modulus = 3"), {"it belongs in [structure.body]"});
  // Seen to fail: with the last of them alone.
  expect_refused(with("[fluid]", "[[wall]]\nvelocity = [1, 0]\n[fluid]"), {"it belongs in [fluid.body] or [structure.body]"});
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
  expect_refused(small_case, {"has to be a number", "; write 0.035."}, {{{"fluid.spacing", ".035"}}, ""});
  expect_refused(small_case, {"dimension is 2.0, but has to be a whole number"}, {{{"dimension", "2.0"}}, ""});  // seen to fail: "is 2"
  // Seen to fail: with a new table made of what names no element.
  for (const char* name : {"lid", "1"})
    expect_refused(small_case, {fmt::format("none of the 1 elements is called '{}'; use a position from 0 to 0, or a name: plate.", name)},
                   {{{fmt::format("structure.body.{}.spacing", name), "0.01"}}, ""});
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
  EXPECT_FALSE(read(small_case, {}).coupling.tolerance) << "absent: a window is done where the velocities agree";
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
  EXPECT_EQ(draft.fluid->numerics.gravity_courant, 0.1) << "not beside a structure";
  EXPECT_EQ(read_case(TERN_SOURCE_DIR "/cases/hydrostatic_tank", {{}, "draft"}).fluid->numerics.gravity_courant, 0.2);
  EXPECT_EQ(draft.structure->numerics.integrator, Integrator::automatic);
  EXPECT_FALSE(draft.coupling.tolerance);
  EXPECT_FALSE(reference.coupling.tolerance);
  const std::string stated =
      with("[[gauge]]", "[fluid.numerics]\npressure_tolerance = 1e-7\ncourant = 0.11\n[coupling]\ntolerance = 1e-3\n[[gauge]]");
  for (const std::string preset : {"draft", "reference"}) {
    const Case c = read(stated, {{}, preset});
    EXPECT_EQ(c.fluid->numerics.pressure_tolerance, 1e-7);
    EXPECT_EQ(c.fluid->numerics.courant, 0.11);
    EXPECT_EQ(c.coupling.tolerance, 1e-3);
  }
  EXPECT_NE(check_text(draft).find("fluid.spacing = 0.1 (0.05 in the case)"), std::string::npos) << check_text(draft);
  EXPECT_NE(explain_text(draft).find("Changed by the preset draft"), std::string::npos);
  EXPECT_EQ(check_text(read(small_case)).find("preset"), std::string::npos);
  const auto tells_of_repetition = [](const Case& c) {
    return explain_text(c).find("repeated where it is not enough") != std::string::npos;
  };
  EXPECT_TRUE(tells_of_repetition(read(small_case)));
  EXPECT_FALSE(tells_of_repetition(read(small_case, {{{"coupling.tolerance", "1e-4"}}, ""})))
      << "every window is";  // seen to fail: with what auto does said of every auto
  EXPECT_NE(draft.settings.find("\"spacing\":0.1"), std::string::npos) << draft.settings;
}

// Seen to fail: with twice the spacings alone ("it would be too soft").
TEST_F(CaseFile, ADraftIsAsCoarseAsTheCaseBears) {
  const Case ball = read_case(TERN_SOURCE_DIR "/cases/ball_drop", {}), draft = read_case(TERN_SOURCE_DIR "/cases/ball_drop", {{}, "draft"});
  EXPECT_DOUBLE_EQ(draft.structure->bodies[0].spacing, 1.25 * ball.structure->bodies[0].spacing) << "a shell bends on a given length";
  expect_refused(with("density = 1000", "density = -1000"), {"density"}, {{}, "draft"});
}

// Seen to fail with the hash taken of the file's text: a comment changed it, an override did not.
TEST_F(CaseFile, HasAHashOfTheEffectiveSettings) {
  const std::string hash = read(small_case).hash;
  EXPECT_EQ(hash.size(), 16u);
  EXPECT_EQ(read(std::string("# a comment\n") + small_case).hash, hash);
  EXPECT_EQ(read(with("density = 1000", "density = 1000.0")).hash, hash);
  EXPECT_EQ(read(with("[[gauge]]", "[fluid.numerics]\ncourant = 0.4\n[[gauge]]")).hash, hash) << "a default, spelled out";
  EXPECT_NE(read(small_case, {{{"fluid.density", "1001"}}, ""}).hash, hash);
  EXPECT_NE(read(with("density = 1000", "density = 1000.0000001")).hash, hash);
}

// Seen to fail with [coupling] filled in whatever the case has.
TEST_F(CaseFile, WithoutATableIsWithoutItsModel) {
  std::string text = small_case;
  text = text.substr(0, text.find("[[structure.body]]"));
  const Case fluid = read(text);
  EXPECT_FALSE(fluid.structure.has_value());
  EXPECT_EQ(fluid.settings.find("coupling"), std::string::npos);
  expect_refused(text + "[coupling]\ntolerance = 1e-3\n", {"[coupling] has no meaning in a case without [structure]"});
  expect_refused("dimension = 2\nend_time = 1\ngravity = [0, 0]\n", {"neither [fluid] nor [structure]"});
}

}  // namespace
}  // namespace tern
