// Plane walls whose sums are functions of the height, against the sums over their patches.

#include "fluid/boundary/plane_walls.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"
#include "fluid/boundary/hidden_sums.hpp"
#include "fluid/motion/escape.hpp"

namespace tern::fluid::testing {
namespace {

constexpr double dx = 0.05;

/// Water in a box that is 16 spacings wide, 12 high and open at the top.
Case tank_of_water(double depth = 0.4) { return scene(3, dx, {box({0, 0, 0}, {0.8, depth, 0.8})}, {tank({0, 0, 0}, {0.8, 0.6, 0.8})}); }

/// What the particles at `position` see of the walls and how wet these are.
struct Seen {
  Boundary<3> boundary;

  Seen(const Fluid<3>& fluid, const Case& c, const std::vector<Vector<3>>& position) : boundary(c, fluid.constants()) {
    Neighbours<3> none;
    for (std::vector<int>* of_rows : {&none.begin, &none.length, &none.count}) of_rows->resize(position.size());
    const std::vector<Vector<3>> gravity(position.size(), Vector<3>(0, -9.81, 0));
    see_boundary<3>(fluid.constants(), fluid.period(), position, boundary, none);
    sum_over_hidden_side<3>(fluid.constants(), Ranks{}, position, gravity, boundary);
  }
};

// Half full, and with water that stands above the rim. Heights of 0.4 spacings and more: nearer than that a patch of half a spacing does
// not tell the direction of what is behind it. Measured, half full: 0.26 of the particles that see a wall stand before one plane; number
// density within 5.2e-3, moments across within 0.057, weights within 5e-5. Seen to fail: with a plane that goes on beyond its edge; with
// dry patches counted as wet.
TEST(PlaneWalls, HaveTheSumsOfTheirPatches) {
  for (double depth : {0.4, 0.8}) {
    const Case c = tank_of_water(depth);
    Fluid<3> fluid(c);
    std::mt19937 random(20240119);
    jitter(fluid, 0.1, random);
    const auto& position = fluid.state().position;
    Seen seen(fluid, c, position);
    const Boundary<3>& boundary = seen.boundary;
    int with_wall = 0, before_plane = 0;
    double density = 0, across = 0, weight = 0;  // largest differences
    for (std::size_t i = 0; i < position.size(); ++i) {
      FaceRows all;
      all.begin = {0};
      boundary.wall_finder.see(boundary.walls.faces(), position[i], all.face);
      all.count = {static_cast<int>(all.face.size())};
      all.height = {0};
      all.weight.resize(all.face.size());
      all.wet = boundary.wall_rows.wet;
      const HiddenSums<3> hidden = sum_hidden(fluid.constants(), position[i], boundary.walls.faces(), 0, all);
      const auto& sums = boundary.sums;
      ASSERT_EQ(boundary.sees_wall(i), !all.face.empty());
      with_wall += boundary.sees_wall(i);
      before_plane += boundary.wall_rows.before_plane(i);
      EXPECT_NEAR(boundary.wall_rows.height[i], all.height[0], all.face.empty() ? 1 : 1e-12);
      density = std::max(density, std::abs(sums.number_density[i] - hidden.density));
      across = std::max(across, (sums.moment[i] - sums.tangential[i] - hidden.across).norm());
      weight = std::max(weight, (sums.wall_gradient[i] + hidden.gradient).norm() * dx);
    }
    std::printf("%d particles see a wall, %d of them one plane alone; largest differences: n %.1e, M across %.1e, dx sum grad w %.1e\n",
                with_wall, before_plane, density, across, weight);
    EXPECT_LT(density, 6e-3);
    EXPECT_LT(across, 0.07);
    EXPECT_LT(weight, 1e-4);
    EXPECT_GT(before_plane, 0.2 * with_wall);
  }
}

// Beside a block on the floor as well, that stands still or has moved by two spacings and is on its way. Seen to fail: with planes listed
// alone where the block is seen, and where it would be seen if it had not moved.
TEST(PlaneWalls, AreListedWithThePatchesThatASearchFinds) {
  for (const bool moving : {false, true}) {
    Case c = tank_of_water();
    c.walls.push_back(obstacle({0.4, 0, 0.2}, {0.6, 0.2, 0.6}));
    if (moving) c.walls.back().motion.emplace().displacement = {Expression("-t"), Expression(), Expression()};
    Fluid<3> fluid(c);
    std::mt19937 random(20240120);
    jitter(fluid, 0.1, random);
    const auto& position = fluid.state().position;
    Boundary<3> boundary(c, fluid.constants());
    if (moving) {
      FollowedWalls<3> followed;
      boundary.walls.move_over(2 * dx - 5e-4, 1e-3, 0, followed);
      boundary.wall_finder.fill(boundary.walls.faces(), fluid.constants().faces.support(), &boundary.walls.lowest());
    }
    see_walls<3>(dx, position, boundary);
    const FaceRows& rows = boundary.wall_rows;
    int listed = 0, before_plane = 0;
    for (std::size_t i = 0; i < position.size(); ++i) {
      std::vector<int> found, own(rows.face.begin() + rows.begin[i], rows.face.begin() + rows.begin[i] + rows.count[i]);
      boundary.wall_finder.see(boundary.walls.faces(), position[i], found);
      if (rows.before_plane(static_cast<std::ptrdiff_t>(i))) {
        for (const int k : found) EXPECT_EQ(boundary.walls.wall_of(k), 0u) << "particle " << i;
        ++before_plane;
        continue;
      }
      std::sort(found.begin(), found.end());
      std::sort(own.begin(), own.end());
      EXPECT_EQ(own, found) << "particle " << i;
      listed += !own.empty();
    }
    EXPECT_GT(listed, 100);
    EXPECT_GT(before_plane, 50);
  }
}

// On its way along the floor to the corner, and up a wall through the waterline. Seen to fail: with a share that is either 1 or 0, and
// with dry patches counted by whole rows.
TEST(PlaneWalls, GiveWayToPatchesGradually) {
  const Case c = tank_of_water();
  Fluid<3> fluid(c);
  const int steps = 400;
  const double step = 0.4 / steps;
  for (const Vector<3>& way : {Vector<3>(-1, 0, -1), Vector<3>(0, 1, 0)}) {
    std::vector<Vector<3>> position = fluid.state().position;
    const std::size_t first = position.size();
    const Vector<3> start = way[1] == 0 ? Vector<3>(0.41, 0.5 * dx, 0.42) : Vector<3>(0.5 * dx, 0.2, 0.42);
    for (int k = 0; k < steps; ++k) position.push_back(start + k * step * way);
    std::vector<Vector<3>> one(position.begin(), position.begin() + static_cast<std::ptrdiff_t>(first));
    double before = -1, largest_change = 0, least = 1, most = 0;
    // One probe at a time, so that none fills the space before a wall for the others.
    Boundary<3> boundary(c, fluid.constants());
    for (int k = 0; k < steps; k += 4) {
      one.resize(first);
      one.push_back(position[first + static_cast<std::size_t>(k)]);
      Neighbours<3> none;
      none.begin.resize(one.size());
      const std::vector<Vector<3>> gravity(one.size(), Vector<3>(0, -9.81, 0));
      see_boundary<3>(fluid.constants(), fluid.period(), one, boundary, none);
      sum_over_hidden_side<3>(fluid.constants(), Ranks{}, one, gravity, boundary);
      const double share = boundary.wall_rows.plane[first] < 0 ? 0 : boundary.wall_rows.plane_share[first];
      if (before >= 0) largest_change = std::max(largest_change, std::abs(share - before));
      least = std::min(least, share), most = std::max(most, share);
      before = share;
    }
    EXPECT_EQ(least, 0);
    EXPECT_EQ(most, 1);
    EXPECT_LT(largest_change, 0.3);
    std::printf("largest change of the share in %.3f spacings: %.3f\n", 4 * step / dx, largest_change);
  }
}

// Just within reach of the floor, over the corner of four patches whose middles are beyond it, and half a spacing from seeing the wall at
// its side too: its row of patches is empty. The next row begins with a patch behind which it is, 19 m. Seen to fail: with the plane taken
// from the first patch of the row (signal 11).
TEST(PlaneWalls, NeedNoPatchWithinReach) {
  const Case c = scene(3, dx, {box({0, 0, 0}, {0.5, 0.1, 0.4})}, {tank({0, 0, 0}, {20, 0.6, 0.4}), obstacle({12, 0, 0}, {19.2, 0.4, 0.4})});
  Fluid<3> fluid(c);
  std::vector<Vector<3>> position = fluid.state().position;
  const std::size_t probe = position.size();
  position.push_back({3.4 * dx, fluid.constants().faces.support() - 0.01 * dx, 4 * dx});
  position.push_back({19.2 + 0.5 * dx, 6 * dx, 4 * dx});
  const Seen seen(fluid, c, position);
  const FaceRows& rows = seen.boundary.wall_rows;
  ASSERT_GT(rows.plane_share[probe], 0);
  ASSERT_LT(rows.plane_share[probe], 1);
  ASSERT_EQ(rows.count[probe], 0);
  EXPECT_EQ(seen.boundary.sums.number_density[probe], 0);
  EXPECT_EQ(seen.boundary.sums.moment[probe].norm(), 0);
}

// Seen to fail: with the crossing looked for in the patch at the foot alone.
TEST(PlaneWalls, CountWhatGoesThroughThemAtASlant) {
  const Case c = tank_of_water();
  Fluid<3> fluid(c);
  std::vector<Vector<3>> before = fluid.state().position;
  before.push_back({0.4, 0.5 * dx, 0.4});
  Seen seen(fluid, c, before);
  ASSERT_TRUE(seen.boundary.wall_rows.before_plane(static_cast<std::ptrdiff_t>(before.size()) - 1));
  std::vector<Vector<3>> after = before;
  after.back() += Vector<3>(2 * dx, -dx, 0);
  EXPECT_EQ(count_leaks<3>(dx, 1e-3, seen.boundary.seen_walls(), seen.boundary.wall_rows, before, after), 1u);
}

// From the middle of a window to its end a wall goes as far as a particle before it. Seen to fail: with the wall where it was at the
// middle.
TEST(Walls, ThatMoveTakeTheirPlaceAtTheEndOfAWindow) {
  const auto leaks = [](double wall, double particle) {
    Faces<2> faces{{{0, 0}}, {{1, 0}}, {0.1}, {1}, {{wall, 0}}, {}, {}};
    FaceRows rows;
    rows.begin = {0}, rows.count = {1}, rows.face = {0}, rows.weight = {1}, rows.height = {0};
    const Vector<2> middle(0.005, 0);
    return count_leaks<2>(0.01, 2e-3, faces, rows, {middle}, {Vector<2>(middle + 1e-3 * Vector<2>(particle, 0))});
  };
  EXPECT_EQ(leaks(-20, -20), 0u);
  EXPECT_EQ(leaks(20, 20), 0u);
  EXPECT_EQ(leaks(20, 0), 1u) << "it runs over the particle";
  EXPECT_EQ(leaks(0, -20), 1u);
}

}  // namespace
}  // namespace tern::fluid::testing
