// Gradient, divergence and Laplacian of the fluid as the projection step uses them.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"
#include "fluid/pressure/divergence.hpp"
#include "fluid/pressure/pressure_gradient.hpp"

namespace tern::fluid::testing {
namespace {

constexpr unsigned seed = 20240118;

/// A block of n particles a side without walls, unit spacing.
template <int D>
Case block(int n, double g = 0) {
  const double size = n;
  return scene(D, 1.0, {box({0, 0, 0}, {size, size, size})}, {}, g);
}

template <int D>
Vector<D> random_vector(std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  Vector<D> v;
  for (int c = 0; c < D; ++c) v[c] = normal(random);
  return v;
}

/// Largest error of the acceleration by a linear pressure field, relative to it, over particles deep inside a block; `level`: the largest
/// change of the acceleration when that is added to the pressure, with what keeps particles in order.
template <int D>
double linear_gradient_error(int n, double level = 0) {
  std::mt19937 random(seed);
  Fluid<D> fluid(block<D>(n));
  jitter(fluid, 0.2, random);
  constexpr double dt = 1e-3;
  fluid.begin_window(0, to_ticks(dt));
  fluid.see_surface({});
  const Vector<D> slope = 1e3 * random_vector<D>(random);
  State<D> state = fluid.state();
  for (std::size_t i = 0; i < state.size(); ++i) state.pressure[i] = 7 + slope.dot(state.position[i]);
  std::vector<Vector<D>> velocity(state.size(), Vector<D>::Zero());
  const bool with_order = level != 0;  // which is not exact, by intention
  apply_pressure_gradient(fluid.reference(), dt, fluid.neighbours(), fluid.boundary(), fluid.correction(), state, nullptr, velocity,
                          with_order ? &velocity : nullptr);
  std::vector<Vector<D>> expected(state.size(), -dt * slope / density);
  if (with_order) {
    for (double& p : state.pressure) p += level;
    expected.assign(state.size(), Vector<D>::Zero());
    apply_pressure_gradient(fluid.reference(), dt, fluid.neighbours(), fluid.boundary(), fluid.correction(), state, nullptr, expected,
                            &expected);
  }
  double largest = 0;
  int checked = 0;
  for (std::size_t i = 0; i < state.size(); ++i) {
    const Vector<D>& x = state.position[i];
    if ((x.array() < 4.3).any() || (x.array() > n - 4.3).any()) continue;
    largest = std::max(largest, (velocity[i] - expected[i]).norm() / dt);
    ++checked;
  }
  EXPECT_GE(checked, 20);
  return largest / (slope.norm() / density);
}

// Measured 8e-16 in 2D and 3D. Seen to fail: with C replaced by the identity in the blended form, and with off-diagonal
// entries of M left out.
TEST(PressureGradient, IsExactForALinearFieldOnTwentyPercentDisorder) {
  const double error2 = linear_gradient_error<2>(16), error3 = linear_gradient_error<3>(12);
  EXPECT_LT(error2, 1e-12);
  EXPECT_LT(error3, 1e-12);
}

// Only differences of the pressure act inside. Measured: 3e-10 (2D) and 2e-10 (3D) of a level of 1e6 times the differences. Seen to
// fail: with p_i in place of p_i less the least of its neighbours (1e5).
TEST(PressureGradient, DoesNotDependOnTheLevelOfThePressureInside) {
  const double change2 = linear_gradient_error<2>(16, 1e9), change3 = linear_gradient_error<3>(12, 1e9);
  std::printf("[ change by a level of 1e9 Pa: %.1e, %.1e ]\n", change2, change3);
  EXPECT_LT(change2, 1e-8);
  EXPECT_LT(change3, 1e-8);
}

/// omega^2 dt^2 of the stiffest waves of displacement along x on a periodic lattice, under a pressure that rises by `slope` per spacing
/// across them.
template <int D>
double stiffest_vibration(double slope, double smoothing_length_ratio) {
  constexpr int n = 20;
  constexpr double size = 1e-5, dt = 1e-3;  // displacement in spacings
  double largest = 0;
  for (int k = 4; k <= 7; ++k) {  // the stiffest is among them
    Case c = scene(D, 1.0, {box({0, 0, 0}, {n, n, D == 2 ? 0.0 : 8})}, {}, 0);
    make_periodic(c, {0, 0, 0}, {n, n, 8}, D == 2 ? "xy" : "xyz");
    c.fluid->numerics.smoothing_length_ratio = smoothing_length_ratio;
    Fluid<D> fluid(c);
    State<D> state = fluid.state();
    std::vector<double> displacement;
    for (auto& x : state.position) {
      displacement.push_back(size * std::sin(2 * std::numbers::pi * k * x[0] / n));
      x[0] += displacement.back();
    }
    fluid.set_state(state);
    fluid.begin_window(0, to_ticks(dt));
    fluid.see_surface({});
    state = fluid.state();
    for (std::size_t i = 0; i < state.size(); ++i) state.pressure[i] = slope * state.position[i][1];
    std::vector<Vector<D>> velocity(state.size(), Vector<D>::Zero());
    apply_pressure_gradient(fluid.reference(), dt, fluid.neighbours(), fluid.boundary(), fluid.correction(), state, nullptr, velocity,
                            &velocity);
    double along = 0, square = 0;
    for (std::size_t i = 0; i < state.size(); ++i) {
      if (std::abs(state.position[i][1] - 0.5 * n) > 0.3 * n) continue;  // the pressure jumps from the last row to the first
      const double d = displacement[state.id[i]];
      along -= velocity[i][0] * dt * d;
      square += d * d;
    }
    largest = std::max(largest, along / square);
  }
  return largest;
}

// The pressure of an impact makes no stiffer springs between particles than a window resolves: omega dt <= 1, from 2 on it would be
// unstable. Below that they are in proportion to the differences of the pressure. Measured: 0.96 to 1.04. Seen to fail: without the
// bound (1e6).
TEST(PressureGradient, KeepsParticlesInOrderByNoStifferSpringsThanAWindowResolves) {
  for (const double square : {stiffest_vibration<2>(1e15, 1.3), stiffest_vibration<2>(1e15, 1.5), stiffest_vibration<2>(1e15, 2),
                              stiffest_vibration<3>(1e15, 1.5)}) {
    std::printf("[ (omega dt)^2 at most %.3f ]\n", square);
    EXPECT_LT(square, 1.1);
    EXPECT_GT(square, 0.9);
  }
  EXPECT_NEAR(stiffest_vibration<2>(2e4, 1.5) / stiffest_vibration<2>(1e4, 1.5), 2, 1e-6);
}

/// | sum f.u - sum V p div u | relative to the sum of the sizes of its terms, for the forces of one projection step.
template <int D>
double adjoint_error(int n) {
  std::mt19937 random(seed);
  Case c = block<D>(n);
  c.fluid->numerics.gradient = GradientForm::sum;
  c.fluid->numerics.noise_damping = 0;
  c.fluid->numerics.density_relaxation = 0;
  c.fluid->numerics.shifting = 0;
  Fluid<D> fluid(c);
  jitter(fluid, 0.2, random);
  State<D> state = fluid.state();
  // Corners may count as spray, which feels no pressure: the outer layer stands still, so that it neither gives nor
  // takes.
  for (std::size_t i = 0; i < state.size(); ++i) {
    const Vector<D>& x = state.position[i];
    const bool outer = (x.array() < 1).any() || (x.array() > n - 1).any();
    state.velocity[i] = outer ? Vector<D>(Vector<D>::Zero()) : random_vector<D>(random);
  }
  fluid.set_state(state);
  const double dt = seconds(to_ticks(1e-3));
  step(fluid, dt);
  std::vector<Vector<D>> before(fluid.state().size());
  for (std::size_t i = 0; i < before.size(); ++i) before[i] = state.velocity[fluid.state().id[i]];
  ByAxis<D> packed;
  std::vector<double> divergence;
  compute_divergence<D>(fluid.period(), fluid.neighbours(), fluid.boundary(), fluid.correction(), fluid.state().particle_class, before,
                        nullptr, packed, divergence);
  double power = 0, work = 0, size = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    const Vector<D>& u = before[i];
    EXPECT_TRUE(!fluid.state().particle_class[i].spray() || u.norm() == 0);
    const double by_force = fluid.constants().mass / dt * (fluid.state().velocity[i] - u).dot(u);
    const double by_divergence = fluid.state().pressure[i] * fluid.constants().volume * divergence[i];
    power += by_force, work += by_divergence;
    size += std::abs(by_force) + std::abs(by_divergence);
  }
  return std::abs(power - work) / size;
}

// The symmetric form of the gradient is the adjoint of the divergence: pressure does exactly the work p div u. Measured
// 5e-16. Seen to fail: without the factor 2 of p_i in the symmetric form, and with the weights of the divergence squared.
TEST(PressureGradient, OfTheSymmetricFormIsTheAdjointOfTheDivergence) {
  const double error2 = adjoint_error<2>(20), error3 = adjoint_error<3>(9);
  EXPECT_LT(error2, 1e-12);
  EXPECT_LT(error3, 1e-12);
}

// Seen to fail: with the sign of p_j - p_i turned in the symmetric form.
TEST(PressureGradient, OfTheSymmetricFormConservesMomentum) {
  std::mt19937 random(seed);
  Case c = block<2>(20);
  c.fluid->numerics.gradient = GradientForm::sum;
  Fluid<2> fluid(c);
  jitter(fluid, 0.2, random);
  State<2> state = fluid.state();
  for (auto& u : state.velocity) u = random_vector<2>(random);
  fluid.set_state(std::move(state));
  const Vector<2> before = fluid.momentum();
  step(fluid, 1e-3);
  EXPECT_LT((fluid.momentum() - before).norm(), 1e-12 * density * 400);
}

/// -(A f)_i / V for the particle nearest to the middle of a block: the Laplacian of f there. h/dx = 1.5.
template <int D, class Field>
double laplacian(Fluid<D>& fluid, const Vector<D>& middle, Field&& f) {
  const auto& x = fluid.state().position;
  std::vector<double> values(fluid.pressure_matrix().rows(), 0), result(values.size());
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    values[i] = f(x[i]);
    if ((x[i] - middle).norm() < (x[nearest] - middle).norm()) nearest = i;
  }
  EXPECT_EQ(fluid.pressure_matrix().constant()[nearest], 0);
  fluid.pressure_matrix().multiply(values, result);
  return -result[nearest] / fluid.constants().volume;
}

// Uncalibrated it would be 2 M_xx = 1.9948 (2D). Seen to fail: without the factor 2 in the edges, and with weights not
// divided by M_xx.
TEST(Laplacian, OfASquareIsTwoOnALattice) {
  Fluid<2> fluid2(block<2>(15));
  solve(fluid2, 1e-3);
  const Vector<2> middle2 = Vector<2>::Constant(7.5);
  const double value = laplacian<2>(fluid2, middle2, [&](const Vector<2>& x) { return std::pow(x[0] - 7.5, 2); });
  EXPECT_NEAR(value, 2, 1e-6);
  EXPECT_NEAR(value * fluid2.constants().lattice.gradient_moment, 1.9948, 5.1e-5);
  Fluid<3> fluid3(block<3>(9));
  solve(fluid3, 1e-3);
  EXPECT_NEAR(laplacian<3>(fluid3, Vector<3>::Constant(4.5), [](const Vector<3>& x) { return std::pow(x[2] - 4.5, 2); }), 2, 1e-6);
}

// The relative error of a wave is -K_4 k^2/24, K_4 the fourth moment of the kernel, 1.667 h^2 in the continuum: -0.069
// (kh)^2, and nothing that would stay as the wave grows long. Measured -0.0709 at 20 dx to -0.0716 at 160 dx, for the
// fourth moment of the lattice is 3 % above the continuum's. Seen to fail: with weights not divided by M_xx (a plateau
// of -0.26 %), and with (1 - q/2)^2 in place of the cube in the weight.
TEST(Laplacian, OfAWaveConvergesWithTheSquareOfItsNumber) {
  Fluid<2> fluid(block<2>(15));
  solve(fluid, 1e-3);
  const double h = fluid.constants().kernel.smoothing_length();
  for (double wavelength : {20., 40., 80., 160.}) {
    const double k = 2 * std::numbers::pi / wavelength;
    const auto wave = [&](const Vector<2>& x) { return std::sin(k * (x[0] - 7.5) + 1); };
    const double error = laplacian<2>(fluid, Vector<2>::Constant(7.5), wave) / (-k * k * std::sin(1.0)) - 1;
    EXPECT_NEAR(error / (k * k * h * h), -0.069, 0.003) << "wavelength " << wavelength << " dx";
  }
}

}  // namespace
}  // namespace tern::fluid::testing
