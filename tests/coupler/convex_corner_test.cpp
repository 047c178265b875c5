// A block in water, particles on their lattice: what the convex corners of a body do to the sums of the particles near them.

#include <gtest/gtest.h>

#include <map>

#include "fluid/fluid.hpp"
#include "particles/geometry.hpp"
#include "structure/structure.hpp"
#include "tests/coupler/scenes.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double dx = 0.01, low = 0.14, high = 0.26, width = 0.4, rho = 1000, g = 9.81;

Case block_in_water() {
  Case c = scene(2, dx);
  c.end_time = 1;
  c.gravity = constant(0, -g);
  FluidBody below;
  below.velocity = constant(0);
  below.shape = box({0, 0, 0}, {width, low, 0});
  FluidBody left = below, right = below, above = below;
  left.shape = box({0, low, 0}, {low, high, 0});
  right.shape = box({high, low, 0}, {width, high, 0});
  above.shape = box({0, high, 0}, {width, width, 0});
  c.fluid->bodies = {below, left, right, above};
  WallCase tank;
  tank.name = "tank";
  tank.container = true;
  tank.open = {"y_max"};
  tank.shape = box({0, 0, 0}, {width, 2 * width, 0});
  c.walls.push_back(tank);
  StructureBody& block = c.structure->bodies[0];
  block.name = "block";
  block.shape = box({low, low, 0}, {high, high, 0});
  block.spacing = 0.5 * dx;
  block.young_modulus = 1e9;
  block.poisson_ratio = 0.3;
  block.velocity = constant(0);
  block.clamps = {box({0.18, 0.18, -1}, {0.22, 0.22, 1})};
  return c;
}

/// Fluid and surface at the begin, and who sees whom.
struct Scene {
  Case c = block_in_water();
  fluid::Fluid<2> fluid{c};
  structure::Structure<2> structure{c};
  Surface<2> surface = structure.surface();
  Band<2> band;

  Scene() {
    fluid.begin_window(0, to_ticks(1e-6));
    band = fluid.see_surface(surface);
  }
};

// Every point of a face has the whole half space before it, corners included: where the particles stand on their lattice and
// have the pressure of water at rest, the block feels the weight of the water it displaces. What a block feels too much after
// some time is not the transfer of the pressure but where the particles have gone and which pressure they have found.
// Seen to fail: with 1.9 for the factor 2 of b_ik.
TEST(ConvexCorner, LeavesTheLiftOfALatticeExact) {
  Scene scene;
  for (const auto& [name, scheme] : {std::pair{"fsa", InterfaceScheme::fsa}, {"pi", InterfaceScheme::pi},
                                     {"riemann", InterfaceScheme::riemann}}) {
    scene.c.coupling.scheme = scheme;
    CouplingStep<2> step(scene.c, scene.structure.surface_properties());
    step.dissipative_load(0, 1e-6, scene.surface, scene.band);
    step.interface_force(pressure_field<2>(scene.band, [](const Vector<2>& x) { return rho * g * (width - x[1]); }));
    const Vector<2> lift = step.total_load(0) / (rho * g * (high - low) * (high - low));
    std::printf("[ %-7s lift %.5f of Archimedes' ]\n", name, lift[1]);
    EXPECT_NEAR(lift[1], 1, 1e-3) << name;
    EXPECT_NEAR(lift[0], 0, 1e-9) << name;
  }
}

// A particle that sees one of the two faces of a corner does not see the fluid beyond it. The boundary of what is hidden from it
// is the face and, from the corner on, the ray through the corner; the sum over the face lacks the ray, so that a uniform
// pressure p pushes the particle by -2 p V R, R = n Int_r^2h w ds, n across the ray, r the distance of the corner. Elsewhere
// R = 0. This is why particles at rest cannot stay on their lattice there; what it does to the load: docs/THEORY.md, section 4.
// Particles of the lattice that stand on the ray make a difference of up to a half to a single R, but not to the sum.
// Seen to fail: with 1.9 for the factor 2 of b_ik; with the cone of each patch in place of its surface, which has the ray.
TEST(ConvexCorner, LacksTheRayThroughTheCorner) {
  Scene scene;
  const double h = scene.c.fluid->numerics.smoothing_length_ratio * dx;
  const Kernel<2> kernel(h);
  InterfacePairs<2> pairs(h, dx);
  pairs.find(scene.band, scene.surface);
  std::vector<Vector<2>> faces(scene.band.id.size(), Vector<2>::Zero());
  for (const auto& pair : pairs.pairs()) faces[pair.particle] += pair.b / (2 * scene.band.volume[pair.particle]);
  std::map<std::uint32_t, std::size_t> row;
  for (std::size_t i = 0; i < scene.fluid.state().size(); ++i) row[scene.fluid.state().id[i]] = i;

  double ray = 0, found = 0, elsewhere = 0;
  for (std::size_t m = 0; m < scene.band.id.size(); ++m) {
    const Vector<2> residual = scene.fluid.neighbours().kernel_gradient[row[scene.band.id[m]]] + faces[m];
    // From the nearest corner, both axes pointing away from the block.
    const Vector<2> x = scene.band.position[m] - Vector<2>::Constant(0.5 * (low + high));
    const Vector<2> from_corner = x.cwiseAbs() - Vector<2>::Constant(0.5 * (high - low));
    const double r = from_corner.norm(), length = kernel.support() - r;
    if (length <= 0 || from_corner.minCoeff() > 0) {
      elsewhere = std::max(elsewhere, dx * residual.norm());
      continue;
    }
    constexpr int steps = 1000;
    double size = 0;
    for (int s = 0; s < steps; ++s) size += kernel.value(r + (s + 0.5) / steps * length) * length / steps;
    // Across the ray, away from the block.
    const Vector<2> across(std::copysign(from_corner[1], x[0]), std::copysign(from_corner[0], x[1]));
    const Vector<2> expected = dx * size / r * across;
    ray += expected.squaredNorm();
    found += dx * residual.dot(expected);
  }
  std::printf("[ sum of R . R_ray %.5f, of R_ray . R_ray %.5f; R dx elsewhere at most %.4f ]\n", found, ray, elsewhere);
  EXPECT_GT(ray, 0.05);
  EXPECT_NEAR(found / ray, 1, 0.2);
  EXPECT_LT(elsewhere, 0.01);
}

/// Loads of the pressure of water at rest on the cube's upper and lower face, over pressure times area, with patches of `patch` dx.
std::pair<double, double> loads_of_a_cube(InterfaceScheme scheme, double patch) {
  constexpr double side = high - low;
  Case c = scene(3, dx);
  c.gravity = constant(0, -g);
  c.coupling.scheme = scheme;
  const Shape cube = box({low, low, low}, {high, high, high});
  FluidBody water;
  water.velocity = constant(0);
  water.shape.kind = Shape::Kind::difference;
  water.shape.parts = {box({0, 0, 0}, {width, width, width}), cube};
  c.fluid->bodies = {water};
  Surface<3> surface;
  const auto points = sample_surface<3>(cube, patch * dx);
  for (std::size_t k = 0; k < points.position.size(); ++k) add_point<3>(surface, points.position[k], points.normal[k], points.area[k]);
  fluid::Fluid<3> fluid(c);
  fluid.begin_window(0, to_ticks(1e-6));
  const Band<3> band = fluid.see_surface(surface);
  CouplingStep<3> step(c, properties(surface.position.size()));
  step.dissipative_load(0, 1e-6, surface, band);
  step.interface_force(pressure_field<3>(band, [](const Vector<3>& x) { return rho * g * (width - x[1]); }));
  EXPECT_LT(step.audit().force_error, 1e-13);
  double up = 0, down = 0;
  for (std::size_t k = 0; k < surface.position.size(); ++k) (surface.normal[k][1] < -0.5 ? up : down) += step.surface_load().force[k][1];
  return {down / (-rho * g * (width - high) * side * side), up / (rho * g * (width - low) * side * side)};
}

// The same of a cube with its edges and corners: its faces carry pressure times area.
// Seen to fail with patches that hide their neighbours across an edge (riemann: 0.956 and 0.996 with patches of dx and dx/2).
TEST(ConvexCorner, LeavesTheLoadsOfACubeExact) {
  for (const auto& [name, scheme] : {std::pair{"fsa", InterfaceScheme::fsa}, {"pi", InterfaceScheme::pi},
                                     {"riemann", InterfaceScheme::riemann}})
    for (double patch : {1.0, 0.5}) {
      const auto [top, bottom] = loads_of_a_cube(scheme, patch);
      std::printf("[ %-7s patches of %.1f dx: top %.5f, bottom %.5f of p A ]\n", name, patch, top, bottom);
      // A patch of dx is too coarse for the corners of the kernel by 0.5 %.
      const double band = scheme == InterfaceScheme::riemann && patch == 1 ? 0.006 : 1e-3;
      EXPECT_NEAR(top, 1, band) << name;
      EXPECT_NEAR(bottom, 1, band) << name;
    }
}

}  // namespace
}  // namespace tern::coupler::testing
