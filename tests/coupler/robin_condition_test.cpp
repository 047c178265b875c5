// What the fluid is told about how the surface yields, and the contact of single particles.

#include <gtest/gtest.h>

#include <random>

#include "coupler/schemes/scheme.hpp"
#include "fixtures/interface_scenes.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double dx = 0.01;

SurfaceProperties five_points() {
  SurfaceProperties p = properties(5);
  p.section_mass = {4.0, 4.0, 4.0, 0.5, 4.0};
  p.impedance = {1e6, 1e3, 1e2, 1e6, 2e3};  // times 1e-3 s / 2: 500, 0.5, 0.05, 500, 1 kg/m^2
  p.least_mass = {1.0, 0.2, 0.8, 1.0, 2.5};
  return p;
}

Surface<2> row(std::size_t n) {
  Surface<2> surface;
  for (std::size_t k = 0; k < n; ++k) add_point<2>(surface, {0.1 * static_cast<double>(k), 0.0}, {0.0, 1.0}, 0.5 * dx);
  return surface;
}

/// Mass per area with which every point answers a pressure, over the share of its half space that is filled; each point a lump of its own.
std::vector<double> robin_mass(const InterfaceCondition<2>& load, const Surface<2>& surface) {
  std::vector<double> mass;
  for (std::size_t k = 0; k < load.response.lump.size(); ++k)
    mass.push_back(load.response.mass[load.response.lump[k]] / (std::pow(load.response.share[k], 2) * surface.area[k]));
  return mass;
}

// Seen to fail: with the floor applied before the minimum; with the factor left out.
TEST(RobinMass, IsTheSectionOrHalfTheLayerAWaveReachesAndAtLeastAParticle) {
  for (double factor : {1.0, 0.5}) {
    Case c = scene(2, dx);
    c.coupling.max_iterations = 1;
    c.coupling.robin_mass_factor = factor;
    Coupler<2> coupler(c, five_points());
    const auto mass = robin_mass(coupler.first_exchange(0, 1e-3, row(5), {}), row(5));
    const std::vector<double> expected = {4.0, 0.5, 0.8, 1.0, 2.5};
    ASSERT_EQ(mass.size(), 5u);
    for (int k = 0; k < 5; ++k) EXPECT_DOUBLE_EQ(mass[k], factor * expected[k]) << k;
  }
}

// The section behind a point keeps its mass; a pressure on a face that has become twice as large finds half as much behind each area.
// Seen to fail: without the stretch.
TEST(RobinMass, IsLessWhereTheFaceHasBeenStretched) {
  Case c = scene(2, dx);
  c.coupling.max_iterations = 1;
  Coupler<2> coupler(c, five_points());
  auto surface = row(5);
  const auto before = robin_mass(coupler.first_exchange(0, 1e-3, surface, {}), surface);
  surface.area[3] *= 2;
  const auto after = robin_mass(coupler.first_exchange(1e-3, 1e-3, surface, {}), surface);
  for (int k = 0; k < 5; ++k) EXPECT_DOUBLE_EQ(after[k], before[k] / (k == 3 ? 2 : 1)) << k;
}

// Where the load itself has to agree, long windows show a body that is held by its stiffness, short ones its mass alone.
// Seen to fail: with the mass of what is held in windows of any length (50, 50, 50).
TEST(RobinMass, IsThatOfTheBodyAloneInShortWindowsAndHeldByStiffnessInLongOnes) {
  Case c = scene(2, dx);
  c.coupling.tolerance = tolerance_by_default;
  SurfaceProperties light = properties(5);
  const double density = c.structure->bodies[0].density, thickness = 0.02 * dx, sound = 100;
  light.section_mass.assign(5, 0.5 * density * thickness);
  light.least_mass = light.section_mass;
  light.impedance.assign(5, density * sound);
  const auto mass_in = [&](double window) {
    Coupler<2> coupler(c, light);
    return robin_mass(coupler.first_exchange(0, window, row(5), {}), row(5))[2];
  };
  const double wave_number = std::acos(-1.0) / dx, frequency = sound * std::pow(wave_number, 2) * thickness / std::sqrt(12.0);
  std::printf("[ Robin mass of %g kg/m^2 in windows of 0.02, 2 and 2000 over the shortest wave's frequency: %g, %g, %g ]\n",
              light.section_mass[0], mass_in(0.02 / frequency), mass_in(2 / frequency), mass_in(2000 / frequency));
  EXPECT_NEAR(mass_in(0.02 / frequency), light.section_mass[0], 2e-4 * light.section_mass[0]);
  EXPECT_NEAR(mass_in(2 / frequency), 2 * light.section_mass[0], 1e-9);
  EXPECT_NEAR(mass_in(2000 / frequency), 5 * 1000 * dx, 1e-9);
}

// Seen to fail: with the condition set for explicit coupling too.
TEST(RobinMass, IsNotGivenToAnExplicitCoupling) {
  Case c = scene(2, dx);
  c.coupling.algorithm = CouplingAlgorithm::explicit_staggering;
  Coupler<2> coupler(c, five_points());
  const auto load = coupler.first_exchange(0, 1e-3, row(5), {});
  EXPECT_TRUE(load.response.lump.empty() && load.response.mass.empty()) << "a surface without lumps does not yield";
  for (double pressure : load.reference_pressure) EXPECT_EQ(pressure, 0);
}

constexpr double mass_behind = 20;

/// Load of each point under a uniform pressure p, over p A.
std::vector<double> shares(const InterfaceParticles<2>& particles, const Surface<2>& surface,
                           InterfaceScheme scheme = InterfaceScheme::riemann) {
  InterfacePairs<2> pairs(1.5 * dx, dx);
  pairs.find(particles, surface);
  return uniform_load<2>(scheme_of<2>(scheme), pairs);
}

// Seen to fail: with the new dissipative part added instead of subtracted; with nothing carried.
TEST(RobinReferencePressure, IsWhatTheLastLoadCarriedLessTheNewDissipativePart) {
  Case c = scene(2, dx);
  c.coupling.riemann_limiter = 3;
  auto surface = flat_plate<2>(12 * dx, 4 * dx, 0.5 * dx);
  auto particles = fluid_layers<2>(12 * dx, 4, dx);
  Coupler<2> coupler(c, properties(surface.position.size(), mass_behind));
  for (double p : coupler.first_exchange(0, 1e-3, surface, particles).reference_pressure) EXPECT_EQ(p, 0) << "nothing carried yet";
  coupler.last_exchange(pressure_field<2>(particles, [](const Vector<2>&) { return 1000.0; }));
  const auto carried = coupler.surface_load();

  for (auto& u : particles.velocity) u = {0.0, -0.4};
  // In between the surface has moved and stretched.
  for (auto& n : surface.normal) n = Vector<2>(Vector<2>(0.1, n[1])).normalized();
  for (auto& a : surface.area) a *= 1.1;
  const auto load = coupler.first_exchange(1e-3, 1e-3, surface, particles);
  const auto& dissipative = coupler.surface_load();
  double largest = 0;
  const auto share = shares(particles, surface);
  for (std::size_t k = 0; k < surface.position.size(); ++k) {
    const double old_pressure = -carried.force[k].dot(surface.normal[k]) / surface.area[k];
    const double new_part = -dissipative.force[k].dot(surface.normal[k]) / surface.area[k];
    EXPECT_NEAR(load.reference_pressure[k] * share[k], old_pressure - new_part, 1e-9) << k;
    largest = std::max(largest, new_part);
  }
  EXPECT_GT(largest, 100) << "the dissipative part takes part in the test";
}

// Whatever the scheme, what the trial carries is the load of the last window.
// Seen to fail: with nothing carried.
TEST(RobinReferencePressure, IsTheLastLoadOfEveryScheme) {
  for (const auto& [scheme, key, meaning] : interface_schemes) {
    Case c = scene(2, dx);
    c.coupling.scheme = scheme;
    const auto surface = flat_plate<2>(12 * dx, 4 * dx, 0.5 * dx);
    const auto particles = fluid_layers<2>(12 * dx, 4, dx);
    Coupler<2> coupler(c, properties(surface.position.size(), mass_behind));
    coupler.first_exchange(0, 1e-3, surface, particles);
    coupler.last_exchange(pressure_field<2>(particles, [](const Vector<2>& x) { return 1000 - 2e4 * x[1]; }));
    const auto carried = coupler.surface_load();
    const auto load = coupler.first_exchange(1e-3, 1e-3, surface, particles);
    const auto share = shares(particles, surface, scheme);
    for (std::size_t k = 0; k < surface.position.size(); ++k)
      EXPECT_NEAR(load.reference_pressure[k] * share[k], carried.force[k].norm() / surface.area[k], 1e-9) << k;
  }
}

/// Water beside a wall x = 0 on a face that meets it and that ends, wet, at x = 0.2; particles up to 0.15 dx off their lattice.
void disordered_corner(Surface<2>& surface, InterfaceParticles<2>& particles) {
  for (int k = 0; k < 40; ++k) add_point<2>(surface, {(k + 0.5) * 0.5 * dx, 0.0}, {0.0, 1.0}, 0.5 * dx);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-0.15 * dx, 0.15 * dx);
  for (int i = 0; i < 16; ++i)
    for (int j = 0; j < (i < 10 ? 4 : 1); ++j) {
      const Vector<2> x((i + 0.5) * dx + off(random), (j + 0.5) * dx + off(random));
      add_particle<2>(particles, x, dx);
      if (i > 3) continue;
      particles.image_of.push_back(static_cast<std::uint32_t>(particles.id.size() - 1));
      particles.image_position.push_back({-x[0], x[1]});
    }
}

// Where both sides agree the body moves as its trial did, whatever the particles before it fill of its half spaces: less than half
// of them beyond x = 0.16, nothing beyond 0.2.
// Seen to fail: with the load over the area as reference; without the images in the share.
TEST(RobinReferencePressure, LeavesABodyAloneThatCarriesAUniformPressure) {
  for (const auto& [scheme, key, meaning] : interface_schemes) {
    SCOPED_TRACE("scheme " + std::to_string(static_cast<int>(scheme)));
    Surface<2> surface;
    InterfaceParticles<2> particles;
    disordered_corner(surface, particles);
    Case c = scene(2, dx);
    c.coupling.scheme = scheme;
    Coupler<2> coupler(c, properties(surface.position.size(), mass_behind));
    coupler.first_exchange(0, 1e-3, surface, particles);
    coupler.last_exchange(pressure_field<2>(particles, [](const Vector<2>&) { return 1000.0; }));
    const auto carried = coupler.surface_load();
    const auto load = coupler.first_exchange(1e-3, 1e-3, surface, particles);
    double least = 1, most = 0;
    const auto share = shares(particles, surface, scheme);
    InterfacePairs<2> pairs(1.5 * dx, dx);
    pairs.find(particles, surface);
    std::vector<double> fill(surface.position.size(), 0);
    for (const auto& pair : pairs.all_pairs()) fill[pair.point] -= pair.b.dot(surface.normal[pair.point]) / surface.area[pair.point];
    for (std::size_t k = 0; k < surface.position.size(); ++k) {
      if (carried.force[k].norm() < surface.area[k]) continue;  // at the end of the kernel, or dry
      const double filled = share[k];
      EXPECT_NEAR(load.reference_pressure[k], 1000, 1e-9) << k;
      least = std::min(least, filled);
      most = std::max(most, fill[k]);
    }
    EXPECT_LT(least, 0.5) << "a part of the face is partly wet";
    EXPECT_GT(most, 1.01) << "the disorder takes part in the test";
  }
}

// Where both sides agree, the pressures on a point exceed its reference by nothing, whatever the pressure and the particles: their force is
// that of the load. What was left would move it in every window.
// Seen to fail: with the load over the area as reference.
TEST(RobinReferencePressure, LeavesNothingWhereBothSidesAgree) {
  Surface<2> surface;
  InterfaceParticles<2> particles;
  disordered_corner(surface, particles);
  particles.image_of.clear();
  particles.image_position.clear();
  InterfacePairs<2> pairs(1.5 * dx, dx);
  pairs.find(particles, surface);
  std::mt19937 random(5);
  for (double differences : {0.0, 0.03, 0.3}) {
    std::uniform_real_distribution<double> uniform(1000 * (1 - differences), 1000 * (1 + differences));
    const auto pressure = pressure_field<2>(particles, [&](const Vector<2>&) { return uniform(random); });
    Coupler<2> coupler(scene(2, dx), properties(surface.position.size(), mass_behind));
    coupler.first_exchange(0, 1e-3, surface, particles);
    coupler.last_exchange(pressure);
    const auto carried = coupler.surface_load();
    const auto load = coupler.first_exchange(1e-3, 1e-3, surface, particles);
    std::vector<double> left(surface.position.size(), 0);
    for (const auto& pair : pairs.pairs())
      left[pair.point] -= pair.b.dot(surface.normal[pair.point]) * (pressure.pressure[pair.particle] - load.reference_pressure[pair.point]);
    for (std::size_t k = 0; k < left.size(); ++k)
      if (carried.force[k].norm() > 100 * surface.area[k]) {  // else all there is lies at the end of the kernel
        EXPECT_NEAR(left[k], 0, 1e-9 * carried.force[k].norm()) << "point " << k << ", differences " << differences;
      }
  }
}

/// One particle `height` above a wide face, moving at `velocity` after the pressure solve; returns its velocity after contact.
Vector<2> after_contact(double height, const Vector<2>& velocity, const Vector<2>& face_velocity, double pressure = 0,
                        WindowAudit* audit = nullptr, double section_mass = 1e16) {
  auto surface = flat_plate<2>(12 * dx, 4 * dx, 0.5 * dx);
  for (auto& u : surface.velocity) u = face_velocity;
  InterfaceParticles<2> particles;
  add_particle<2>(particles, {0.0025, height}, dx, velocity);
  Case c = scene(2, dx);
  c.coupling.algorithm = CouplingAlgorithm::explicit_staggering;
  Coupler<2> coupler(c, properties(surface.position.size(), section_mass));
  coupler.first_exchange(0, 1e-3, surface, particles);
  const auto force = coupler.last_exchange(pressure_field<2>(particles, [&](const Vector<2>&) { return pressure; }));
  if (audit) *audit = coupler.audit();
  return velocity + 1e-3 / particles.mass[0] * force.force[0];
}

// Seen to fail: with the approach not measured relative to the face; with the impulse of the pressure left out of it; with
// contacts of those only that are nearer than the contact distance.
TEST(Contact, TakesTheApproachOfAParticleAtTheFaceAndNothingElse) {
  WindowAudit audit;
  const Vector<2> stopped = after_contact(0.2 * dx, {0.7, -1.5}, {0.0, -0.5}, 0, &audit);
  EXPECT_NEAR(stopped[0], 0.7, 1e-14);
  EXPECT_NEAR(stopped[1], -0.5, 1e-14);
  EXPECT_NEAR(audit.contact_dissipation, 0.5 * 1000 * dx * dx * 1.0, 1e-12);
  // Pressure has taken a part of the approach before.
  EXPECT_NEAR(after_contact(0.2 * dx, {0.7, -1.5}, {0.0, -0.5}, 2000, &audit)[1], -0.5, 1e-14);
  EXPECT_LT(audit.contact_dissipation, 0.49 * 1000 * dx * dx);
  EXPECT_EQ(after_contact(0.3 * dx, {0.7, -0.9}, {0.0, -0.5}), Vector<2>(0.7, -0.9)) << "stays beyond the contact distance";
  // Comes to the contact distance in this window, and no nearer: 0.05 dx in 1 ms are left of its approach.
  EXPECT_NEAR(after_contact(0.3 * dx, {0.7, -1.5}, {0.0, -0.5}, 0, &audit)[1], -0.5 - 0.05 * dx / 1e-3, 1e-13);
  EXPECT_NEAR(audit.contact_dissipation, 0.5 * 1000 * dx * dx * (1 - 0.25), 1e-12);
  EXPECT_EQ(after_contact(0.2 * dx, {0.7, -0.4}, {0.0, -0.5}), Vector<2>(0.7, -0.4)) << "on its way off";
}

// Particle and face go on together: m_f u + m_s v is kept, m_s the mass behind dx of the face.
// Seen to fail: with the whole approach of the particle taken, as by a wall.
TEST(Contact, LeavesAParticleAndALightFaceTheirCommonVelocity) {
  constexpr double behind = 5 * dx, mass = 1000 * dx * dx;
  WindowAudit audit;
  const double after = after_contact(0.2 * dx, {0.0, -1.5}, {0.0, -0.5}, 0, &audit, 5)[1];
  EXPECT_NEAR(after, (mass * -1.5 + behind * -0.5) / (mass + behind), 1e-14);
  EXPECT_NEAR(audit.contact_dissipation, 0.5 * mass * behind / (mass + behind), 1e-12);
}

// What a light face does under a contact, the coupling iterations find out. Held by its stiffness it does not give way, though no mass
// is behind it: with that mass alone the particle goes on at 0.995 of its approach, and through. Free, with the mass of the
// patch, it goes on with the particle, at the velocity that keeps the momentum of both.
// Seen to fail: with the mass behind the face as in the explicit coupling; with no contacts in the answers; with the excess subtracted.
TEST(Contact, OfALightFaceIsAsHeldOrAsFreeAsTheTrialsShow) {
  constexpr double window = 1e-3, behind = 0.05, mass = 1000 * dx * dx, area = 0.5 * dx;
  for (const bool held : {true, false}) {
    Case c = scene(2, dx);
    c.coupling.tolerance = tolerance_by_default;
    c.coupling.tolerance = 1e-9;
    auto surface = flat_plate<2>(12 * dx, 4 * dx, area);
    for (auto& u : surface.velocity) u = {0.0, -0.5};
    InterfaceParticles<2> particles;
    add_particle<2>(particles, {0.0025, 0.2 * dx}, dx, {0.0, -1.5});
    const InterfacePressure<2> pressure = pressure_field<2>(particles, [](const Vector<2>&) { return 0.0; });
    Coupler<2> coupler(c, properties(surface.position.size(), behind));
    coupler.first_exchange(0, window, surface, particles);
    std::vector<Vector<2>> velocity = surface.velocity;
    while (const SurfaceLoad<2>* trial = coupler.next_load(pressure)) {
      for (std::size_t k = 0; !held && k < velocity.size(); ++k)
        velocity[k] = surface.velocity[k] + window / (behind * area) * trial->force[k];
      coupler.repeat_exchange(velocity);
    }
    EXPECT_TRUE(coupler.state().fixed_point.converged());
    const double after = -1.5 + window / mass * coupler.last_exchange(pressure).force[0][1];
    const double shared = held ? -0.5 : (mass * -1.5 + behind * area * -0.5) / (mass + behind * area);
    EXPECT_NEAR(after, shared, 1e-6) << (held ? "held" : "free") << " after " << coupler.state().fixed_point.iterations() << " trials";
    EXPECT_NEAR(coupler.audit().contact_dissipation, 0.5 * mass * (after + 1.5) * (shared + 1.5), 1e-6);
  }
}

// A face that springs away from every push, and stays without one, comes to no agreement with a particle: it is pushed by some part of
// what would stop the particle, once, and the particle by as much. The window counts as one that was left open.
// Seen to fail: with contacts never given (no agreement); with the answer of contacts that are given settled anew.
TEST(Contact, ThatComesToNoAgreementIsGivenToBothSides) {
  constexpr double window = 1e-3, mass = 1000 * dx * dx;
  Case c = scene(2, dx);
  c.coupling.tolerance = tolerance_by_default;
  auto surface = flat_plate<2>(12 * dx, 4 * dx, 0.5 * dx);
  for (auto& u : surface.velocity) u = {0.0, -0.5};
  InterfaceParticles<2> particles;
  add_particle<2>(particles, {0.0025, 0.2 * dx}, dx, {0.0, -1.5});
  const InterfacePressure<2> pressure = pressure_field<2>(particles, [](const Vector<2>&) { return 0.0; });
  Coupler<2> coupler(c, properties(surface.position.size(), 0.05));
  coupler.first_exchange(0, window, surface, particles);
  std::vector<Vector<2>> velocity = surface.velocity;
  Vector<2> assumed = Vector<2>::Zero();
  while (const SurfaceLoad<2>* trial = coupler.next_load(pressure)) {
    assumed.setZero();
    for (std::size_t k = 0; k < velocity.size(); ++k) {
      velocity[k] = trial->force[k].isZero(0) ? surface.velocity[k] : Vector<2>(0.0, -100.0);
      assumed += trial->force[k];
    }
    coupler.repeat_exchange(velocity);
  }
  const FixedPoint& iteration = coupler.state().fixed_point;
  EXPECT_TRUE(iteration.gives_contacts() && iteration.converged());
  const Vector<2> on_particle = coupler.last_exchange(pressure).force[0];
  std::printf("[ %d iterations, %g of the push that stops the particle ]\n", iteration.iterations(), on_particle[1] * window / mass);
  EXPECT_EQ(on_particle, -assumed);
  EXPECT_NEAR((coupler.total_load(0) + on_particle).norm(), 0, 1e-12 * on_particle.norm());
  EXPECT_GT(on_particle[1], 0);
  EXPECT_LE(on_particle[1] * window / mass, 1);
  EXPECT_EQ(coupler.state().totals.open_windows, 1);
}

// Seen to fail: with the points of all bodies summed.
TEST(TotalLoad, IsTheSumOverTheBodyAsked) {
  auto surface = flat_plate<2>(12 * dx, 4 * dx, 0.5 * dx);
  const auto particles = fluid_layers<2>(12 * dx, 4, dx);
  SurfaceProperties p = properties(surface.position.size());
  Vector<2> expected[2] = {Vector<2>::Zero(), Vector<2>::Zero()};
  for (std::size_t k = 0; k < p.body.size(); ++k) p.body[k] = surface.position[k][0] > 0.03 ? 1 : 0;
  Case c = scene(2, dx);
  c.structure->bodies.push_back(c.structure->bodies[0]);
  Coupler<2> coupler(c, p);
  coupler.first_exchange(0, 1e-3, surface, particles);
  coupler.last_exchange(pressure_field<2>(particles, [](const Vector<2>& x) { return 1000 + 1e4 * x[0]; }));
  for (std::size_t k = 0; k < p.body.size(); ++k) expected[p.body[k]] += coupler.surface_load().force[k];
  EXPECT_EQ(coupler.total_load(0), expected[0]);
  EXPECT_EQ(coupler.total_load(1), expected[1]);
  EXPECT_NE(expected[0], expected[1]);
}

TEST(Coupler, NamesTheSurfacePointWhoseLoadIsNotFinite) {
  auto surface = flat_plate<2>(12 * dx, 4 * dx, 0.5 * dx);
  const auto particles = fluid_layers<2>(12 * dx, 4, dx);
  Coupler<2> coupler(scene(2, dx), properties(surface.position.size()));
  coupler.first_exchange(0.25, 1e-3, surface, particles);
  try {
    coupler.last_exchange(pressure_field<2>(particles, [](const Vector<2>&) { return std::nan(""); }));
    FAIL() << "accepted a pressure that is not a number";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("t = 0.25 s"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace tern::coupler::testing
