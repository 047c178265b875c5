// The damping of particle-scale velocity noise: what it takes, and what it must leave alone.

#include <gtest/gtest.h>

#include <numeric>

#include "fixtures/fluid_scenes.hpp"
#include "fluid/motion/velocity_gradient.hpp"
#include "fluid/motion/velocity_noise.hpp"
#include "fluid/pressure/density_source.hpp"

namespace tern::fluid::testing {
namespace {

constexpr unsigned seed = 20260411;

constexpr double dt = 1e-3;

/// A jittered block of n particles a side at unit spacing in free space, with its pairs and corrections.
template <int D>
class Block {
 public:
  Block(int n, double jitter_size) : fluid_(case_of(n)) {
    std::mt19937 random(seed);
    jitter(fluid_, jitter_size, random);
    fluid_.begin_window(0, to_ticks(dt));
    fluid_.see_surface({});
  }
  const std::vector<Vector<D>>& position() const { return fluid_.prediction().position; }

  template <class Field>
  std::vector<Vector<D>> velocity(Field&& field) const {
    std::vector<Vector<D>> result;
    for (const auto& x : position()) result.push_back(field(x));
    return result;
  }
  /// Of the noise in a step, in the mean of all particles: chi dt/tau.
  double share(const std::vector<Vector<D>>& velocity) const {
    const PassingRate rate(fluid_.reference(), fluid_.constants().kernel.smoothing_length() / fluid_.constants().spacing);
    const std::vector<double> sizes = packed(velocity).gradient_size;
    const double sum = std::accumulate(sizes.begin(), sizes.end(), 0.0,
                                       [&](double before, double size) { return before + std::max(rate.by_gravity, rate.by_flow * size); });
    return 0.2 * dt * sum / static_cast<double>(sizes.size());
  }
  /// After a step.
  std::vector<Vector<D>> damped(std::vector<Vector<D>> velocity) const {
    damp_velocity_noise(fluid_.reference(), dt, fluid_.neighbours(), fluid_.state().particle_class, packed(velocity), velocity);
    return velocity;
  }

 private:
  PackedVelocities<D> packed(const std::vector<Vector<D>>& velocity) const {
    PackedVelocities<D> result;
    by_axis<D>(velocity, result.velocity);
    compute_velocity_gradient(fluid_.period(), fluid_.neighbours(), fluid_.correction(), fluid_.state().particle_class, result);
    return result;
  }
  static Case case_of(int n) {
    const double size = n;
    Case c = scene(D, 1.0, {box({0, 0, 0}, {size, size, size})}, {}, 0);
    c.fluid->numerics.noise_damping = 0.2;
    return c;
  }
  Fluid<D> fluid_;
};

struct Totals {
  Vector<2> momentum = Vector<2>::Zero();
  double spin = 0, energy = 0;
};

Totals totals(const std::vector<Vector<2>>& position, const std::vector<Vector<2>>& velocity) {
  Totals sum;
  for (std::size_t i = 0; i < position.size(); ++i) {
    sum.momentum += velocity[i];
    sum.spin += position[i][0] * velocity[i][1] - position[i][1] * velocity[i][0];
    sum.energy += 0.5 * velocity[i].squaredNorm();
  }
  return sum;
}

template <int D>
double largest_change_of_affine_field() {
  const Block<D> block(D == 2 ? 16 : 8, 0.2);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  Matrix<D> gradient;
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) gradient(a, b) = 0.1 * normal(random);
  const auto before = block.velocity([&](const Vector<D>& x) { return Vector<D>(gradient * x); });
  const auto after = block.damped(before);
  double largest = 0;
  for (std::size_t i = 0; i < before.size(); ++i) largest = std::max(largest, (after[i] - before[i]).norm());
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
  const Block<2> block(16, 0.2);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  const auto velocity = block.velocity([&](const Vector<2>&) { return Vector<2>(normal(random), normal(random)); });
  const Totals before = totals(block.position(), velocity), after = totals(block.position(), block.damped(velocity));
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * 256);
  EXPECT_NEAR(after.spin, before.spin, 1e-12 * 256 * 16);
  // Noise loses energy at about twice the share per step that the differences lose.
  const double lost = 1 - after.energy / before.energy;
  EXPECT_GT(lost, 0.5 * block.share(velocity));
  EXPECT_LT(lost, 4 * block.share(velocity));
}

/// A shear wave u_x = sin(2 pi y / length).
std::vector<Vector<2>> shear_wave(const Block<2>& block, double length) {
  const double k = 2 * std::numbers::pi / length;
  return block.velocity([&](const Vector<2>& x) { return Vector<2>(std::sin(k * x[1]), 0); });
}

/// Share of its energy that it loses in a step, deep in a block of 48 x 48.
double loss(const Block<2>& block, double length) {
  const auto before = shear_wave(block, length), after = block.damped(before);
  double sum = 0, lost = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Vector<2>& x = block.position()[i];
    if ((x.array() < 6).any() || (x.array() > 42).any()) continue;
    sum += before[i].squaredNorm();
    lost += before[i].squaredNorm() - after[i].squaredNorm();
  }
  return lost / sum;
}

// Seventh order, because the rate is that of the flow itself: halving the wave number divides the loss by 128. Seen to fail: without the
// reconstruction (8); with all of the unexplained difference, however small (32); with the rate of the largest speed (64).
TEST(VelocityNoise, DampsSmoothFieldsWithTheSeventhPowerOfTheWaveNumber) {
  const Block<2> block(48, 0);
  const double ratio = loss(block, 20) / loss(block, 40);
  std::printf("[ loss of a wave of 20 spacings over that of one of 40: %.1f ]\n", ratio);
  EXPECT_GT(ratio, 96);
  EXPECT_LT(ratio, 144);
}

// Seen to fail: with a motion called resolved up to ten times the differences that the linear fields explain.
TEST(VelocityNoise, TakesAllThatALinearFieldDoesNotExplainOfAShortWave) {
  const Block<2> block(48, 0);
  const double lost = loss(block, 4), share = block.share(shear_wave(block, 4));
  std::printf("[ loss of a wave of 4 spacings: %.4f of its energy in a step of share %.4f ]\n", lost, share);
  EXPECT_GT(lost, 0.5 * share);
}

// A wave in water that moves as a whole at a hundred times its speed loses as much. Seen to fail: with the rate of the largest speed.
TEST(VelocityNoise, IsTheSameForEveryObserver) {
  const Block<2> block(32, 0.1);
  const auto at_rest = shear_wave(block, 6);
  auto moving = at_rest;
  for (auto& u : moving) u[1] += 100;
  const auto of_rest = block.damped(at_rest), of_moving = block.damped(moving);
  double largest = 0;
  for (std::size_t i = 0; i < at_rest.size(); ++i) largest = std::max(largest, (of_rest[i] - of_moving[i] + Vector<2>(0, 100)).norm());
  EXPECT_LT(largest, 1e-11);
}

}  // namespace
}  // namespace tern::fluid::testing
