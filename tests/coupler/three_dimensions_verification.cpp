// A slice in three dimensions of a scene that does not change along its width: the same history as in two dimensions. Poisson's
// ratio is 0, for the sides of the plate are free where those of two dimensions are held.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "coupler/window.hpp"
#include "fixtures/interface_scenes.hpp"
#include "fluid/fluid.hpp"
#include "structure/coupled_structure.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double water_spacing = 0.01, plate_spacing = 0.01, length = 0.16, depth = 0.08, thickness = 0.04, window = 5e-4;

struct Slice {
  std::vector<double> deflection;  ///< of the middle of the plate's upper face, by window [m]
  std::vector<double> load;        ///< of the water on the plate, per width and weight of the water above it
  double across = 0;               ///< largest force along the width over the weight of the water
  double imbalance = 0;            ///< largest sum of the forces on both sides, over the sum of their magnitudes
};

/// Water on an elastic floor that is clamped at both ends; its weight sets in at once. `width`: of the slice, in spacings; in 2D not used.
template <int D>
Slice run(int width, double until) {
  const double wide = D == 2 ? 1 : width * water_spacing;
  Case c = scene(D, water_spacing);
  c.end_time = until;
  c.gravity = constant(0, -9.81);
  c.coupling.riemann_limiter = 3;
  c.coupling.max_iterations = 1;
  WallCase tank;
  tank.name = "tank";
  tank.container = true;
  tank.open = {"y_max", "y_min"};
  tank.shape = box({0, -0.1, 0}, {length, 2 * depth, wide});
  c.walls.push_back(tank);
  FluidBody water;
  water.velocity = constant(0);
  water.shape = box({0, 0, 0}, {length, depth, wide});
  c.fluid->bodies = {water};
  StructureBody& plate = c.structure->bodies[0];
  const double held = 2 * plate_spacing;
  plate.shape = box({-held, -thickness, 0}, {length + held, 0, wide});
  plate.spacing = plate_spacing;
  plate.density = 2000;
  plate.young_modulus = 2e6;
  plate.poisson_ratio = 0;
  plate.velocity = constant(0);
  plate.clamps = {box({-1, -1, -1}, {0, 1, 2}), box({length, -1, -1}, {1, 1, 2})};

  fluid::Fluid<D> fluid(c);
  structure::Structure<D> structure(c);
  structure::CoupledStructure<D> coupled(structure, c.coupling.algorithm);
  Coupler<D> coupler(c, structure.surface_properties());
  // The points of the upper face in the middle of the length.
  const auto start = structure.surface();
  std::vector<std::size_t> middle;
  for (std::size_t k = 0; k < start.position.size(); ++k)
    if (start.normal[k][1] > 0.5 && std::abs(start.position[k][0] - 0.5 * length) < 0.6 * plate_spacing) middle.push_back(k);

  Slice slice;
  const double weight = 1000 * 9.81 * depth * length * wide;
  const Ticks duration = to_ticks(window);
  for (Ticks now = 0; now < to_ticks(until); now += duration) {
    run_window<D>(fluid, coupled, coupler, now, duration);
    const auto surface = structure.surface();
    double sum = 0;
    for (std::size_t k : middle) sum += surface.position[k][1];
    slice.deflection.push_back(sum / static_cast<double>(middle.size()));
    const Vector<D> load = coupler.total_load(0);
    slice.load.push_back(-load[1] / weight);
    if constexpr (D == 3) slice.across = std::max(slice.across, std::abs(load[2]) / weight);
    slice.imbalance = std::max(slice.imbalance, coupler.audit().force_error);
  }
  return slice;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Largest distance of two histories over the largest value of the second.
double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double distance = 0, largest = 0;
  for (std::size_t n = 0; n < b.size(); ++n) {
    distance = std::max(distance, std::abs(a[n] - b[n]));
    largest = std::max(largest, std::abs(b[n]));
  }
  return distance / largest;
}

// The side walls, which the plate meets with its long edges, take nothing of the load: images of the water behind them
// (coupler/schemes/interface_pairs.hpp). Measured: the largest deflection within 0.3 and 0.3 %, the load 1.012 and 1.006 of that in 2D. The
// swing is 0.8 and 0.6 % faster, by which the curves are apart by 2.5 and 1.5 % of the largest at the end of the second swing.
// Without images in 3D the load is 0.904 and 0.936 of it.
// Seen to fail, in 3D alone: with 1.9 for the factor 2 of b_ik; without images; with half the flux through faces in the divergence.
TEST(ThreeDimensions, AreTheTwoOfASliceThatDoesNotChangeAlongItsWidth) {
  constexpr double until = 0.05;
  const Slice plane = run<2>(0, until), narrow = run<3>(6, until), wide = run<3>(12, until);
  for (const auto& [slice, width] : {std::pair{&narrow, 6}, {&wide, 12}}) {
    const double deflection = apart(slice->deflection, plane.deflection), load = mean(slice->load) / mean(plane.load);
    std::printf("[ %d spacings wide: deflection apart from that in 2D by %.4f of the largest, load %.4f of it ]\n", width, deflection,
                load);
    EXPECT_LT(deflection, width == 6 ? 0.03 : 0.018) << width << " spacings wide";
    EXPECT_NEAR(*std::ranges::min_element(slice->deflection) / *std::ranges::min_element(plane.deflection), 1, 0.005)
        << width << " spacings wide";
    EXPECT_NEAR(load, 1, 0.015) << width << " spacings wide";
  }
  for (const Slice& slice : {narrow, wide}) {
    EXPECT_LT(slice.across, 1e-3);
    EXPECT_LT(slice.imbalance, 1e-13);
  }
}

}  // namespace
}  // namespace tern::coupler::testing
