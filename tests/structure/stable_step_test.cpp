// The measured step of the explicit integration: below it no motion grows, above it one does.

#include "structure/stable_step.hpp"

#include <gtest/gtest.h>

#include <random>

#include "fixtures/structure_scenes.hpp"
#include "structure/time_step.hpp"

namespace tern::structure::testing {
namespace {

/// A plate across the axes of its lattice, so that its sides are stairs; a ball about its foot is the clamp.
StructureCase leaning_plate(double diffusion) {
  StructureBody b = body("plate", {0, 0, 0}, {1, 1, 0}, 1.49);
  b.shape.kind = Shape::Kind::polygon;
  b.shape.vertices = {{79.9, 15.75}, {87.3253, 16.1089}, {85.2519, 59.0038}, {77.8266, 58.6449}};
  b.poisson_ratio = 0.176;
  b.clamps.emplace_back();
  b.clamps[0].kind = Shape::Kind::ball;
  b.clamps[0].center = {83.6127, 15.9295, 0};
  b.clamps[0].radius = 5.9472;
  StructureCase structure = *scene(2, {b}).structure;
  structure.numerics.riemann_diffusion = diffusion;
  return structure;
}

/// By what a small random motion has grown after 400 steps of `share` of the measured one.
template <int D>
double growth(const StructureCase& structure, double share) {
  const Reference<D> reference = build_reference<D>(structure);
  State<D> state = state_at_rest(reference, 0);
  Workspace<D> work = workspace_for(reference);
  std::mt19937 random(3);
  set_rows<D>(reference, state.velocity, [&](const Vector<D>&) { return random_vector<D>(random, 1e-12); });
  for (const auto row : reference.particle_row)
    if (reference.inverse_mass[row] == 0)
      for (auto& axis : state.velocity) axis[row] = 0;
  const auto speed = [&] {
    double square = 0;
    for (const auto row : reference.particle_row) square += reference.mass[row] * row_vector<D>(state.velocity, row).squaredNorm();
    return std::sqrt(square);
  };
  const double before = speed(), dt = share * stable_steps_at_rest(reference)[0];
  evaluate(reference, state, work);
  for (int n = 0; n < 20 && speed() < 1e6 * before; ++n) verlet(reference, 0, 20 * dt, 20, state, work);
  return speed() / before;
}

// Without diffusion the bound is exact. Seen to fail: with 2 vectors in place of 30.
TEST(StableStep, IsTheLastBeforeMotionsGrow) {
  StructureCase whole = block<2>(8), solid = block<3>(5);
  whole.numerics.riemann_diffusion = solid.numerics.riemann_diffusion = 0;
  for (const auto& [structure, name] : {std::pair{whole, "block"}, std::pair{leaning_plate(0), "plate"}}) {
    EXPECT_LT(growth<2>(structure, 0.98), 2) << name;
    EXPECT_GT(growth<2>(structure, 1.03), 1e3) << name;
  }
  EXPECT_LT(growth<3>(solid, 0.98), 2);
  EXPECT_GT(growth<3>(solid, 1.03), 1e3);
}

// With it the largest frequency and the largest rate may belong to two motions, so that there is some room above. Seen to fail: with 2
// vectors.
TEST(StableStep, HoldsWithDiffusionToo) {
  EXPECT_LT(growth<2>(leaning_plate(1), 0.98), 2);
  EXPECT_GT(growth<2>(leaning_plate(1), 1.3), 1e3);
}

// Explicit steps of 0.3 dx/c blew this plate up in its first window. Seen to fail: with 2 vectors.
TEST(StableStep, IsShorterForALeaningPlateThanItsWaveSpeedTells) {
  const Reference<2> reference = build_reference<2>(leaning_plate(1));
  const Body& plate = reference.bodies[0];
  EXPECT_LT(stable_steps_at_rest(reference)[0], 0.3 * plate.spacing / plate.material.pressure_wave_speed());
}

TEST(StableStep, IsThatOfAMode) {
  for (const auto& [omega, decay] : {std::pair{2.0, 0.0}, std::pair{2.0, 0.7}, std::pair{0.0, 3.0}}) {
    const auto radius = [&](double dt) {  // of the map of (x, v)
      const double trace = 2 - dt * dt * omega * omega - dt * decay, determinant = 1 - dt * decay;
      const double root = trace * trace / 4 - determinant;
      return root < 0 ? std::sqrt(determinant) : std::abs(trace / 2) + std::sqrt(root);
    };
    const double dt = longest_stable_step(omega, decay);
    EXPECT_LE(radius(0.999 * dt), 1 + 1e-12);
    EXPECT_GT(radius(1.001 * dt), 1 + 1e-6);
  }
}

}  // namespace
}  // namespace tern::structure::testing
