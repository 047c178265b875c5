// The added-mass ratio that decides about explicit coupling, from the case and what the structure says of its faces.

#include <gtest/gtest.h>

#include "coupler/stability/added_mass.hpp"
#include "fixtures/interface_scenes.hpp"
#include "structure/structure.hpp"

namespace tern::coupler::testing {
namespace {

// The plate of the dam break: rho_F L/1.875 over half of rho_S T, 90 mm long, 4 mm thick, both faces exposed.
// Seen to fail: with the clamped part counted as length; with the mean of the section masses, which the tip's depth raises.
TEST(AddedMassPrediction, OfThePlateOfTheDamBreakIsThatOfItsFirstBendingMode) {
  const Case scene = read_case(std::string(TERN_SOURCE_DIR) + "/cases/dam_break_plate");
  const structure::Structure<2> plate(scene);
  const AddedMass added = predict_added_mass<2>(scene, plate.surface_properties());
  EXPECT_EQ(added.body, "plate");
  EXPECT_FALSE(added.by_depth);
  EXPECT_NEAR(added.length, 0.090 / 1.875104, 1e-9);
  EXPECT_NEAR(added.ratio, 997 * 0.090 / 1.875104 / (0.5 * 1161.54 * 0.004), 1e-6);
  EXPECT_NE(describe(added).find("m_a/m_s = 20.6 for 'plate'"), std::string::npos) << describe(added);
}

// Seen to fail: with the greatest extent of the fluid; with the first body's ratio instead of the largest; with the mean of
// the section masses.
TEST(AddedMassPrediction, IsBoundByTheFluidThereIsAndTakesTheWorstBody) {
  Case c = scene(2, 0.01);
  FluidBody layer;
  layer.shape = box({0, 0, 0}, {1, 0.05, 0});
  c.fluid->bodies.push_back(layer);
  c.structure->bodies[0].shape = box({0, -0.1, 0}, {1, 0, 0});
  c.structure->bodies[0].spacing = 0.01;
  c.structure->bodies.push_back(c.structure->bodies[0]);
  c.structure->bodies[1].name = "thin";
  SurfaceProperties faces = properties(6, 100);
  faces.body = {0, 0, 0, 1, 1, 1};
  faces.section_mass = {100, 100, 1e4, 20, 20, 1e4};
  const AddedMass added = predict_added_mass<2>(c, faces);
  EXPECT_EQ(added.body, "thin");
  EXPECT_TRUE(added.by_depth);
  EXPECT_NEAR(added.ratio, 1000 * 0.05 / 20, 1e-9);
}

}  // namespace
}  // namespace tern::coupler::testing
