// Viscous and periodic flows with closed solutions.

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

constexpr double pi = std::numbers::pi;

/// Flow along x between walls at y = 0 and 1, driven by gravity from rest; n layers.
Case poiseuille(int n, double nu, double g) {
  const double width = std::max(0.5, 10.0 / n);
  Case c = scene(2, 1.0 / n, {box({0, 0, 0}, {width, 1, 0})}, {tank({0, 0, 0}, {width, 1, 0}, {"x_min", "x_max"})}, 0);
  make_periodic(c, {0, -1, 0}, {width, 2, 0}, "x");
  c.gravity[0] = Expression(g);
  c.fluid->viscosity = nu * density;
  return c;
}

/// u(y, t) = g y (1 - y)/(2 nu) - sum_odd 4 g/(nu (k pi)^3) sin(k pi y) exp(-(k pi)^2 nu t)
double starting_profile(double y, double t, double nu, double g) {
  double u = 0.5 * g / nu * y * (1 - y);
  for (int k = 1; k < 60; k += 2) u -= 4 * g / (nu * std::pow(k * pi, 3)) * std::sin(k * pi * y) * std::exp(-std::pow(k * pi, 2) * nu * t);
  return u;
}

/// Root mean square error of the profile over the largest speed of the steady one.
double profile_error(const Fluid<2>& fluid, double nu, double g) {
  double sum = 0;
  const auto& state = fluid.state();
  for (std::size_t i = 0; i < state.size(); ++i)
    sum += std::pow(state.velocity[i][0] - starting_profile(state.position[i][1], seconds(state.time), nu, g), 2);
  return std::sqrt(sum / static_cast<double>(state.size())) / (0.125 * g / nu);
}

// Measured, 20 layers: 0.2 % of the largest speed when steady and at the start; order 1.6, then 1.1. Seen to fail: with
// half of the wall term, and with x_j - x_i in place of the nearest image.
TEST(PoiseuilleFlow, StartsAndEndsAsItShould) {
  constexpr double nu = 0.1, g = 0.8;  // 1 m/s in the middle, Re = 10
  double before = 0;
  for (int n : {10, 20, 40}) {
    Fluid<2> fluid(poiseuille(n, nu, g));
    double starting = 0;
    bool sampled = false;
    run(fluid, 5.0, [&] {
      if (!sampled && seconds(fluid.state().time) > 0.5) starting = profile_error(fluid, nu, g), sampled = true;
    });
    const double steady = profile_error(fluid, nu, g);
    std::printf("Poiseuille, %d layers: error at 0.05 H^2/nu %.2e, steady %.2e of u_max", n, starting, steady);
    if (before > 0) std::printf(", order %.2f", std::log2(before / steady));
    std::printf("\n");
    before = steady;
    if (n < 20) continue;
    EXPECT_LT(steady, 0.01);
    EXPECT_LT(starting, 0.02);
  }
}

/// u(y, t) = U y - sum 2 U (-1)^(k+1)/(k pi) sin(k pi y) exp(-(k pi)^2 nu t): between a plate at rest and one that is set moving.
double starting_couette(double y, double t, double nu, double speed) {
  double u = speed * y;
  for (int k = 1; k < 60; ++k)
    u -= 2 * speed * (k % 2 == 0 ? -1 : 1) / (k * pi) * std::sin(k * pi * y) * std::exp(-std::pow(k * pi, 2) * nu * t);
  return u;
}

// The upper of two plates slides along the period; it goes twice round it. Measured: 0.03 % of its speed at t = 1 s, 0.02 % when steady.
// Seen to fail: with a plate that leaves its period.
TEST(CouetteFlow, IsDrivenByAWallThatSlidesAlongThePeriod) {
  constexpr double nu = 0.1, speed = 0.25;
  Case c = scene(2, 0.05, {box({0, 0, 0}, {0.5, 1, 0})}, {obstacle({0, -0.2, 0}, {0.5, 0, 0}), obstacle({0, 1, 0}, {0.5, 1.2, 0})}, 0);
  make_periodic(c, {0, -1, 0}, {0.5, 2, 0}, "x");
  c.fluid->viscosity = nu * density;
  c.end_time = 4;
  c.walls[1].motion.emplace().displacement[0] = Expression(fmt::format("{}*t", speed));
  c.walls[1].continues[0] = true;
  Fluid<2> fluid(c);
  const auto error = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < fluid.state().size(); ++i)
      sum += std::pow(fluid.state().velocity[i][0] - starting_couette(fluid.state().position[i][1], seconds(fluid.state().time), nu, speed),
                      2);
    return std::sqrt(sum / static_cast<double>(fluid.state().size())) / speed;
  };
  run(fluid, 1.0, [] {});
  const double starting = error();
  run(fluid, 4.0, [] {});
  std::printf("Couette, 20 layers: error at 0.1 H^2/nu %.2e, steady %.2e of the speed\n", starting, error());
  EXPECT_LT(starting, 0.02);
  EXPECT_LT(error(), 0.01);
}

struct Decay {
  double rate = 0;  ///< of ln |u|, from the kinetic energy at 0 and at the end [1/s]
  double loss = 0;  ///< of kinetic energy in the first unit of time
};

Decay taylor_green(int n, double reynolds, double until) {
  Case c = vortices(2, n);
  if (reynolds > 0) c.fluid->viscosity = density / reynolds;
  Fluid<2> fluid(c);
  const double start = fluid.energies().kinetic;
  double after_one = 0;
  run(fluid, until, [&] {
    if (seconds(fluid.state().time) <= 1) after_one = fluid.energies().kinetic;
  });
  return {-0.5 * std::log(fluid.energies().kinetic / start) / until, 1 - after_one / start};
}

// |u| = U exp(-8 pi^2 t/Re), at three spacings. Seen to fail: without shifting.
TEST(TaylorGreen, DecaysAtTheRateOfItsViscosity) {
  const double exact = 8 * pi * pi / 100;
  double before = 0;
  int coarser = 0;
  for (int n : {25, 36, 50}) {
    const double error = taylor_green(n, 100, 2.0).rate / exact - 1;
    std::printf("Taylor-Green, Re 100, %d^2: decay rate off by %+.2f %%", n, 100 * error);
    if (before != 0) std::printf(", order %.2f", std::log(std::abs(before / error)) / std::log(double(n) / coarser));
    std::printf("\n");
    before = error;
    coarser = n;
    if (n == 50) {
      EXPECT_LT(std::abs(error), 0.02);
    }
  }
}

// What the scheme dissipates by itself. Good codes lose less than 2 %; measured 1.47 %. Seen to fail: with free surfaces looked for in the
// full box; with shifting in proportion to the largest speed (13 %); with noise damping of resolved motion too (3.5 %), or at the
// rate of the largest speed (1.8 %).
TEST(TaylorGreen, WithoutViscosityLosesLittleEnergy) {
  const double loss = taylor_green(50, 0, 1.0).loss;
  std::printf("Taylor-Green, inviscid, 50^2: kinetic energy lost per unit of time %.2f %%\n", 100 * loss);
  EXPECT_LT(std::abs(loss), 0.015);
}

// Gravity towards a point, -10 x: p = rho 10 (R^2 - r^2)/2, and nothing moves.
TEST(DropUnderCentralGravity, StaysRound) {
  Shape disc;
  disc.kind = Shape::Kind::ball;
  disc.radius = 0.5;
  Case c = scene(2, 0.025, {disc}, {}, 0);
  c.gravity = {Expression("-10*x"), Expression("-10*y"), Expression()};
  Fluid<2> fluid(c);
  const auto second_moments = [&] {
    Matrix<2> m = Matrix<2>::Zero();
    for (const auto& x : fluid.state().position) m += x * x.transpose() / static_cast<double>(fluid.state().size());
    return m;
  };
  const double start = second_moments().trace();
  double pressure = 0;
  int samples = 0;
  run(fluid, 2.0, [&] {
    if (seconds(fluid.state().time) > 0.5) pressure += fluid.pressure_at(Vector<2>::Zero()).value(), ++samples;
  });
  const Matrix<2> m = second_moments();
  double farthest = 0, edge = 1e300;
  for (std::size_t i = 0; i < fluid.state().size(); ++i) {
    const double r = fluid.state().position[i].norm();
    farthest = std::max(farthest, r);
    if (!fluid.state().particle_class[i].interior()) edge = std::min(edge, r);
  }
  std::printf("drop: axes %.4f, %.4f, pressure %.4f of rho k R^2/2, radius %.4f to %.4f, kinetic energy %.2e\n", 2 * std::sqrt(m(0, 0)),
              2 * std::sqrt(m(1, 1)), pressure / samples / (density * 10 * 0.125), edge, farthest,
              fluid.energies().kinetic / (density * 10 * 0.25 * 0.25));
  EXPECT_NEAR(m(0, 0) / m(1, 1), 1, 0.02);
  EXPECT_NEAR(m(0, 1) / m(1, 1), 0, 0.01);
  EXPECT_NEAR(m.trace() / start, 1, 0.02);
  EXPECT_NEAR(pressure / samples, density * 10 * 0.125, 0.03 * density * 10 * 0.125);
  EXPECT_LT(farthest, 0.55);
  EXPECT_GT(edge, 0.42);
}

}  // namespace
}  // namespace tern::fluid::testing
