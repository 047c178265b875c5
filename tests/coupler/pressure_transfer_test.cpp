// A uniform or hydrostatic pressure on a flat face must arrive on it as F/A = -p n, however thin the body is.

#include <gtest/gtest.h>

#include "fixtures/interface_scenes.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double dx = 0.01;

/// F/A on the upper face in units of p, for a plate `thickness` particles thick with fluid on one side or on both.
template <int D>
double transferred(double smoothing_length_ratio, double points_per_dx, double thickness, double pressure_below) {
  const double half = (D == 2 ? 12 : 8) * dx, inner = (D == 2 ? 6 : 4) * dx;
  const auto surface = flat_plate<D>(half, thickness * dx, dx / points_per_dx);
  const auto particles = fluid_layers<D>(half, 4, dx, pressure_below > 0, thickness * dx);
  Coupler<D> coupler(scene(D, dx, smoothing_length_ratio), properties(surface.position.size()));
  coupler.first_exchange(0, 1e-3, surface, particles);
  coupler.last_exchange(pressure_field<D>(particles, [&](const Vector<D>& x) { return x[1] > 0 ? 1000.0 : pressure_below; }));
  const Vector<D> traction = mean_traction<D>(surface, coupler.surface_load(), inner, 1);
  EXPECT_NEAR(traction[0], 0, 1e-9) << "no shear";
  if (pressure_below > 0) {
    const Vector<D> lower = mean_traction<D>(surface, coupler.surface_load(), inner, -1);
    EXPECT_NEAR(lower[1] / pressure_below, -traction[1] / 1000, 1e-12) << "both faces alike";
  }
  return -traction[1] / 1000;
}

// The face kernel is calibrated on the layers it reaches; points of dx/2 integrate it to a few 1e-5. Points as coarse
// as the fluid add the error of a sum for an integral: 1 % at h/dx 1.3 and 0.5 % at 1.5 when they stand under the particles.
// Seen to fail: without the calibration of FaceKernel::surface_weight(); without the factor 2 of b_ik.
TEST(PressureTransfer, OfAUniformPressureIsMinusPTimesTheArea) {
  EXPECT_NEAR(transferred<2>(1.3, 1, 4, 0), 1, 1.2e-2);
  EXPECT_NEAR(transferred<2>(1.5, 1, 4, 0), 1, 6e-3);
  for (double points_per_dx : {2.0, 4.0}) {
    EXPECT_NEAR(transferred<2>(1.3, points_per_dx, 4, 0), 1, 2e-4) << points_per_dx << " points per dx";
    EXPECT_NEAR(transferred<2>(1.5, points_per_dx, 4, 0), 1, 1e-4) << points_per_dx << " points per dx";
  }
  EXPECT_NEAR(transferred<3>(1.5, 2, 4, 0), 1, 1e-4);
}

// Seen to fail: with the pressure force put on another point than the pair's.
TEST(PressureTransfer, DoesNotDependOnTheThicknessOfThePlate) {
  for (double ratio : {1.3, 1.5}) {
    const double thick = transferred<2>(ratio, 2, 4, 0);
    for (double layers : {1.0, 2.0, 4.0}) {
      EXPECT_NEAR(transferred<2>(ratio, 2, layers, 0), thick, 1e-12) << layers << " dx, dry behind";
      EXPECT_NEAR(transferred<2>(ratio, 2, layers, 400), thick, 1e-12) << layers << " dx, wet on both faces";
    }
  }
  EXPECT_NEAR(transferred<3>(1.5, 2, 1, 400), transferred<3>(1.5, 2, 4, 0), 1e-12);
}

// Seen to fail: with the weight subtracted instead of added, and left out.
TEST(PressureTransfer, CarriesThePressureOfParticlesToTheFaceByTheWeightBetween) {
  constexpr double depth = 0.2, g = 9.81;
  Case c = scene(2, dx);
  c.gravity = constant(0, -g);
  const auto surface = flat_plate<2>(12 * dx, 4 * dx, 0.5 * dx);
  const auto particles = fluid_layers<2>(12 * dx, 4, dx);
  Coupler<2> coupler(c, properties(surface.position.size()));
  coupler.first_exchange(0, 1e-3, surface, particles);
  coupler.last_exchange(pressure_field<2>(particles, [&](const Vector<2>& x) { return 1000 * g * (depth - x[1]); }));
  const double traction = mean_traction<2>(surface, coupler.surface_load(), 6 * dx, 1)[1];
  EXPECT_NEAR(-traction / (1000 * g * depth), transferred<2>(1.5, 2, 4, 0), 1e-9);
}

// Seen to fail: with the pressure force put on another point than the pair's.
TEST(PressureTransfer, PutsNoForceOnAFaceThatTurnsAwayFromTheFluid) {
  const auto surface = flat_plate<2>(12 * dx, dx, 0.5 * dx);
  const auto particles = fluid_layers<2>(12 * dx, 4, dx);
  Coupler<2> coupler(scene(2, dx), properties(surface.position.size()));
  coupler.first_exchange(0, 1e-3, surface, particles);
  coupler.last_exchange(pressure_field<2>(particles, [](const Vector<2>&) { return 1000.0; }));
  for (std::size_t k = 0; k < surface.position.size(); ++k)
    if (surface.normal[k][1] < 0) {
      EXPECT_EQ(coupler.surface_load().force[k].norm(), 0) << k;
    }
}

}  // namespace
}  // namespace tern::coupler::testing
