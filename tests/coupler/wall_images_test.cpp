// A face that meets a wall: the images of the fluid behind the wall give it the load of its whole half space.

#include <gtest/gtest.h>

#include "fixtures/interface_scenes.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double dx = 0.01;

/// A face y = 0 from x = 0 to 0.2 whose left end is at a wall x = 0, four layers of water over it to x = 0.3, and, if asked for,
/// their images.
struct Corner {
  Surface<2> surface;
  InterfaceParticles<2> particles;

  explicit Corner(bool images) {
    for (int k = 0; k < 40; ++k) add_point<2>(surface, {(k + 0.5) * 0.5 * dx, 0.0}, {0.0, 1.0}, 0.5 * dx);
    // The side of the body, which lies on the wall.
    for (int k = 0; k < 10; ++k) {
      particles.covered.push_back(static_cast<std::uint32_t>(surface.position.size()));
      add_point<2>(surface, {0.0, -(k + 0.5) * 0.5 * dx}, {-1.0, 0.0}, 0.5 * dx);
    }
    for (int i = 0; i < 30; ++i)
      for (int j = 0; j < 4; ++j) {
        add_particle<2>(particles, {(i + 0.5) * dx, (j + 0.5) * dx}, dx);
        if (!images || i > 3) continue;
        particles.image_of.push_back(static_cast<std::uint32_t>(particles.id.size() - 1));
        particles.image_position.push_back({-(i + 0.5) * dx, (j + 0.5) * dx});
      }
  }
};

/// Loads of all points under the pressure p = 1000 Pa everywhere, over p A, and the largest force on the fluid that has no reaction.
std::vector<double> loads(InterfaceScheme scheme, bool images, double& unbalanced) {
  Corner corner(images);
  Case c = scene(2, dx);
  c.coupling.scheme = scheme;
  Coupler<2> coupler(c, properties(corner.surface.position.size()));
  coupler.first_exchange(0, 1e-3, corner.surface, corner.particles);
  coupler.last_exchange(pressure_field<2>(corner.particles, [](const Vector<2>&) { return 1000.0; }));
  unbalanced = coupler.audit().force_error;
  std::vector<double> load;
  for (std::size_t k = 0; k < corner.surface.position.size(); ++k)
    load.push_back(-coupler.surface_load().force[k].dot(corner.surface.normal[k]) / (1000 * corner.surface.area[k]));
  return load;
}

/// What the pairs fill of the half space before each point of the face.
std::vector<double> filled(bool images) {
  const Corner corner(images);
  InterfacePairs<2> pairs(1.5 * dx, dx);
  pairs.find(corner.particles, corner.surface);
  std::vector<double> share(corner.surface.position.size(), 0);
  for (const auto& pair : pairs.all_pairs())
    share[pair.point] -= pair.b.dot(corner.surface.normal[pair.point]) / corner.surface.area[pair.point];
  return share;
}

// Each point within one support of the wall has less than its half space without images: over the face 0.278 dx are missing.
// Seen to fail: with the images left out of the pairs.
TEST(WallImages, FillTheHalfSpaceOfAFaceThatMeetsAWall) {
  const auto without = filled(false), with = filled(true);
  double missing = 0;
  for (int k = 0; k < 30; ++k) {
    EXPECT_NEAR(with[k], 1, 2e-4) << "point " << k;
    missing += 0.5 * (1 - without[k]);
  }
  EXPECT_NEAR(missing, 0.278, 2e-3);
}

// Seen to fail: with the images left out of the pairs; with images before faces that their particles do not see.
TEST(WallImages, CompleteTheLoadOfAFaceThatMeetsAWall) {
  for (const auto& [scheme, key, meaning] : interface_schemes) {
    SCOPED_TRACE("scheme " + std::to_string(static_cast<int>(scheme)));
    double unbalanced;
    const auto without = loads(scheme, false, unbalanced), with = loads(scheme, true, unbalanced);
    EXPECT_LT(unbalanced, 1e-14);
    double missing = 0;
    for (int k = 0; k < 30; ++k) {
      EXPECT_NEAR(with[k], 1, 2e-4) << "point " << k;
      missing += 0.5 * (1 - without[k]);
    }
    EXPECT_GT(missing, 0.05);
    for (int k = 40; k < 50; ++k) EXPECT_EQ(with[k], 0) << "no water between body and wall, point " << k;
  }
}

}  // namespace
}  // namespace tern::coupler::testing
