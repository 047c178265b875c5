// What the fluid between a face that is accelerated and the particles before it does to the load and to the Robin condition.

#include <gtest/gtest.h>

#include <random>

#include "fixtures/interface_scenes.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double dx = 0.01, rho = 1000, g = 9.81, acceleration = 50, window = 1e-3, at_face = 2000;

/// Water over a face that is accelerated upwards, in the second window; it and its fluid have the pressure and the load that belong to it.
struct Accelerated {
  Surface<2> surface = flat_plate<2>(12 * dx, 4 * dx, 0.5 * dx);
  InterfaceParticles<2> particles = fluid_layers<2>(12 * dx, 4, dx);
  InterfacePressure<2> pressure;
  Coupler<2> coupler;

  Accelerated(InterfaceScheme scheme, double mass, double disorder, Coupling coupling = Coupling::one_pass)
      : coupler(make(scheme, coupling), properties(surface.position.size(), mass)) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> off(-disorder * dx, disorder * dx);
    for (auto& x : particles.position) x += Vector<2>(off(random), off(random));
    pressure = pressure_field<2>(particles, [](const Vector<2>& x) { return at_face - rho * (g + acceleration) * x[1]; });
    coupler.first_exchange(0, window, surface, particles);
    coupler.last_exchange(pressure);
    for (std::size_t k = 0; k < surface.position.size(); ++k) surface.velocity[k] = {0.0, acceleration * window};
  }

  static Case make(InterfaceScheme scheme, Coupling coupling) {
    Case c = scene(2, dx);
    c.gravity = constant(0, -g);
    c.coupling.scheme = scheme;
    choose(coupling, c.coupling);
    return c;
  }
};

// With the weight alone, the face would get the pressure at the mean distance of the particles, 0.656 dx off: 328 Pa less.
// Seen to fail: without carry_by_inertia(); with twice the distance in it.
TEST(FluidBetween, LoadsAFaceThatIsAcceleratedWithThePressureThere) {
  for (const auto& [scheme, name, meaning] : interface_schemes) {
    Accelerated a(scheme, heavy, 0);
    a.coupler.first_exchange(window, window, a.surface, a.particles);
    a.coupler.last_exchange(a.pressure);
    EXPECT_LT(a.coupler.audit().force_error, 1e-13);
    // pi takes the pressure where the particles are, as published.
    const double expected = scheme == InterfaceScheme::pi ? at_face - 0.656 * rho * acceleration * dx : at_face;
    EXPECT_NEAR(-mean_traction<2>(a.surface, a.coupler.surface_load(), 6 * dx, 1)[1], expected, 2) << name;
  }
}

// A body that goes on being accelerated under the load of the last window, and fluid that answers with that load: its pressure exceeds
// what the trial carries by nothing. What was left would be taken for a motion of the body.
// Seen to fail: without between.carried in the reference pressure.
TEST(FluidBetween, IsNoReasonToYieldWhereBothSidesAgree) {
  for (const double disorder : {0.0, 0.1}) {
    Accelerated a(InterfaceScheme::riemann, heavy, disorder);
    a.coupler.first_exchange(window, window, a.surface, a.particles);
    a.coupler.last_exchange(a.pressure);
    const SurfaceLoad<2> load = a.coupler.surface_load();
    for (auto& u : a.surface.velocity) u[1] += acceleration * window;
    const InterfaceCondition<2> condition = a.coupler.first_exchange(2 * window, window, a.surface, a.particles);
    InterfacePairs<2> pairs(1.5 * dx, dx);
    pairs.find(a.particles, a.surface);
    std::vector<double> left(a.surface.position.size(), 0);
    for (const auto& pair : pairs.pairs()) {
      const double carried = a.pressure.pressure[pair.particle] + rho * g * pair.offset[1];
      left[pair.point] -= pair.b.dot(a.surface.normal[pair.point]) * (carried - condition.reference_pressure[pair.point]);
    }
    for (std::size_t k = 0; k < left.size(); ++k)
      if (std::abs(a.surface.position[k][0]) < 6 * dx && a.surface.normal[k][1] > 0) {
        EXPECT_NEAR(left[k] / load.force[k].norm(), 0, 1e-6) << "point " << k << ", disorder " << disorder;
      }
  }
}

// Between a light body and the particles there is no more than half of its mass: 0.2 layers of fluid of 0.656.
// Seen to fail: without lighten().
TEST(FluidBetween, IsNoMoreThanHalfOfTheMassOfALightBody) {
  Accelerated a(InterfaceScheme::riemann, 0.4 * rho * dx, 0, Coupling::explicit_staggering);
  a.coupler.first_exchange(window, window, a.surface, a.particles);
  a.coupler.last_exchange(a.pressure);
  EXPECT_NEAR(-mean_traction<2>(a.surface, a.coupler.surface_load(), 6 * dx, 1)[1], at_face - (0.656 - 0.2) * rho * acceleration * dx, 2);
}

}  // namespace
}  // namespace tern::coupler::testing
