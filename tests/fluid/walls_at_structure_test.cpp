// Walls where bodies stand at them: patches that a face cuts, and the images of particles that load it.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"
#include "fluid/boundary/line_of_sight.hpp"
#include "fluid/boundary/mirror_images.hpp"
#include "fluid/boundary/wall_clipping.hpp"

namespace tern::fluid::testing {
namespace {

constexpr double dx = 0.1;

/// A flat face at height y across a tank from x = 0 to 1 (and z = 0 to 1), looking up, of patches of dx/4.
template <int D>
Faces<D> lid(double y) {
  constexpr double size = 0.25 * dx;
  Faces<D> faces;
  for (int a = 0; a < 40; ++a)
    for (int b = 0; b < (D == 3 ? 40 : 1); ++b) {
      Vector<D> x = Vector<D>::Constant((b + 0.5) * size);
      x[0] = (a + 0.5) * size;
      x[1] = y;
      faces.position.push_back(x);
      faces.normal.push_back(Vector<D>::Unit(1));
      faces.velocity.push_back(Vector<D>::Zero());
      faces.area.push_back(D == 2 ? size : size * size);
      faces.normal_acceleration.push_back(0);
      faces.two_sided.push_back(1);
    }
  return faces;
}

template <int D>
void side_walls_end_at_the_lid() {
  const std::array<double, 3> top = {1, 1, D == 3 ? 1.0 : 0.0}, bottom = {0, -1, 0};
  const Walls<D> walls(scene(D, dx, {box({0, 0, 0}, {1, 0.5, top[2]})}, {tank(bottom, top, {"y_max"})}), dx, 0.3);
  FaceFinder<D> finder;
  finder.fill(walls.faces(), 0.3);
  ClippedWalls<D> seen;
  for (int step = 0; step <= 40; ++step) {
    const double y = -0.1 + 0.005 * step;
    seen.clip(walls.faces(), finder, lid<D>(y));
    // Above the lid, and the moment of that about y = 0, over a patch and more of way.
    double area = 0, moment = 0, below = 0;
    for (std::size_t k = 0; k < walls.faces().size(); ++k) {
      if (std::abs(walls.faces().normal[k][0]) < 0.5) continue;  // x = 0 and x = 1
      const double height = seen.faces().position[k][1];
      (height > y ? area : below) += seen.faces().area[k];
      if (height > y) moment += height * seen.faces().area[k];
    }
    EXPECT_NEAR(area, 2 * (1 - y), 1e-9) << "y = " << y;
    EXPECT_NEAR(moment, 1 - y * y, 1e-9) << "y = " << y;
    EXPECT_LE(below, 2 * (y + 1) + 1e-9) << "y = " << y;
  }
  // Without the lid all are whole again.
  seen.clip(walls.faces(), finder, {});
  for (std::size_t k = 0; k < walls.faces().size(); ++k) {
    EXPECT_EQ(seen.faces().area[k], walls.faces().area[k]);
    EXPECT_EQ(seen.faces().position[k], walls.faces().position[k]);
  }
}

// Seen to fail: with patches left whole; with their middle left where it was; without taking back the last window's cuts.
TEST(WallClipping, LeavesWhatIsBeforeTheFaceWhereverItStands) {
  side_walls_end_at_the_lid<2>();
  side_walls_end_at_the_lid<3>();
}

// Seen to fail: with the angle between wall and face left unasked.
TEST(WallClipping, AFaceThatLiesOnTheWallCutsNothing) {
  const Walls<2> walls(scene(2, dx, {box({0, 0, 0}, {1, 0.5, 0})}, {tank({0, 0, 0}, {1, 1, 0}, {"y_max"})}), dx, 0.3);
  FaceFinder<2> finder;
  finder.fill(walls.faces(), 0.3);
  Faces<2> below = lid<2>(0);
  for (auto& n : below.normal) n = -n;  // the under side of a block that rests on the floor between the walls, but for its ends
  below.position.erase(below.position.begin()), below.normal.erase(below.normal.begin()), below.area.erase(below.area.begin());
  below.position.pop_back(), below.normal.pop_back(), below.area.pop_back();
  ClippedWalls<2> seen;
  seen.clip(walls.faces(), finder, below);
  for (std::size_t k = 0; k < walls.faces().size(); ++k) EXPECT_EQ(seen.faces().area[k], walls.faces().area[k]);
}

// A block that rests on the floor may leave it; the floor below is a wall all along. Seen to fail with the patches below left out.
TEST(Walls, AreThereBelowABodyToo) {
  Case c = scene(2, dx, {box({0, 0, 0}, {1, 0.5, 0})}, {tank({0, 0, 0}, {1, 1, 0}, {"y_max"})});
  const double alone = static_cast<double>(Walls<2>(c, dx, 0.3).faces().size());
  c.structure.emplace();
  StructureBody block;
  block.shape = box({0.3, 0, 0}, {0.6, 0.2, 0});
  c.structure->bodies.push_back(block);
  EXPECT_EQ(static_cast<double>(Walls<2>(c, dx, 0.3).faces().size()), alone);
}

std::vector<Vector<2>> images_in_a_box(const Vector<2>& x, bool container, double width = 1) {
  WallCase wall = tank({0, 0, 0}, {width, 1, 0}, {});
  wall.container = container;
  const Walls<2> walls(scene(2, dx, {box({0, 0, 0}, {width, 1, 0})}, {wall}), dx, 0.3);
  FaceFinder<2> finder;
  finder.fill(walls.faces(), 0.3);
  FaceRows rows;
  see_faces<2>(std::vector<Vector<2>>{x}, walls.faces(), finder, rows);
  std::vector<Vector<2>> images;
  mirror_in_walls<2>(walls.faces(), rows, 0, x, 0.25 * dx, images);
  std::sort(images.begin(), images.end(), [](const auto& a, const auto& b) { return std::tie(a[0], a[1]) < std::tie(b[0], b[1]); });
  return images;
}

void expect_images(const std::vector<Vector<2>>& found, const std::vector<Vector<2>>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t m = 0; m < found.size(); ++m) EXPECT_LT((found[m] - expected[m]).norm(), 1e-12) << found[m].transpose();
}

// Seen to fail: with an image for every patch that is seen; without the image of the image.
TEST(MirrorImages, AreOneForEachWallAndOneForEachPairOfThem) {
  expect_images(images_in_a_box({0.5, 0.13}, true), {{0.5, -0.13}});
  expect_images(images_in_a_box({0.07, 0.13}, true), {{-0.07, -0.13}, {-0.07, 0.13}, {0.07, -0.13}});
  expect_images(images_in_a_box({0.5, 0.5}, true), {});
  // In a channel narrower than what a particle sees: both sides, each with the floor.
  expect_images(images_in_a_box({0.07, 0.05}, true, 0.15), {{-0.07, -0.05}, {-0.07, 0.05}, {0.07, -0.05}, {0.23, -0.05}, {0.23, 0.05}});
}

// Beside the edge of an obstacle one wall ends where the other begins. Seen to fail with patches that mirror beyond their end.
TEST(MirrorImages, AreNoneBeyondTheEndOfAWall) {
  expect_images(images_in_a_box({-0.04, 0.9}, false), {{0.04, 0.9}});
  expect_images(images_in_a_box({-0.04, 1.1}, false), {});
}

}  // namespace
}  // namespace tern::fluid::testing
