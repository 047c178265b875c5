// A shell whose mid-surface is a plane polygon, as a lid with water above and beneath: what its faces bear.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fixtures/interface_scenes.hpp"
#include "structure/structure.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double dx = 0.01, g = 9.81, rho = 1000, radius = 0.08, thickness = 0.004, depth = 0.2, first_corner = 0.2;

/// A hexagonal lid at y = -thickness .. 0, turned so that no side lies along a row of the water.
StructureBody hexagon() {
  StructureBody lid;
  lid.name = "lid";
  lid.is_shell = true;
  lid.spacing = 0.02;
  lid.density = 1200;
  lid.young_modulus = 1e7;
  lid.poisson_ratio = 0.3;
  std::vector<std::array<double, 3>> corners;
  for (int n = 0; n < 6; ++n) {
    const double angle = first_corner + n * std::numbers::pi / 3;
    corners.push_back({radius * std::cos(angle), -0.5 * thickness, radius * std::sin(angle)});
  }
  lid.shape = plate_shape(corners, thickness);
  return lid;
}

/// Distance from the nearest side of the hexagon, inwards.
double from_rim(const Vector<3>& x) {
  double least = radius;
  for (int n = 0; n < 6; ++n) {
    const double angle = first_corner + (n + 0.5) * std::numbers::pi / 3;
    least = std::min(least, radius * std::cos(std::numbers::pi / 6) - x[0] * std::cos(angle) - x[2] * std::sin(angle));
  }
  return least;
}

// Water at rest: on the lid stands the weight of the column above it, against its lower face that of a column from there to the
// surface, and both together are the lift of the water that it displaces. Every point has the pressure of its place, but for 32 of 1520
// within a spacing of the rim, which lack 1.5e-4 of the load.
// Seen to fail: with faces as large as whole cells of the lattice; with those of the lower side turned over; with the points of a face half
// a thickness off.
TEST(PolygonShell, BearsTheWeightOfTheColumnOnIt) {
  Case c = scene(3, dx);
  c.gravity = constant(0, -g);
  c.structure->bodies = {hexagon()};
  const structure::Structure<3> structure(c);
  const Surface<3> surface = structure.surface();
  const auto particles = fluid_layers<3>(0.14, 4, dx, true, thickness);
  Coupler<3> coupler(c, structure.surface_properties());
  coupler.first_exchange(0, 1e-3, surface, particles);
  coupler.last_exchange(pressure_field<3>(particles, [](const auto& x) { return rho * g * (depth - x[1]); }));

  const double area = 1.5 * std::sqrt(3.0) * radius * radius;
  double off = 0;
  std::array<double, 2> load{}, first_moment{}, wet{};  // by side: above, beneath
  for (std::size_t k = 0; k < surface.position.size(); ++k) {
    if (std::abs(surface.normal[k][1]) < 0.5) continue;  // the rim
    const std::size_t side = surface.normal[k][1] > 0 ? 0 : 1;
    const double height = side == 0 ? depth : depth + thickness, force = (side == 0 ? -1 : 1) * coupler.surface_load().force[k][1];
    load[side] += force / (rho * g * height * area);
    first_moment[side] += force * std::hypot(surface.position[k][0], surface.position[k][2]) / (rho * g * height * area * radius);
    wet[side] += surface.area[k] / area;
    if (from_rim(surface.position[k]) > dx) off = std::max(off, std::abs(force / (rho * g * height * surface.area[k]) - 1));
  }
  std::printf("[ above %.6f, beneath %.6f of the column; a point off the rim within %.1e; mean distance %.5f radii ]\n", load[0], load[1],
              off, first_moment[0]);
  const double lift = coupler.total_load(0)[1] / (rho * g * thickness * area);
  // The mean distance from the middle of a hexagon, over the radius.
  const double mean_distance = std::cos(std::numbers::pi / 6) * (2.0 / 3 + std::log(std::sqrt(3.0))) / std::sqrt(3.0);
  for (const std::size_t side : {0, 1}) {
    EXPECT_NEAR(wet[side], 1, 1e-12);
    EXPECT_NEAR(load[side], 1, 5e-4);
    EXPECT_NEAR(first_moment[side], mean_distance, 0.002);
  }
  EXPECT_NEAR(lift, 1, 5e-4);
  EXPECT_LT(off, 1e-9);
  EXPECT_LT(coupler.audit().force_error, 1e-13);
}

}  // namespace
}  // namespace tern::coupler::testing
