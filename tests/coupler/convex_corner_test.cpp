// A block in water, particles on their lattice: what the convex corners of a body do to the sums of the particles near them.

#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "fixtures/interface_scenes.hpp"
#include "fluid/fluid.hpp"
#include "scene/geometry.hpp"
#include "sph/convex_corner.hpp"
#include "structure/structure.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double window = 1e-3, dx = 0.01, low = 0.14, high = 0.26, width = 0.4, rho = 1000, g = 9.81;

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
  c.fluid->numerics.density_relaxation = 0;
  block.clamps = {box({0.18, 0.18, -1}, {0.22, 0.22, 1})};
  return c;
}

/// Fluid and surface at the begin, and who sees whom.
struct Scene {
  Case c = block_in_water();
  fluid::Fluid<2> fluid{c};
  structure::Structure<2> structure{c};
  Surface<2> surface = structure.surface();
  InterfaceParticles<2> particles;

  Scene() {
    fluid.begin_window(0, to_ticks(window));
    particles = fluid.see_surface(surface);
  }
};

// Where the particles stand on their lattice and have the pressure of water at rest, the block feels the weight of the water it
// displaces. A point beside a corner has more than a half space before it, and its share of that (borne_share) is of what particles add up
// there.
// Seen to fail: with 1.9 for the factor 2 of b_ik; with a share of 1 (riemann 1.046); with the share of the volume in place of that of the
// particles, without midpoint_rest() (riemann 0.9971); without pairs of back-facing faces (riemann 0.961).
TEST(ConvexCorner, LeavesTheLiftOfALatticeExact) {
  Scene scene;
  for (const auto& [scheme, name, meaning] : interface_schemes) {
    scene.c.coupling.scheme = scheme;
    Coupler<2> coupler(scene.c, scene.structure.surface_properties());
    coupler.first_exchange(0, window, scene.surface, scene.particles);
    coupler.last_exchange(pressure_field<2>(scene.particles, [](const Vector<2>& x) { return rho * g * (width - x[1]); }));
    const Vector<2> lift = coupler.total_load(0) / (rho * g * (high - low) * (high - low));
    std::printf("[ %-7s lift %.5f of Archimedes' ]\n", name, lift[1]);
    EXPECT_NEAR(lift[1], 1, 1e-3) << name;
    EXPECT_NEAR(lift[0], 0, 1e-9) << name;
  }
}

/// dx times the sum of grad w over the fluid an interface particle sees and over the faces that bound what is hidden from it.
std::vector<Vector<2>> incompleteness(const Scene& scene, bool back_facing) {
  const double h = scene.c.fluid->numerics.smoothing_length_ratio * dx;
  const FaceKernel<2> kernel(Kernel<2>(h), dx);
  Faces<2> faces;
  faces.position = scene.surface.position;
  faces.normal = scene.surface.normal;
  faces.area = scene.surface.area;
  faces.two_sided.assign(faces.size(), 1);
  FaceFinder<2> finder;
  finder.fill(faces, kernel.support());
  const std::vector<std::uint8_t> none_covered;
  CornerScratch scratch;
  CornerView<2> corners(faces, finder, none_covered, kernel, scratch);
  std::map<std::uint32_t, std::size_t> row;
  for (std::size_t i = 0; i < scene.fluid.state().size(); ++i) row[scene.fluid.state().id[i]] = i;
  std::vector<Vector<2>> result;
  for (std::size_t m = 0; m < scene.particles.id.size(); ++m) {
    const Vector<2>& x = scene.particles.position[m];
    std::vector<int> seen;
    const double spread = finder.see(faces, x, seen);
    if (back_facing) {
      corners.look(x, seen.data(), static_cast<int>(seen.size()), spread);
      seen.insert(seen.end(), corners.back_facing().begin(), corners.back_facing().end());
    }
    Vector<2> sum = scene.fluid.neighbours().kernel_gradient[row[scene.particles.id[m]]];
    for (int k : seen) sum -= faces.area[k] * kernel.surface_weight((faces.position[k] - x).norm()) * faces.normal[k];
    result.push_back(dx * sum);
  }
  return result;
}

// A particle sees the fluid past a corner. What is hidden from it is bounded by the face it sees and by the back-facing one: with
// both, Gauss' theorem holds beside corners as it does elsewhere, but for what the lattice leaves of it there.
// Seen to fail: with pairs cut at corners.
TEST(ConvexCorner, HidesWhatItsFacesBound) {
  const Scene scene;
  double with = 0, without = 0;
  for (const auto& r : incompleteness(scene, true)) with = std::max(with, r.norm());
  for (const auto& r : incompleteness(scene, false)) without = std::max(without, r.norm());
  std::printf("[ dx |sum grad w| at most %.4f; %.4f without back-facing faces ]\n", with, without);
  EXPECT_LT(with, 0.012);
  EXPECT_GT(without, 0.1);
}

// The line between two particles passes a corner just outside the body, where its patches reach a little beyond their edges: flatter lines
// pass the patch round the corner farther off. If they did not see each other there, a particle that moves by would for some windows lose
// a neighbour, and the pressure of all of the water would jump.
// Seen to fail: with the faces past the corner looked for as far as they reach (0.3 and 0.1).
TEST(ConvexCorner, HidesNothingFromALineThatMissesIt) {
  const Case c = block_in_water();
  const structure::Structure<2> structure(c);
  for (const double slope : {1.0, 0.3, 0.1})
    for (const double miss : {0.001, 0.01, 0.02}) {  // of dx, below the corner
      fluid::Fluid<2> fluid(c);
      auto state = fluid.state();
      const Vector<2> corner(low, low), along(dx, -slope * dx);
      const std::array<Vector<2>, 2> wanted{corner - Vector<2>(0, miss * dx) - 0.9 * along, corner - Vector<2>(0, miss * dx) + 0.8 * along};
      std::array<std::uint32_t, 2> id;
      for (int end = 0; end < 2; ++end) {
        const auto nearer = [&](const Vector<2>& a, const Vector<2>& b) { return (a - wanted[end]).norm() < (b - wanted[end]).norm(); };
        auto& moved = *std::min_element(state.position.begin(), state.position.end(), nearer);
        moved = wanted[end];
        id[end] = state.id[&moved - state.position.data()];
      }
      fluid.set_state(std::move(state));
      fluid.begin_window(0, to_ticks(window));
      fluid.see_surface(structure.surface());
      const auto row_of = [&](std::uint32_t i) {
        const auto& ids = fluid.state().id;
        return static_cast<int>(std::find(ids.begin(), ids.end(), i) - ids.begin());
      };
      int sees = 0;
      fluid.neighbours().for_each(row_of(id[0]), [&](int j, float) { sees += j == row_of(id[1]); });
      EXPECT_EQ(sees, 1) << "slope " << slope << ", " << miss << " dx";
    }
}

// The first window of a scene that is at rest: no particle is pushed, beside corners no more than the lattice leaves of their
// sums (p is 26 rho g dx there), and the pressure is that of water at rest up to a constant. (The constant is that of the free
// surface.) Without what is done for corners a particle is pushed by 5.7 g, and the block feels 4.9 % too much.
// Seen to fail: with pairs cut at corners (4.1 g, and pressures 12 rho g dx apart); without what is not borne in the pressure gradient
// (2.7 g), back-facing faces in the pressure equation (pressures 0.65 rho g dx apart), pairs of back-facing faces (4.5 g); with T of the
// faces seen alone (0.41 g), without the hydrostatic part of what is not borne (0.313 g).
TEST(ConvexCorner, LeavesWaterAtRest) {
  Scene scene;
  scene.c.coupling.algorithm = CouplingAlgorithm::explicit_staggering;
  Coupler<2> coupler(scene.c, scene.structure.surface_properties());
  const InterfacePressure<2> pressure = scene.fluid.solve_pressure(coupler.first_exchange(0, window, scene.surface, scene.particles));
  scene.fluid.end_window(coupler.last_exchange(pressure));
  const auto& state = scene.fluid.state();
  double push = 0, lowest = 1e300, highest = -1e300;
  for (std::size_t i = 0; i < state.size(); ++i) {
    const Vector<2> from_face =
        (state.position[i] - Vector<2>::Constant(0.5 * (low + high))).cwiseAbs() - Vector<2>::Constant(0.5 * (high - low));
    if (from_face.maxCoeff() > 0.05) continue;
    push = std::max(push, state.velocity[i].norm() / (g * window));
    const double excess = state.pressure[i] / (rho * g * dx) - (width - state.position[i][1]) / dx;
    lowest = std::min(lowest, excess), highest = std::max(highest, excess);
  }
  const double lift = coupler.total_load(0)[1] / (rho * g * (high - low) * (high - low));
  std::printf("[ push %.3f g; pressures %.4f rho g dx apart; lift %.4f ]\n", push, highest - lowest, lift);
  EXPECT_LT(push, 0.308);
  EXPECT_LT(highest - lowest, 0.02);
  EXPECT_NEAR(lift, 1, 5e-3);
}

// A particle goes round a corner in small steps. On its way it passes the planes of both faces; what it puts on the body does
// not jump there.
// Seen to fail: without pairs of back-facing faces (0.20 of p dx).
TEST(ConvexCorner, IsPassedWithoutAJump) {
  const Scene scene;
  Coupler<2> coupler(scene.c, scene.structure.surface_properties());
  const int steps = 400;
  Vector<2> before = Vector<2>::Zero();
  double largest = 0;
  for (int n = 0; n <= steps; ++n) {
    const double angle = 1.5 * std::numbers::pi * (n / double(steps)) - 0.5 * std::numbers::pi;  // round the upper right corner
    InterfaceParticles<2> particles;
    add_particle<2>(particles, Vector<2>(high + 0.6 * dx * std::cos(angle), high + 0.6 * dx * std::sin(angle)), dx);
    if (particles.position[0].maxCoeff() <= high) continue;
    coupler.first_exchange(0, window, scene.surface, particles);
    coupler.last_exchange(pressure_field<2>(particles, [](const Vector<2>&) { return 1000.0; }));
    const Vector<2> load = coupler.total_load(0) / (1000 * dx);
    if (n > 0 && before.norm() > 0) largest = std::max(largest, (load - before).norm());
    before = load;
  }
  std::printf("[ largest change between two places: %.4f of p dx ]\n", largest);
  EXPECT_LT(largest, 0.02);
}

// The face of a body that stands at a wall looks into it, and there is no fluid past its edge.
// Seen to fail: with every face uncovered.
TEST(ConvexCorner, IsNoneAtAWall) {
  Case c = block_in_water();
  // Water over a block that fills the tank from wall to wall.
  c.fluid->bodies.resize(1);
  c.fluid->bodies[0].shape = box({0, high, 0}, {width, width, 0});
  c.structure->bodies[0].shape = box({0, low, 0}, {width, high, 0});
  fluid::Fluid<2> fluid(c);
  structure::Structure<2> structure(c);
  const Surface<2> surface = structure.surface();
  fluid.begin_window(0, to_ticks(window));
  const InterfaceParticles<2> particles = fluid.see_surface(surface);
  std::size_t at_walls = 0;
  for (std::uint32_t k : particles.covered) at_walls += std::abs(surface.normal[k][0]) > 0.5;
  EXPECT_EQ(at_walls, particles.covered.size());
  EXPECT_EQ(at_walls, 2 * static_cast<std::size_t>(std::lround((high - low) / (0.5 * dx))));
  InterfacePairs<2> pairs(c.fluid->numerics.smoothing_length_ratio * dx, dx);
  pairs.find(particles, surface);
  EXPECT_FALSE(pairs.pairs().empty());
  EXPECT_TRUE(pairs.back_facing_pairs().empty());
}

// Water before a plate does not see the water behind it, but that past its edge.
// Seen to fail: with every pair past a body kept; with none kept.
TEST(ConvexCorner, IsThatOfAPlateToo) {
  Case c = block_in_water();
  constexpr double left = 0.19, right = 0.2, tip = 0.2;
  c.structure->bodies[0].shape = box({left, -0.04, 0}, {right, tip, 0});
  c.structure->bodies[0].clamps = {box({-1, -1, -1}, {1, 0, 1})};
  c.fluid->bodies.resize(1);
  Shape& water = c.fluid->bodies[0].shape;
  water.kind = Shape::Kind::difference;
  water.parts = {box({0, 0, 0}, {width, width, 0}), box({left, 0, 0}, {right, tip, 0})};
  fluid::Fluid<2> fluid(c);
  structure::Structure<2> structure(c);
  fluid.begin_window(0, to_ticks(window));
  fluid.see_surface(structure.surface());
  const auto& x = fluid.state().position;
  const auto& neighbours = fluid.neighbours();
  int past = 0;
  for (int i = 0; i < static_cast<int>(x.size()); ++i) {
    if (x[i][0] > left || x[i][1] > tip) continue;  // before the plate
    neighbours.for_each(i, [&](int j, float) {
      const Vector<2>& other = x[j];
      if (other[0] <= left) return;
      ++past;
      // Where the line leaves the slab of the plate it is above its tip.
      EXPECT_GT(x[i][1] + (other[1] - x[i][1]) * std::min(1.0, (right - x[i][0]) / (other[0] - x[i][0])), tip - 1e-9)
          << x[i].transpose() << " sees " << other.transpose();
    });
  }
  EXPECT_GT(past, 4);
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
  const InterfaceParticles<3> particles = fluid.see_surface(surface);
  Coupler<3> coupler(c, properties(surface.position.size()));
  coupler.first_exchange(0, 1e-6, surface, particles);
  coupler.last_exchange(pressure_field<3>(particles, [](const Vector<3>& x) { return rho * g * (width - x[1]); }));
  EXPECT_LT(coupler.audit().force_error, 1e-13);
  double up = 0, down = 0;
  for (std::size_t k = 0; k < surface.position.size(); ++k) (surface.normal[k][1] < -0.5 ? up : down) += coupler.surface_load().force[k][1];
  return {down / (-rho * g * (width - high) * side * side), up / (rho * g * (width - low) * side * side)};
}

// The same of a cube with its edges and corners: its faces carry pressure times area.
// Seen to fail with patches that hide their neighbours across an edge (riemann: 0.956 and 0.996 with patches of dx and dx/2); without
// midpoint_rest() (riemann: 0.993 and 0.995).
TEST(ConvexCorner, LeavesTheLoadsOfACubeExact) {
  for (const auto& [scheme, name, meaning] : interface_schemes)
    for (double patch : {1.0, 0.5}) {
      const auto [top, bottom] = loads_of_a_cube(scheme, patch);
      std::printf("[ %-7s patches of %.1f dx: top %.5f, bottom %.5f of p A ]\n", name, patch, top, bottom);
      EXPECT_NEAR(top, 1, 1e-3) << name;
      EXPECT_NEAR(bottom, 1, 1e-3) << name;
    }
}

}  // namespace
}  // namespace tern::coupler::testing
