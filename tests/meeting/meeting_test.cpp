// Bodies that enter each other, themselves or a wall are noticed with names and depth; what slides, turns away or starts there is not.

#include "meeting/meeting.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "base/error.hpp"
#include "fixtures/shapes.hpp"

namespace tern {
namespace {

constexpr double patch = 0.01;

/// Bodies in a tank of 1 m, each a sampled shape that can be moved as a whole.
template <int D>
struct Scene {
  Case scene;
  std::vector<std::uint32_t> body;
  Surface<D> surface;
  MeetingState<D> state;

  Scene() {
    WallCase tank;
    tank.name = "tank";
    tank.container = true;
    tank.open = {"y_max"};
    tank.shape = box({0, 0, 0}, {1, 1, 1});
    scene.walls.push_back(tank);
    scene.structure.emplace();
  }

  void add(const std::string& name, const Shape& shape, double length = patch) {
    const SurfacePoints<D> points = sample_surface<D>(shape, length);
    surface.position.insert(surface.position.end(), points.position.begin(), points.position.end());
    surface.normal.insert(surface.normal.end(), points.normal.begin(), points.normal.end());
    surface.area.insert(surface.area.end(), points.area.begin(), points.area.end());
    body.resize(surface.position.size(), static_cast<std::uint32_t>(scene.structure->bodies.size()));
    scene.structure->bodies.emplace_back().name = name;
  }

  void move(std::uint32_t which, const Vector<D>& shift) {
    for (std::size_t k = 0; k < body.size(); ++k)
      if (body[k] == which) surface.position[k] += shift;
  }

  /// What is said of the present surface; empty: nothing.
  std::string look(double time = 0) {
    try {
      watch_meetings<D>(Meetable(scene, body), time, surface, state);
    } catch (const NumericalFailure& failure) {
      return failure.what();
    }
    return "";
  }
};

template <int D>
Vector<D> along(int axis, double length) {
  return length * Vector<D>::Unit(axis);
}

/// Moves a body in steps of a fifth of a patch until something is said; how far it came.
template <int D>
double way_until_said(Scene<D>& scene, std::uint32_t which, const Vector<D>& direction, std::string& said) {
  EXPECT_EQ(scene.look(), "");
  double way = 0;
  while (way < 1) {
    scene.move(which, 0.2 * patch * direction);
    way += 0.2 * patch;
    if (!(said = scene.look()).empty()) return way;
  }
  return way;
}

// Seen to fail: without compare_bodies(); with a clearance that is too large (4 for 0.5); with the deepest of the near patches.
TEST(Meeting, OfTwoBodiesIsSaidBeforeTheyAreAPatchDeepInEachOther) {
  for (double coarse : {1.0, 1.7}) {
    Scene<2> scene;
    scene.add("ball", ball({0.5, 0.5, 0}, 0.1), coarse * patch);
    scene.add("plate", box({0.2, 0.3, 0}, {0.8, 0.32, 0}));
    std::string said;
    const double way = way_until_said<2>(scene, 0, along<2>(1, -1), said);
    EXPECT_GT(way, 0.08 + 0.05 * patch);
    EXPECT_LT(way, 0.08 + 0.5 * patch);
    EXPECT_NE(said.find("'ball'"), std::string::npos) << said;
    EXPECT_NE(said.find("'plate'"), std::string::npos) << said;
  }
  Scene<3> cubes;
  cubes.add("upper", box({0.4, 0.6, 0.4}, {0.5, 0.7, 0.5}));
  cubes.add("lower", box({0.45, 0.4, 0.33}, {0.6, 0.5, 0.47}));
  std::string said;
  const double way = way_until_said<3>(cubes, 0, along<3>(1, -1), said);
  EXPECT_GT(way, 0.1 + 0.05 * patch);
  EXPECT_LT(way, 0.1 + 0.5 * patch);
}

// Past each other at a tenth of a patch, face along face, corner past corner.
TEST(Meeting, IsNotSaidOfBodiesThatPassEachOther) {
  for (double gap : {0.0, 0.1 * patch, 0.6 * patch}) {
    Scene<2> scene;
    scene.add("left", box({0.3, 0.3, 0}, {0.4, 0.4, 0}));
    scene.add("right", box({0.4 + gap, 0.55, 0}, {0.5 + gap, 0.65, 0}));
    std::string said;
    way_until_said<2>(scene, 0, along<2>(1, 1), said);
    EXPECT_EQ(said.substr(0, 40), "") << gap;
  }
}

TEST(Meeting, OfABodyWithAWallIsSaid) {
  Scene<2> scene;
  scene.add("ball", ball({0.5, 0.5, 0}, 0.1));
  std::string said;
  const double way = way_until_said<2>(scene, 0, along<2>(1, -1), said);
  EXPECT_GT(way, 0.4 + 0.05 * patch);
  EXPECT_LT(way, 0.4 + 0.5 * patch);
  EXPECT_NE(said.find("the wall 'tank'"), std::string::npos) << said;

  Scene<2> up;
  up.add("ball", ball({0.5, 0.5, 0}, 0.1));
  EXPECT_GE(way_until_said<2>(up, 0, along<2>(1, 1), said), 1) << "the tank is open: " << said;
}

TEST(Meeting, IsNotSaidOfWhatSlidesAlongAWallOrStandsInIt) {
  Scene<2> piston;
  piston.add("piston", box({0.3, 0, 0}, {0.4, 1, 0}));
  std::string said;
  EXPECT_GT(way_until_said<2>(piston, 0, along<2>(0, 1), said), 0.59) << said;

  Scene<2> rooted;  // half of the plate's foot lies below the floor
  rooted.add("plate", box({0.3, -0.02, 0}, {0.34, 0.4, 0}));
  EXPECT_EQ(rooted.look(), "");
  rooted.move(0, along<2>(1, -0.05 * patch));
  EXPECT_EQ(rooted.look(), "");

  for (bool clamped : {false, true}) {  // a plate that stands on the floor turns about its foot, and then lies down
    Scene<2> plate;
    plate.add("plate", box({0.3, 0, 0}, {0.32, 0.4, 0}));
    if (clamped) plate.scene.structure->bodies[0].clamps = {box({0.3, -0.1, 0}, {0.32, 0, 0})};
    EXPECT_EQ(plate.look(), "");
    const Surface<2> upright = plate.surface;
    double turned = 0;
    for (; turned < 2 && plate.look().empty(); turned += 0.02)
      for (std::size_t k = 0; k < plate.body.size(); ++k) {
        const Vector<2> arm = upright.position[k] - Vector<2>(0.31, 0);
        plate.surface.position[k] = Vector<2>(0.31, 0) + Eigen::Rotation2Dd(-turned) * arm;
        plate.surface.normal[k] = Eigen::Rotation2Dd(-turned) * upright.normal[k];
      }
    if (clamped)
      EXPECT_NEAR(turned, std::atan(3.5), 0.1);  // the part that is not held is 3.5 patches above the floor, the face one from the middle
    else
      EXPECT_LT(turned, 0.5);
  }
}

TEST(Meeting, OfAMovingWallWithABodyIsSaid) {
  Scene<2> scene;
  WallCase paddle;
  paddle.name = "paddle";
  paddle.shape = box({0.1, 0, 0}, {0.15, 1, 0});
  paddle.motion.emplace();
  paddle.motion->displacement = {Expression("0.5*t"), Expression(0.0), Expression(0.0)};
  scene.scene.walls.push_back(paddle);
  scene.add("plate", box({0.4, 0.1, 0}, {0.42, 0.6, 0}));
  for (int n = 0; n <= 100; ++n) {
    const double t = 0.01 * n;
    const std::string said = scene.look(t);
    if (said.empty()) continue;
    EXPECT_NE(said.find("the wall 'paddle'"), std::string::npos) << said;
    EXPECT_NEAR(t, 0.5, 0.02);
    return;
  }
  FAIL() << "nothing was said";
}

// A strip that is rolled up meets itself when its ends do.
TEST(Meeting, OfABodyWithItselfIsSaid) {
  Scene<2> scene;
  constexpr double length = 0.6, thickness = 0.02;
  scene.add("strip", box({0.2, 0.5, 0}, {0.2 + length, 0.5 + thickness, 0}));
  const Surface<2> flat = scene.surface;
  std::string said;
  double turned = 0;
  for (; turned < 3 * M_PI && said.empty(); turned += 0.02) {  // the angle of the whole strip
    for (std::size_t k = 0; k < flat.position.size(); ++k) {
      const double s = flat.position[k][0] - 0.2, offset = flat.position[k][1] - 0.51;
      const double curvature = (turned + 1e-9) / length, angle = s * curvature, radius = 1 / curvature;
      scene.surface.position[k] = {0.2 + (radius - offset) * std::sin(angle), 0.51 + radius - (radius - offset) * std::cos(angle)};
      const auto [nx, ny] = std::pair{flat.normal[k][0], flat.normal[k][1]};
      scene.surface.normal[k] = {nx * std::cos(angle) - ny * std::sin(angle), nx * std::sin(angle) + ny * std::cos(angle)};
    }
    scene.scene.walls.clear();
    said = scene.look();
  }
  EXPECT_NE(said.find("itself"), std::string::npos);
  EXPECT_NEAR(turned, 2 * M_PI, 0.25);
}

// A surface that is squeezed along itself stays behind no other part of it.
// Seen to fail: without the normals in find_strangers().
TEST(Meeting, IsNotSaidOfABodyThatIsSqueezed) {
  Scene<2> scene;
  scene.add("ball", ball({0.5, 0.5, 0}, 0.1));
  for (double scale = 1; scale > 0.1; scale *= 0.98) {
    EXPECT_EQ(scene.look(), "") << scale;
    for (auto& x : scene.surface.position) x = Vector<2>(0.5, 0.5) + 0.98 * (x - Vector<2>(0.5, 0.5));
  }
}

// Bodies that are apart cost a look at how far they have moved.
TEST(Meeting, CostsNextToNothingWhileBodiesAreApart) {
  Scene<3> scene;
  scene.add("upper", box({0.2, 0.6, 0.2}, {0.5, 0.9, 0.5}));
  scene.add("lower", box({0.2, 0.1, 0.2}, {0.5, 0.4, 0.5}));
  EXPECT_EQ(scene.look(), "");
  const Meetable meetable(scene.scene, scene.body);
  const auto before = std::chrono::steady_clock::now();
  for (int n = 0; n < 100; ++n) {
    scene.move(0, along<3>(1, 1e-5));
    watch_meetings<3>(meetable, 0, scene.surface, scene.state);
  }
  const double each = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count() / 100;
  std::printf("[ %zu surface points: %.3g ms a look ]\n", scene.body.size(), 1e3 * each);
  EXPECT_LT(each / static_cast<double>(scene.body.size()), 1e-6) << "seconds a point";
  EXPECT_NEAR(scene.state.compared[0][1], scene.surface.position[0][1], 1.01e-3) << "not compared in every look";
}

}  // namespace
}  // namespace tern
