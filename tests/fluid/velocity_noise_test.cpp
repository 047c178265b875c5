// The damping of particle-scale velocity noise: what it takes, and what it must leave alone.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

constexpr unsigned seed = 20260411;

/// A jittered block of n particles a side at unit spacing in free space, on which nothing acts but the damping: the
/// pressure solve accepts p = 0.
template <int D>
Fluid<D> block(int n, double jitter_size) {
  const double size = n;
  Case c = scene(D, 1.0, {box({0, 0, 0}, {size, size, size})}, {}, 0);
  c.fluid->numerics.pressure_tolerance = 1e30;
  c.fluid->numerics.shifting = 0;
  c.fluid->numerics.noise_damping = 0.2;
  Fluid<D> fluid(c);
  std::mt19937 random(seed);
  jitter(fluid, jitter_size, random);
  return fluid;
}

template <int D, class Field>
State<D> with_velocity(const Fluid<D>& fluid, Field&& field) {
  State<D> state = fluid.state();
  for (std::size_t i = 0; i < state.size(); ++i) state.velocity[i] = field(state.position[i]);
  return state;
}

double angular_momentum(const State<2>& state, const std::vector<Vector<2>>& position) {
  double sum = 0;
  for (std::size_t i = 0; i < state.size(); ++i)
    sum += position[state.id[i]][0] * state.velocity[i][1] - position[state.id[i]][1] * state.velocity[i][0];
  return sum;
}

// The step is tiny, so that the particles stand still; the time scale is 0.15 dx/|u|max, so one step damps a share
// 0.2 dt |u|max / (0.15 dx).
constexpr double dt = 1e-3;

template <int D>
double largest_change_of_affine_field() {
  Fluid<D> fluid = block<D>(D == 2 ? 16 : 8, 0.2);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  Matrix<D> gradient;
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) gradient(a, b) = 0.1 * normal(random);
  const State<D> before = with_velocity(fluid, [&](const Vector<D>& x) { return Vector<D>(gradient * x); });
  fluid.set_state(before);
  step(fluid, dt);
  double largest = 0;
  // The particles have moved with the affine field over half the step, which leaves it affine.
  for (std::size_t i = 0; i < fluid.state().size(); ++i)
    largest = std::max(largest, (fluid.state().velocity[i] - before.velocity[fluid.state().id[i]]).norm());
  return largest;
}

// Measured 7e-16 (2D) and 4e-15 (3D) of velocities of order 1. Seen to fail: without the reconstruction, and with the
// moment matrix of all neighbours inverted transposed to the sum.
TEST(VelocityNoise, LeavesAnAffineFieldAlone) {
  EXPECT_LT(largest_change_of_affine_field<2>(), 1e-12);
  EXPECT_LT(largest_change_of_affine_field<3>(), 1e-12);
}

// Seen to fail: with the reconstruction of one side only (momentum), and with the whole jump exchanged in place of its
// part along the pair (angular momentum).
TEST(VelocityNoise, ConservesBothMomentaAndTakesEnergy) {
  Fluid<2> fluid = block<2>(16, 0.2);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  fluid.set_state(with_velocity(fluid, [&](const Vector<2>&) { return Vector<2>(normal(random), normal(random)); }));
  const State<2> before = fluid.state();
  std::vector<Vector<2>> middle(before.size());
  for (std::size_t i = 0; i < before.size(); ++i)
    middle[before.id[i]] = before.position[i] + 0.5 * seconds(to_ticks(dt)) * before.velocity[i];
  const Vector<2> momentum = fluid.momentum();
  const double spin = angular_momentum(before, middle), energy = fluid.energies().kinetic;
  step(fluid, dt);
  EXPECT_LT((fluid.momentum() - momentum).norm(), 1e-12 * density * 256);
  EXPECT_NEAR(angular_momentum(fluid.state(), middle), spin, 1e-10 * 256 * 16);
  // Noise loses energy at about twice the share per step that the differences lose.
  const double share = 0.2 * seconds(to_ticks(dt)) *
                       std::sqrt(ordered_max(256, 0.0, [&](std::ptrdiff_t i) { return before.velocity[i].squaredNorm(); })) / 0.15;
  const double lost = 1 - fluid.energies().kinetic / energy;
  EXPECT_GT(lost, 0.5 * share);
  EXPECT_LT(lost, 4 * share);
}

/// Share of its energy that a shear wave u_x = sin(2 pi y / length) loses in a step, deep in a block of 48 x 48.
double loss(double length) {
  Fluid<2> fluid = block<2>(48, 0);
  const double k = 2 * std::numbers::pi / length;
  fluid.set_state(with_velocity(fluid, [&](const Vector<2>& x) { return Vector<2>(std::sin(k * x[1]), 0); }));
  const State<2> before = fluid.state();
  step(fluid, dt);
  double sum = 0, lost = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    const Vector<2>& u = before.velocity[fluid.state().id[i]];
    const Vector<2>& x = before.position[fluid.state().id[i]];
    if ((x.array() < 6).any() || (x.array() > 42).any()) continue;
    sum += u.squaredNorm();
    lost += u.squaredNorm() - fluid.state().velocity[i].squaredNorm();
  }
  return lost / sum;
}

// Fourth order: halving the wave length multiplies the loss by 16. Seen to fail: without the reconstruction (4).
TEST(VelocityNoise, DampsSmoothFieldsWithTheFourthPowerOfTheWaveNumber) {
  const double ratio = loss(12) / loss(24);
  EXPECT_GT(ratio, 12);
  EXPECT_LT(ratio, 17);
}

}  // namespace
}  // namespace tern::fluid::testing
