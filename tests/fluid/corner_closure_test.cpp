// What a uniform pressure does to particles beside the corners of a body: nothing, with the fluid's own part and what the interface gives
// back.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

constexpr double dx = 0.05, patch = 0.5 * dx, low = 0.4, high = 0.8, width = 1.2;

/// Adds the faces of a box that look out of it (`sense` 1) or into it (-1), in patches of half a spacing; `but_top`: without that of y_max.
template <int D>
void add_faces(const Vector<D>& from, const Vector<D>& to, double sense, bool but_top, Surface<D>& surface) {
  for (int axis = 0; axis < D; ++axis)
    for (const double side : {-1.0, 1.0}) {
      if (but_top && axis == 1 && side > 0) continue;
      std::array<int, 3> count{1, 1, 1};
      for (int c = 0; c < D; ++c)
        if (c != axis) count[c] = static_cast<int>(std::lround((to[c] - from[c]) / patch));
      for (int a = 0; a < count[0]; ++a)
        for (int b = 0; b < count[1]; ++b)
          for (int c = 0; c < count[2]; ++c) {
            const std::array<int, 3> cell{a, b, c};
            Vector<D> x;
            for (int d = 0; d < D; ++d) x[d] = d == axis ? (side > 0 ? to[d] : from[d]) : from[d] + (cell[d] + 0.5) * patch;
            surface.position.push_back(x);
            surface.velocity.push_back(Vector<D>::Zero());
            surface.normal.push_back(sense * side * Vector<D>::Unit(axis));
            surface.area.push_back(std::pow(patch, D - 1));
          }
    }
}

/// Largest dx |E_i| of the particles on their lattice that see the body: the acceleration by a uniform pressure p is -2 p E_i/rho, with the
/// fluid around, the part of the faces that the interface does not bear, and the interface's reaction.
template <int D>
double largest_gap(const Case& c, const Surface<D>& surface, double below) {
  Fluid<D> fluid(c);
  fluid.begin_window(0, to_ticks(1e-9));
  fluid.see_surface(surface);
  const Boundary<D>& boundary = fluid.boundary();
  double largest = 0;
  int seen = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    if (!boundary.sees_structure(i) || fluid.state().position[i][1] > below) continue;
    const Vector<D> gap = fluid.neighbours().kernel_gradient[i] + boundary.sums.wall_gradient[i] + boundary.sums.unborne_gradient[i] +
                          boundary.sums.reaction[i];
    largest = std::max(largest, dx * gap.norm());
    ++seen;
  }
  EXPECT_GT(seen, 50);
  return largest;
}

/// A block with water all round.
template <int D>
double gap_round_a_block() {
  Shape block = box({low, low, D == 3 ? low : -1}, {high, high, D == 3 ? high : 1}), water;
  water.kind = Shape::Kind::difference;
  water.parts = {box({0, 0, 0}, {width, width, D == 3 ? width : 0}), block};
  Surface<D> surface;
  add_faces<D>(Vector<D>::Constant(low), Vector<D>::Constant(high), 1, false, surface);
  return largest_gap<D>(scene(D, dx, {water}, {tank({0, 0, 0}, {width, 2 * width, D == 3 ? width : 0})}), surface, 1e9);
}

/// Water in a bucket of no thickness; away from its own surface.
template <int D>
double gap_in_a_bucket() {
  Surface<D> surface;
  add_faces<D>(Vector<D>::Zero(), Vector<D>::Constant(high), -1, true, surface);
  return largest_gap<D>(scene(D, dx, {box({0, 0, 0}, {high, high, D == 3 ? high : 0})}), surface, high - 4 * dx);
}

// The interface bears of a face beside a convex corner, or in a concave one, only the share of it that is the load of a half space
// (borne_share); the rest is the fluid's. What a particle gets of both is what the faces have, and nothing of a uniform pressure is left
// but what the lattice leaves of its sums. Measured: 0.005, in a bucket 0.004.
// Seen to fail: with a borne share of 1 everywhere in the fluid (0.050, 3D 0.064; in a bucket 0.052, 0.059).
TEST(Corners, LeaveNothingOfAUniformPressureToParticles) {
  const double block = gap_round_a_block<2>(), block_3d = gap_round_a_block<3>();
  const double bucket = gap_in_a_bucket<2>(), bucket_3d = gap_in_a_bucket<3>();
  std::printf("[ block %.4f, 3D %.4f; bucket %.4f, 3D %.4f ]\n", block, block_3d, bucket, bucket_3d);
  for (const double gap : {block, block_3d, bucket, bucket_3d}) EXPECT_LT(gap, 0.02);
}

}  // namespace
}  // namespace tern::fluid::testing
