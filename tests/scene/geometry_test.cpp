// Solid shapes: membership, lattice, surface points, thickness.

#include "scene/geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "fixtures/shapes.hpp"

namespace tern {
namespace {

const auto union_of = Shape::Kind::union_of;
const auto difference = Shape::Kind::difference;

template <int D>
double total_area(const SurfacePoints<D>& s) {
  return std::accumulate(s.area.begin(), s.area.end(), 0.0);
}

// Integral of n over the surface: zero for a closed one.
template <int D>
Vector<D> closure(const SurfacePoints<D>& s) {
  Vector<D> sum = Vector<D>::Zero();
  for (std::size_t k = 0; k < s.area.size(); ++k) sum += s.area[k] * s.normal[k];
  return sum;
}

// Volume by the divergence theorem, integral of x.n/D.
template <int D>
double enclosed(const SurfacePoints<D>& s) {
  double sum = 0;
  for (std::size_t k = 0; k < s.area.size(); ++k) sum += s.area[k] * s.position[k].dot(s.normal[k]) / D;
  return sum;
}

template <int D>
void expect_points_lie_on_the_boundary_and_look_outwards(const Shape& shape, const SurfacePoints<D>& s, double spacing) {
  for (std::size_t k = 0; k < s.area.size(); ++k) {
    EXPECT_NEAR(s.normal[k].norm(), 1, 1e-12);
    EXPECT_NEAR(signed_distance<D>(shape, s.position[k]), 0, 1e-9);
    EXPECT_LT(signed_distance<D>(shape, s.position[k] - 1e-3 * spacing * s.normal[k]), 0) << s.position[k].transpose();
    EXPECT_GT(signed_distance<D>(shape, s.position[k] + 1e-3 * spacing * s.normal[k]), 0) << s.position[k].transpose();
  }
}

Shape ring(double radius, double thickness, double begin, double end) {
  Shape s;
  s.kind = Shape::Kind::ring;
  s.center = {0.3, -0.2};
  s.radius = radius, s.thickness = thickness, s.begin = begin, s.end = end;
  return s;
}

/// The same with many corners.
Shape line_along_ring(const Shape& of, int pieces) {
  Shape s = of;
  s.kind = Shape::Kind::line;
  s.closed = of.end - of.begin > Shape::whole_turn * 0.999;
  for (int n = 0; n < pieces + (s.closed ? 0 : 1); ++n) {
    const double angle = of.begin + (of.end - of.begin) * n / pieces;
    s.vertices.push_back({of.center[0] + of.radius * std::cos(angle), of.center[1] + of.radius * std::sin(angle)});
  }
  return s;
}

Shape tube(double radius, double thickness, double length, int axis, double begin, double end) {
  Shape s = ring(radius, thickness, begin, end);
  s.kind = Shape::Kind::tube;
  s.center = {0.3, -0.2, 0.1};
  s.length = length, s.axis = axis;
  return s;
}

template <int D>
void expect_thin(const Shape& shape, double volume, double area) {
  const double spacing = 0.25 * shape.thickness;
  const SurfacePoints<D> s = sample_surface<D>(shape, spacing);
  if (shape.kind != Shape::Kind::line) expect_points_lie_on_the_boundary_and_look_outwards<D>(shape, s, spacing);
  EXPECT_NEAR(total_area(s), area, 1e-3 * area);
  EXPECT_LT(closure(s).norm(), 1e-2 * area);
  EXPECT_NEAR(enclosed(s), volume, 2e-3 * volume);
  const double fine = 0.1 * shape.thickness;
  EXPECT_NEAR(static_cast<double>(fill_lattice<D>(shape, fine).size()) * std::pow(fine, D), volume, 0.02 * volume);
  const bool is_mitred = shape.kind == Shape::Kind::line;  // its distances are rounded at corners
  const Bounds<D> bounds = bounding_box<D>(shape);
  Bounds<D> found{s.position[0], s.position[0]};
  for (const auto& x : s.position) {
    found.min = found.min.cwiseMin(x);
    found.max = found.max.cwiseMax(x);
    const double beyond = std::max((bounds.min - x).maxCoeff(), (x - bounds.max).maxCoeff());
    EXPECT_LT(beyond, is_mitred ? 1e-3 * shape.thickness : 1e-12);
  }
  EXPECT_LT((found.min - bounds.min).cwiseAbs().maxCoeff(), is_mitred ? shape.thickness : spacing);
  EXPECT_LT((found.max - bounds.max).cwiseAbs().maxCoeff(), is_mitred ? shape.thickness : spacing);
}

// Tilted, with an inner corner and a side that runs across the others. Seen to fail: with a rim that
// looks inwards.
TEST(Geometry, APlateIsASolidWithASurface) {
  const std::vector<std::array<double, 2>> flat{{0, 0}, {1.3, 0}, {1.1, 0.6}, {0.5, 0.6}, {0.5, 1}, {0, 0.8}};
  const Vector<3> first = Vector<3>(2, -1, 2) / 3, second = Vector<3>(2, 2, -1) / 3, origin(0.3, -0.2, 0.5);
  std::vector<std::array<double, 3>> corners;
  double area = 0, round = 0;
  for (std::size_t i = 0; i < flat.size(); ++i) {
    const auto &a = flat[i], &b = flat[(i + 1) % flat.size()];
    const Vector<3> x = origin + a[0] * first + a[1] * second;
    corners.push_back({x[0], x[1], x[2]});
    area += 0.5 * (a[0] * b[1] - a[1] * b[0]), round += std::hypot(b[0] - a[0], b[1] - a[1]);
  }
  for (const bool reversed : {false, true}) {
    if (reversed) std::reverse(corners.begin(), corners.end());
    const Shape plate = plate_shape(corners, 0.2);
    expect_thin<3>(plate, 0.2 * area, 2 * area + 0.2 * round);
    const SurfacePoints<3> s = sample_surface<3>(plate, 0.13);
    EXPECT_NEAR(total_area(s), 2 * area + 0.2 * round, 1e-12);
    EXPECT_LT(closure(s).norm(), 1e-12);
    EXPECT_NEAR(enclosed(s), 0.2 * area, 1e-12);
    const Vector<3> normal = first.cross(second), x = origin + 0.3 * first + 0.4 * second + 0.1 * normal;
    EXPECT_NEAR(thickness<3>(plate, x, normal), 0.2, 1e-12);
  }
}

// A plate with a hole that a ball leaves, and a box less a tilted plate that ends above its top. Seen to fail: with all of
// the surface of a plate kept, as it stands (1.037 for 0.960 m^3).
TEST(Geometry, APlateMayBePartOfASolid) {
  const double pi = std::numbers::pi;
  const Shape sheet = plate_shape({{0, 0, 0}, {1.1, 0, 0}, {1.1, 0, 0.9}, {0, 0, 1}}, 0.1);
  const Shape with_hole = combine(difference, {sheet, ball({0.5, 0, 0.5}, 0.15)});
  SurfacePoints<3> s = sample_surface<3>(with_hole, 0.02);
  expect_points_lie_on_the_boundary_and_look_outwards<3>(with_hole, s, 0.02);
  const double hole = pi * (0.15 * 0.15 * 0.1 - 0.1 * 0.1 * 0.1 / 12);
  EXPECT_NEAR(enclosed(s), 0.1 * 1.1 * 0.95 - hole, 2e-4);
  EXPECT_LT(closure(s).norm(), 1e-3);

  const double slant = std::sqrt(0.5);
  const Shape tilted = plate_shape({{0.2, 0.5, 0.1}, {0.2, 0.5, 0.9}, {1, 1.3, 0.9}, {1, 1.3, 0.1}}, 0.1 * slant);
  const Shape cut = combine(difference, {box({0, 0, 0}, {1, 1, 1}), tilted});
  s = sample_surface<3>(cut, 0.02);
  expect_points_lie_on_the_boundary_and_look_outwards<3>(cut, s, 0.02);
  EXPECT_NEAR(enclosed(s), 1 - 0.8 * 0.1 * 0.5, 2e-4);  // 0.1 wide along x, from 0.5 to 1 along y, in the mean of both faces
  EXPECT_LT(closure(s).norm(), 1e-3);
}

// Seen to fail: with the ends of arcs left out of the distance, with the inner face that looks outwards.
TEST(Geometry, RingsLinesAndTubesAreSolidsWithASurface) {
  const double pi = std::numbers::pi;
  for (const auto& [begin, end] : {std::pair{0.0, 2 * pi}, {0.4, 2.9}, {-0.5, 4.9}}) {
    const double turn = end - begin;
    const bool whole = turn > 6.28;
    const Shape arc = ring(1, 0.2, begin, end);
    expect_thin<2>(arc, turn * 0.2, 2 * turn + (whole ? 0 : 0.4));
    expect_thin<2>(line_along_ring(arc, 200), turn * 0.2, 2 * turn + (whole ? 0 : 0.4));
    for (const int axis : {0, 2})
      expect_thin<3>(tube(0.5, 0.2, 0.7, axis, begin, end), 0.5 * turn * 0.2 * 0.7,
                     2 * turn * 0.5 * 0.7 + 2 * turn * 0.5 * 0.2 + (whole ? 0 : 2 * 0.2 * 0.7));
  }
  const Shape arc = ring(1, 0.2, 0.4, 2.9);
  EXPECT_NEAR(thickness<2>(arc, Vector<2>(0.3, 0.9), Vector<2>(0, 1)), 0.2, 1e-12);
  // Distances beyond an end: from its corner, and from its plane.
  const Vector<2> radial(std::cos(0.4), std::sin(0.4)), back(std::sin(0.4), -std::cos(0.4)), center(0.3, -0.2);
  EXPECT_NEAR(signed_distance<2>(arc, center + radial + 0.07 * back), 0.07, 1e-12);
  EXPECT_NEAR(signed_distance<2>(arc, center + 1.14 * radial + 0.03 * back), 0.05, 1e-12);
  EXPECT_NEAR(signed_distance<2>(arc, center + radial - 0.02 * back), -0.02, 1e-12);
}

// Seen to fail with one column too few in the count.
TEST(Lattice, FillsABoxOfWholeMultiplesExactly) {
  EXPECT_EQ(fill_lattice<2>(box({0, 0}, {0.2, 0.4}), 0.004).size(), 5000u);
  const auto lattice = fill_lattice<2>(box({0.596, -0.010}, {0.600, 0.090}), 0.001);
  const std::vector<Vector<2>> plate(lattice.begin(), lattice.end());
  ASSERT_EQ(plate.size(), 400u);
  EXPECT_NEAR(plate.front()[0], 0.5965, 1e-12);
  EXPECT_NEAR(plate[1][0] - plate[0][0], 0.001, 1e-12) << "x runs fastest";
  EXPECT_NEAR(plate.back()[1], 0.0895, 1e-12);
  EXPECT_EQ(fill_lattice<3>(box({0, 0, 0}, {0.3, 0.2, 0.1}), 0.1).size(), 6u);
}

// Seen to fail: with the lattice along the coordinates.
TEST(Lattice, GoesAlongTheLongestSideOfAPolygonAndTheAxesOfAPlate) {
  const double c = std::cos(0.3), s = std::sin(0.3);
  const Shape turned = polygon({{1, 2}, {1 + c, 2 + s}, {1 + c - 0.2 * s, 2 + s + 0.2 * c}, {1 - 0.2 * s, 2 + 0.2 * c}});
  const Matrix<2> axes = lattice_axes<2>(turned);
  EXPECT_LT((axes - (Matrix<2>() << c, -s, s, c).finished()).norm(), 1e-12);
  const Shape with_hole = combine(difference, {turned, ball({1.4, 2.2}, 0.01)});  // between the points
  for (const Shape& shape : {turned, with_hole}) {
    const auto lattice = fill_lattice<2>(shape, 0.05);
    EXPECT_EQ(lattice.size(), 80u);
    EXPECT_TRUE(lattice.is_turned());
    for (const Vector<2>& x : lattice) {
      const Vector<2> from_corner = axes.transpose() * (x - Vector<2>(1, 2)) / 0.05;
      for (int a = 0; a < 2; ++a) EXPECT_NEAR(from_corner[a] - std::floor(from_corner[a]), 0.5, 1e-9);
    }
  }
  EXPECT_EQ(lattice_axes<2>(polygon({{0, 0}, {0.2, 0}, {0.2, 1}, {0, 1}})), Matrix<2>::Identity());
  EXPECT_EQ(lattice_axes<2>(ball({0, 0}, 1)), Matrix<2>::Identity());
  const Shape sheet = plate_shape({{0, 0, 0}, {0.8 * c, 0, 0.8 * s}, {0.8 * c, 0.6, 0.8 * s}, {0, 0.6, 0}}, 0.2);
  EXPECT_EQ(fill_lattice<3>(sheet, 0.1).size(), 8u * 6 * 2);
  EXPECT_TRUE(fill_lattice<3>(sheet, 0.1).is_turned());
  EXPECT_EQ(lattice_axes<3>(plate_shape({{0, 0, 0}, {0, 0, 2}, {0, 1, 2}, {0, 1, 0}}, 0.2)), Matrix<3>::Identity());
}

TEST(Lattice, HoldsThePointsThatASearchOfAllFinds) {
  const Shape hole = combine(difference, {box({0, 0}, {10, 7}), ball({4, 3}, 2.3), box({6.2, 1}, {7.1, 9})});
  const Shape shape = combine(union_of, {hole, ball({12, 4}, 1.7), ball({4.3, 3.1}, 0.4)});
  for (const double spacing : {0.5, 0.11, 0.0237}) {
    const Bounds<2> bounds = bounding_box<2>(shape);
    std::vector<Vector<2>> all;
    for (long j = 0; j < std::lround((bounds.max[1] - bounds.min[1]) / spacing); ++j)
      for (long i = 0; i < std::lround((bounds.max[0] - bounds.min[0]) / spacing); ++i) {
        const Vector<2> x(bounds.min[0] + (static_cast<double>(i) + 0.5) * spacing,
                          bounds.min[1] + (static_cast<double>(j) + 0.5) * spacing);
        if (signed_distance<2>(shape, x) <= 1e-6 * spacing) all.push_back(x);
      }
    const auto lattice = fill_lattice<2>(shape, spacing);
    EXPECT_EQ(lattice.size(), all.size());
    EXPECT_TRUE(std::equal(lattice.begin(), lattice.end(), all.begin(), all.end()));
    const Shape probe = ball({11.5, 4.2}, 0.6);
    const auto found = first_inside<2>(lattice, probe, 0);
    const auto first = std::find_if(all.begin(), all.end(), [&](const auto& x) { return signed_distance<2>(probe, x) < 0; });
    ASSERT_EQ(found.has_value(), first != all.end());
    if (found) {
      EXPECT_EQ(*found, *first);
    }
  }
}

// Seen to fail with the second part of the difference added instead of subtracted.
TEST(Lattice, LeavesOutWhatADifferenceCutsAway) {
  const Shape frame = combine(difference, {box({0, 0}, {10, 10}), box({2, 2}, {8, 8})});
  EXPECT_EQ(fill_lattice<2>(frame, 1).size(), 64u);
  const Shape both = combine(union_of, {box({0, 0}, {2, 1}), box({1, 0}, {3, 1})});
  EXPECT_EQ(fill_lattice<2>(both, 0.5).size(), 12u);
  EXPECT_NEAR(static_cast<double>(fill_lattice<2>(ball({0, 0}, 1), 0.01).size()), std::numbers::pi * 1e4, 60);
}

// Seen to fail with contains that left out the boundary, and with every crossing of a polygon taken as inside.
TEST(Shape, ContainsItsBoundaryAndNothingBeyond) {
  const Shape notched = polygon({{0, 0}, {2, 0}, {2, 2}, {1, 1}, {0, 2}});
  EXPECT_TRUE(contains<2>(notched, {0, 0}));
  EXPECT_TRUE(contains<2>(notched, {1, 1}));
  EXPECT_TRUE(contains<2>(notched, {1, 0.5}));
  EXPECT_FALSE(contains<2>(notched, {1, 1.5}));
  EXPECT_FALSE(contains<2>(notched, {2.001, 1}));
  const Shape hole = combine(difference, {box({0, 0, 0}, {1, 1, 1}), ball({0.5, 0.5, 0.5}, 0.25)});
  EXPECT_TRUE(contains<3>(hole, {0.5, 0.5, 0.75}));
  EXPECT_FALSE(contains<3>(hole, {0.5, 0.5, 0.7}));
  EXPECT_TRUE(contains<3>(hole, {1, 1, 1}));
}

// Seen to fail with one count for all four edges: the short edge of the plate got 90 points.
TEST(Surface, DividesEachEdgeOfABoxEvenly) {
  const Shape plate = box({0.596, 0}, {0.600, 0.090});
  const auto s = sample_surface<2>(plate, 0.001);
  ASSERT_EQ(s.position.size(), 188u);
  EXPECT_NEAR(total_area(s), 0.188, 1e-14);
  for (const double a : s.area) EXPECT_NEAR(a, 0.001, 1e-15);
  EXPECT_LT(closure(s).norm(), 1e-15);
  expect_points_lie_on_the_boundary_and_look_outwards(plate, s, 0.001);
  const auto block = sample_surface<3>(box({0, 0, 0}, {1, 2, 3}), 0.25);
  EXPECT_EQ(block.area.size(), 16u * 2 * (2 + 3 + 6));
  EXPECT_NEAR(total_area(block), 22, 1e-12);
  EXPECT_NEAR(enclosed(block), 6, 1e-12);
}

// Seen to fail with the orientation of the polygon ignored: normals pointed inwards for one of the two.
TEST(Surface, OfAPolygonLooksOutwardsWhicheverWayItRuns) {
  const std::vector<std::array<double, 2>> corners = {{0, 0}, {2, 0}, {2, 2}, {1, 1}, {0, 2}};
  for (const auto& order : {corners, std::vector<std::array<double, 2>>(corners.rbegin(), corners.rend())}) {
    const Shape shape = polygon(order);
    const auto s = sample_surface<2>(shape, 0.1);
    EXPECT_NEAR(total_area(s), 6 + 2 * std::numbers::sqrt2, 1e-12);
    EXPECT_NEAR(enclosed(s), 3, 1e-12);
    expect_points_lie_on_the_boundary_and_look_outwards(shape, s, 0.1);
  }
}

// Seen to fail with the area of a band of latitude taken as its width times its middle circle.
TEST(Surface, OfABallHasItsAreaAndVolume) {
  const auto circle = sample_surface<2>(ball({1, 2}, 0.5), 0.05);
  EXPECT_NEAR(total_area(circle), std::numbers::pi, 1e-12);
  EXPECT_LT(closure(circle).norm(), 1e-12);
  const Shape globe = ball({1, 2, 3}, 0.5);
  const auto sphere = sample_surface<3>(globe, 0.05);
  EXPECT_NEAR(total_area(sphere), std::numbers::pi, 1e-12);
  EXPECT_LT(closure(sphere).norm(), 1e-12);
  EXPECT_NEAR(enclosed(sphere), std::numbers::pi / 6, 1e-3);
  expect_points_lie_on_the_boundary_and_look_outwards(globe, sphere, 0.05);
}

// Seen to fail with the normals of subtracted parts left as they are, and with coinciding faces counted twice.
TEST(Surface, OfUnionAndDifferenceIsTheFinalBoundaryOnly) {
  const Shape el = combine(union_of, {box({0, 0}, {2, 1}), box({0, 0}, {1, 2})});  // bottom and left faces coincide
  const auto s = sample_surface<2>(el, 0.1);
  EXPECT_NEAR(total_area(s), 8, 1e-9);
  EXPECT_NEAR(enclosed(s), 3, 1e-9);
  expect_points_lie_on_the_boundary_and_look_outwards(el, s, 0.1);

  const Shape touching = combine(union_of, {box({0, 0}, {1, 1}), box({1, 0}, {2, 1})});  // the common face vanishes
  EXPECT_NEAR(total_area(sample_surface<2>(touching, 0.1)), 6, 1e-9);

  const Shape bitten = combine(difference, {box({0, 0}, {2, 2}), ball({2, 2}, 1)});
  const auto b = sample_surface<2>(bitten, 0.05);
  EXPECT_NEAR(total_area(b), 6 + std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(enclosed(b), 4 - std::numbers::pi / 4, 1e-3);
  EXPECT_LT(closure(b).norm(), 1e-3);
  expect_points_lie_on_the_boundary_and_look_outwards(bitten, b, 0.05);
}

// Error of the area of a box with a round bite, second order in the spacing. Seen to fail with patches kept whole.
TEST(Surface, OfACutSolidConvergesToItsArea) {
  const Shape bitten = combine(difference, {box({0, 0, 0}, {2, 2, 2}), ball({2, 1, 1}, 0.7)});
  const double exact = 24 - std::numbers::pi * 0.49 + 2 * std::numbers::pi * 0.49;
  const double coarse = std::abs(total_area(sample_surface<3>(bitten, 0.2)) - exact);
  const double fine = std::abs(total_area(sample_surface<3>(bitten, 0.05)) - exact);
  EXPECT_LT(coarse, 0.2 * 0.2);
  EXPECT_LT(fine, 0.05 * 0.05);
}

// Seen to fail with the first crossing returned: the ray ended at the inner face of the union.
TEST(Thickness, IsTheWayThroughTheSolid) {
  EXPECT_NEAR(thickness<2>(box({0.596, 0}, {0.600, 0.09}), {0.600, 0.04}, {1, 0}), 0.004, 1e-12);
  const Shape layered = combine(union_of, {box({0, 0}, {1, 1}), box({1, 0}, {3, 1})});
  EXPECT_NEAR(thickness<2>(layered, {0, 0.5}, {-1, 0}), 3, 1e-12);
  const Shape hollow = combine(difference, {box({0, 0, 0}, {5, 5, 5}), ball({2.5, 2.5, 2.5}, 1)});
  EXPECT_NEAR(thickness<3>(hollow, {5, 2.5, 2.5}, {1, 0, 0}), 1.5, 1e-12);
  EXPECT_NEAR(thickness<3>(hollow, {5, 0.5, 0.5}, {1, 0, 0}), 5, 1e-12);
  EXPECT_NEAR(thickness<2>(polygon({{0, 0}, {4, 0}, {0, 4}}), {1, 0}, {0, -1}), 3, 1e-12);
}

}  // namespace
}  // namespace tern
