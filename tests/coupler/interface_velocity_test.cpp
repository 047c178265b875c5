// One mode of a structure, of mass 1 and frequency omega, moves a fluid of mass M. Over a window the load p is constant, the
// structure moves exactly, and the fluid has to follow the velocity that interface_velocity() makes of its motion.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>
#include <functional>

#include "structure/coupled_structure.hpp"

namespace tern::structure {
namespace {

using Given = InterfaceVelocity<double>;

/// What the fluid is given after a window: how far the structure has moved in it, its velocity at the end, what was given before.
using Rule = std::function<Given(double moved, double at_end, const Given& before)>;

Given by_mean(double moved, double, const Given& before) { return before.after(moved); }
Given by_end(double, double at_end, const Given&) { return {at_end, 0}; }

/// State after a window of length 1: displacement, velocity, velocity of the fluid, rate; y = omega dt.
Eigen::Vector4d after_window(double y, double fluid_mass, const Rule& rule, const Eigen::Vector4d& q) {
  const double c = std::cos(y), s = std::sin(y);
  // After the window under a constant load.
  const auto displacement = [&](double load) { return c * q[0] + s / y * q[1] + (1 - c) / (y * y) * load; };
  const auto velocity = [&](double load) { return -y * s * q[0] + c * q[1] + s / y * load; };
  const auto given = [&](double load) { return rule(displacement(load) - q[0], velocity(load), {q[2], q[3]}); };
  // The fluid takes w' = w - load/M, and w' is the velocity given: linear in the load.
  const double without = given(0).at_end, mobility = given(1).at_end - without;
  const double load = (q[2] - without) / (mobility + 1 / fluid_mass);
  return {displacement(load), velocity(load), q[2] - load / fluid_mass, given(load).rate};
}

/// Largest factor by which a state grows in a window.
double growth(double y, double fluid_mass, const Rule& rule) {
  Eigen::Matrix4d map;
  for (int column = 0; column < 4; ++column) map.col(column) = after_window(y, fluid_mass, rule, Eigen::Vector4d::Unit(column));
  return map.eigenvalues().cwiseAbs().maxCoeff();
}

double largest_growth(const Rule& rule) {
  double largest = 0;
  for (double fluid_mass : {0.1, 1.0, 10.0, 100.0, 1e4})
    for (double y = 0.01; y < 50; y *= 1.02) largest = std::max(largest, growth(y, fluid_mass, rule));
  return largest;
}

// Seen to fail: with 1.9 for 1.68.
TEST(InterfaceVelocity, NeverLetsAModeGrowWhateverItsStiffnessAndMass) { EXPECT_LE(largest_growth(by_mean), 1 + 1e-6); }

// Why not simply the velocity of the structure at the end of the window.
TEST(InterfaceVelocity, AtTheEndOfAWindowTheStructureMayMoveAgainstTheLoad) { EXPECT_GT(largest_growth(by_end), 10); }

// Seen to fail: with 1.2 for the factor of the mean in `rate`.
TEST(InterfaceVelocity, OfSteadyAccelerationIsExact) {
  Given given{0, 0};
  for (int n = 0; n < 50; ++n) given = given.after(n + 0.5);  // true velocity n + 1 at the end
  EXPECT_NEAR(given.at_end, 50, 1e-12);
}

// Frequency and amplitude after one period of the coupled motion. Seen to fail: with 0.8 of the velocity before kept (loss 8.7e-3).
TEST(InterfaceVelocity, CostsAModeNoAmplitudeAndLittleFrequency) {
  for (double fluid_mass : {1.0, 100.0}) {
    double loss[2], frequency[2];
    for (int fine : {0, 1}) {
      const double phi = fine ? 0.05 : 0.1, y = phi * std::sqrt(1 + fluid_mass);
      Eigen::Matrix4d map;
      for (int column = 0; column < 4; ++column) map.col(column) = after_window(y, fluid_mass, by_mean, Eigen::Vector4d::Unit(column));
      std::complex<double> mode = 0;
      for (const std::complex<double> root : map.eigenvalues())
        if (root.imag() > 0 && std::abs(root) > std::abs(mode)) mode = root;
      loss[fine] = 1 - std::pow(std::abs(mode), 2 * M_PI / std::arg(mode));
      frequency[fine] = std::arg(mode) / phi - 1;
    }
    std::printf("[ M %g: loss per period %.2g, %.2g; frequency %.2g, %.2g ]\n", fluid_mass, loss[0], loss[1], frequency[0], frequency[1]);
    EXPECT_LT(loss[0], 3e-4);
    EXPECT_NEAR(std::log2(loss[0] / loss[1]), 3, 0.2) << "order";
    EXPECT_LT(std::abs(frequency[0]), 1e-3);
    EXPECT_NEAR(std::log2(frequency[0] / frequency[1]), 2, 0.2) << "order";
  }
}

// A blow leaves an alternation that dies out. Seen to fail: with 0.8 of the velocity before kept.
TEST(InterfaceVelocity, ForgetsABlow) {
  Given given{1, 0};
  for (int n = 0; n < 5; ++n) given = given.after(0);
  EXPECT_LT(std::abs(given.at_end), 1e-3);
}

}  // namespace
}  // namespace tern::structure
