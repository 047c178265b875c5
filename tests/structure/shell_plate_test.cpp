// Shells whose mid-surface is a flat polygon: their cells, static and modal answers.

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

#include "fixtures/shell_model.hpp"

namespace tern::structure {
namespace {

using testing::shell_material;
using testing::ShellModel;

using Corners = std::vector<std::array<double, 3>>;

/// About a place and with directions that are no multiples of the axes, so that nothing is right by chance.
Corners tilted(const std::vector<std::array<double, 2>>& flat) {
  const Vector<3> first = Vector<3>(2, -1, 2) / 3, second = Vector<3>(2, 2, -1) / 3, origin(0.3, -0.2, 0.5);
  Corners corners;
  for (const auto& s : flat) {
    const Vector<3> x = origin + s[0] * first + s[1] * second;
    corners.push_back({x[0], x[1], x[2]});
  }
  return corners;
}

Corners regular(int count, double radius = 1) {
  std::vector<std::array<double, 2>> flat;
  for (int n = 0; n < count; ++n) {
    const double angle = 2 * std::numbers::pi * n / count;
    flat.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return tilted(flat);
}

Shape all_round(const Corners& corners) {
  Shape region;
  region.kind = Shape::Kind::box;
  region.min = region.max = corners[0];
  for (const auto& x : corners)
    for (int d = 0; d < 3; ++d) region.min[d] = std::min(region.min[d], x[d] - 1), region.max[d] = std::max(region.max[d], x[d] + 1);
  return region;
}

/// What is at most so far outside of a ball about the middle of regular(): all of its sides.
Shape beyond(const Corners& corners, double radius) {
  Shape ball;
  ball.kind = Shape::Kind::ball;
  for (int d = 0; d < 3; ++d) {
    for (const auto& x : corners) ball.center[d] += x[d] / static_cast<double>(corners.size());
  }
  ball.radius = radius;
  Shape rest;
  rest.kind = Shape::Kind::difference;
  rest.parts = {all_round(corners), ball};
  return rest;
}

StructureBody plate_body(const Corners& corners, double thickness, double spacing, double poisson_ratio = 0.3) {
  StructureBody body;
  static_cast<MaterialParameters&>(body) = shell_material(1e9, poisson_ratio);
  body.name = "plate";
  body.is_shell = true;
  body.spacing = spacing;
  body.shape = plate_shape(corners, thickness);
  return body;
}

ShellModel<3> model_of(const StructureBody& body) {
  const MidSurface<3> surface = mid_surface<3>(body);
  return ShellModel<3>(make_shell_layer<3>(body.name, shell_particles(surface), Material(body), surface.thickness));
}

double area_of(const StructureBody& body) {
  double total = 0;
  for (const auto& cell : cells_of(mid_surface<3>(body))) total += cell.area;
  return total;
}

double middle(double spacing, bool clamped, int sides) {
  const Corners corners = regular(sides);
  StructureBody body = plate_body(corners, 0.01, spacing);
  const Shape rim = beyond(corners, std::cos(std::numbers::pi / sides) * (1 - 1e-9));
  body.clamps = {rim};
  if (!clamped) body.hinges = {rim};
  auto model = model_of(body);
  const Vector<3> normal = model.layer.particles.frame[0].col(2);
  constexpr double q = 1e-3;
  model.load = [&](const auto& m, auto& force) {
    for (std::size_t i = 0; i < force.size(); ++i) force[i] += q * m.layer.particles.area[i] * normal;
  };
  model.newton(1e-7);
  const double rigidity = 1e9 * 1e-6 / (12 * (1 - 0.09));
  double largest = 0;
  for (std::size_t i = 0; i < model.x.size(); ++i)
    largest = std::max(largest, (model.x[i] - model.layer.particles.position[i]).dot(normal));
  return largest * rigidity / q;
}

/// A square with a notch from above that is 0.3 wide, its banks a spacing of 0.1 apart from the lattice's edges.
const std::vector<std::array<double, 2>> notched{{0, 0}, {1.1, 0}, {1.1, 1}, {0.7, 1}, {0.7, 0.4}, {0.4, 0.4}, {0.4, 1}, {0, 1}};

// Seen to fail: with whole cells beside the sides.
TEST(ShellPlate, ItsParticlesHaveTheAreaOfThePolygonWhateverCutsTheLattice) {
  const double disc = 32 * std::sin(2 * std::numbers::pi / 64);
  for (const double spacing : {0.3, 0.13, 0.07}) {
    EXPECT_NEAR(area_of(plate_body(regular(64), 0.01, spacing)), disc, 1e-13);
    StructureBody clamped = plate_body(regular(64), 0.01, spacing);
    clamped.clamps = {beyond(regular(64), 0.998)};
    EXPECT_NEAR(area_of(clamped), disc, 1e-13);
    EXPECT_NEAR(area_of(plate_body(tilted({{0, 0}, {2.1, 0.3}, {0.4, 1.7}}), 0.01, spacing)), 0.5 * (2.1 * 1.7 - 0.3 * 0.4), 1e-13);
  }
  EXPECT_NEAR(area_of(plate_body(tilted(notched), 0.01, 0.1)), 1.1 - 0.3 * 0.6, 1e-13);
}

// Free, and held at a side, at two that meet. Seen to fail: with held particles on the corners where a free side goes on.
TEST(ShellPlate, ARectangleHasTheCellsOfABox) {
  for (const auto& held : std::vector<std::vector<int>>{{}, {3}, {0, 3}, {0, 1, 2, 3}}) {
    StructureBody plate = plate_body({{0, 0, 0}, {1.1, 0, 0}, {1.1, 0.7, 0}, {0, 0.7, 0}}, 0.02, 0.06), box = plate;
    box.shape = Shape{};
    box.shape.min = {0, 0, -0.01}, box.shape.max = {1.1, 0.7, 0.01};
    for (const int side : held) {
      Shape clamp;
      clamp.min = {side == 1 ? 1.1 : -1, side == 2 ? 0.7 : -1, -1}, clamp.max = {side == 3 ? 0.0 : 2, side == 0 ? 0.0 : 2, 1};
      plate.clamps.push_back(clamp), box.clamps.push_back(clamp);
    }
    const auto expected = cells_of(mid_surface<3>(box)), found = cells_of(mid_surface<3>(plate));
    ASSERT_EQ(found.size(), expected.size());
    for (const auto& cell : expected) {
      const auto same = std::find_if(found.begin(), found.end(),
                                     [&](const auto& other) { return (other.place.position - cell.place.position).norm() < 1e-12; });
      ASSERT_NE(same, found.end()) << cell.place.position.transpose();
      EXPECT_NEAR(same->area, cell.area, 1e-14);
      EXPECT_EQ(same->edge, cell.edge);
    }
  }
}

// w = q a^4/(64 D); a polygon of 64 sides is a circle to 0.1 %. The spacing makes it too soft in second order, as it does a square one.
// Seen to fail: with the smoothing length of a lattice.
TEST(ShellPlate, AClampedCirclePlateSagsAsItShould) {
  const double coarse = 64 * middle(1 / 8.0, true, 64) - 1, fine = 64 * middle(1 / 15.0, true, 64) - 1;
  EXPECT_NEAR(coarse, 0.120, 0.002);
  EXPECT_NEAR(fine, 0.043, 0.002);
  EXPECT_GT(std::log(coarse / fine) / std::log(15 / 8.0), 1.5);
}

// w = (5 + nu)/(1 + nu) q a^4/(64 D).
TEST(ShellPlate, AHingedCirclePlateSagsAsItShould) { EXPECT_NEAR(64 * 1.3 / 5.3 * middle(1 / 8.0, false, 64), 1, 3e-3); }

// Leissa: 5.358 sqrt(D/(rho t))/a^2 with two, 9.003 with no, 12.44 with three nodal diameters. Seen to fail: with cells of one area.
TEST(ShellPlate, AFreeCirclePlateSwingsAsItShould) {
  const auto values = model_of(plate_body(regular(64), 0.01, 1 / 8.0)).squared_frequencies(1e-7);
  const auto frequency = [&](int mode) { return std::sqrt(values[mode] / (1e9 * 1e-4 / (12 * (1 - 0.09)) / 1000)); };
  EXPECT_LT(std::abs(values[5]), 1e-6 * values[6]);
  EXPECT_NEAR(frequency(6), 5.358, 0.03);
  EXPECT_NEAR(frequency(7), 5.358, 0.03);
  EXPECT_NEAR(frequency(8), 9.003, 0.06);
  EXPECT_NEAR(frequency(9), 12.44, 0.21);
}

int modes_without_energy(const Corners& corners, double spacing) {
  auto model = model_of(plate_body(corners, 0.05, spacing));
  const auto values = model.squared_frequencies(1e-6);
  return static_cast<int>(
      std::count_if(values.begin(), values.end(), [&](double v) { return std::abs(v) < 1e-9 * values[values.size() - 1]; }));
}

TEST(ShellPlate, OnlyRigidMotionsAreFree) {
  EXPECT_EQ(modes_without_energy(regular(7), 0.25), 6);
  EXPECT_EQ(modes_without_energy(tilted({{0, 0}, {2.1, 0.3}, {0.4, 1.7}}), 0.2), 6);
  EXPECT_EQ(modes_without_energy(tilted(notched), 0.1), 6);
}

// Seen to fail: with all particles within reach.
TEST(ShellPlate, TheBanksOfANotchAreNoNeighbours) {
  const auto model = model_of(plate_body(tilted(notched), 0.01, 0.1));
  const auto& p = model.layer.particles;
  const Vector<3> origin(0.3, -0.2, 0.5), first = Vector<3>(2, -1, 2) / 3, second = Vector<3>(2, 2, -1) / 3;
  int across = 0, beside = 0;
  for (std::size_t i = 0; i < model.layer.size(); ++i)
    for (const auto j : p.beside[i]) {
      const Vector<3> a = p.position[i] - origin, b = p.position[j] - origin;
      const bool is_high = std::min(a.dot(second), b.dot(second)) > 0.45;
      across += is_high && (a.dot(first) < 0.55) != (b.dot(first) < 0.55);
      beside += is_high && (a.dot(first) < 0.55) == (b.dot(first) < 0.55);
    }
  EXPECT_EQ(across, 0);
  EXPECT_GT(beside, 100);
}

}  // namespace
}  // namespace tern::structure
