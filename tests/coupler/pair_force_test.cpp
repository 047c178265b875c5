// What must hold for any state: forces on both sides cancel, and the powers are those of the pairs.

#include <gtest/gtest.h>
#include <omp.h>

#include "coupler/schemes/riemann.hpp"
#include "coupler/schemes/velocity_divergence_mitigation.hpp"
#include "fixtures/interface_scenes.hpp"
#include "sph/contact.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double dx = 0.01, duration = 2e-4;

template <int D>
struct RandomInterface {
  Surface<D> surface;
  InterfaceParticles<D> particles;
  InterfacePressure<D> pressure;
};

/// A bent plate two particles thick in a cloud of fluid particles, everything else at random; pressures positive.
template <int D>
RandomInterface<D> random_interface(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto random_vector = [&](double size) {
    Vector<D> v;
    for (int c = 0; c < D; ++c) v[c] = size * normal(random);
    return v;
  };
  RandomInterface<D> r;
  const double half = (D == 2 ? 10 : 4) * dx;
  const auto bend = [&](const Vector<D>& x) { return 0.02 * std::sin(20 * x[0]); };
  for (double side : {1.0, -1.0})
    for_lattice_plane<D>(half, 0, dx, [&](Vector<D> x) {
      x[1] = bend(x) + side * dx;
      Vector<D> n = Vector<D>::Unit(1);
      n[0] = -0.4 * std::cos(20 * x[0]);
      add_point<D>(r.surface, x, side * n.normalized(), std::pow(dx, D - 1) * (0.8 + 0.4 * uniform(random)), random_vector(1));
    });
  for (double side : {1.0, -1.0})
    for (int layer = 0; layer < 4; ++layer)
      for_lattice_plane<D>(half, 0, dx, [&](Vector<D> x) {
        // From just above the face on, so that some touch it.
        x[1] = bend(x) + side * (1.05 + 0.95 * layer + 0.3 * uniform(random)) * dx;
        x[0] += 0.3 * dx * normal(random);
        add_particle<D>(r.particles, x, dx, random_vector(1));
        r.particles.divergence.back() = 20 * normal(random);
      });
  for (std::size_t i = 0; i < r.particles.id.size(); ++i) {
    r.pressure.pressure.push_back(5000 * uniform(random) + 3000);  // more than gravity takes off towards the face
    r.pressure.velocity.push_back(r.particles.velocity[i] + random_vector(0.3));
  }
  return r;
}

template <int D>
Case everything_on() {
  Case c = scene(D, dx);
  c.gravity = constant(3, -9.81);
  c.coupling.riemann_limiter = 3;
  c.coupling.vem_coefficient = 1.0;
  return c;
}

template <int D>
Eigen::Vector3d moment(const Vector<D>& x, const Vector<D>& f) {
  Eigen::Vector3d x3 = Eigen::Vector3d::Zero(), f3 = x3;
  x3.head<D>() = x;
  f3.head<D>() = f;
  return x3.cross(f3);
}

template <int D>
void check_balance(unsigned seed, InterfaceScheme scheme) {
  SCOPED_TRACE("seed " + std::to_string(seed) + ", scheme " + std::to_string(static_cast<int>(scheme)));
  const auto r = random_interface<D>(seed);
  Case c = everything_on<D>();
  c.coupling.scheme = scheme;
  Coupler<D> coupler(c, properties(r.surface.position.size()));
  const auto first = coupler.first_exchange(0, duration, r.surface, r.particles);
  const auto second = coupler.last_exchange(r.pressure);
  ASSERT_GT(coupler.audit().contacts, 0);
  if (scheme == InterfaceScheme::riemann) {
    ASSERT_GT(coupler.audit().riemann_dissipation, 0);
  } else {
    ASSERT_EQ(coupler.audit().riemann_dissipation, 0) << "a term of scheme riemann alone";
  }
  ASSERT_NE(coupler.audit().mitigation_dissipation, 0);

  Vector<D> force = Vector<D>::Zero();
  Eigen::Vector3d turning = Eigen::Vector3d::Zero();
  double size = 0, on_surface = 0, work = 0;
  for (std::size_t i = 0; i < r.particles.id.size(); ++i) {
    const Vector<D> f = first.force[i] + second.force[i];
    force += f;
    turning += moment<D>(r.particles.position[i], f);
    size += f.norm();
  }
  // All pressures are positive, so all pair forces of a point push the same way and |sum| = sum ||. The moment of a pair
  // is its force times the offset of its ends along the face.
  InterfacePairs<D> pairs(1.5 * dx, dx);
  pairs.find(r.particles, r.surface);
  std::vector<double> offset(r.surface.position.size(), 0);
  for (const auto& pair : pairs.pairs()) {
    const Vector<D> d = r.surface.position[pair.point] - r.particles.position[pair.particle];
    const Vector<D>& n = r.surface.normal[pair.point];
    offset[pair.point] = std::max(offset[pair.point], (d - d.dot(n) * n).norm());
  }
  double bound = 0;
  for (std::size_t k = 0; k < r.surface.position.size(); ++k) {
    const Vector<D>& f = coupler.surface_load().force[k];
    // The corrected gradient may find any pressure at a face from pressures at random.
    if (scheme != InterfaceScheme::fsa) {
      EXPECT_LE(f.dot(r.surface.normal[k]), 0) << "pushes into the body at point " << k;
    }
    EXPECT_NEAR((f - f.dot(r.surface.normal[k]) * r.surface.normal[k]).norm(), 0, 1e-12 * f.norm());
    force += f;
    turning += moment<D>(r.surface.position[k], f);
    on_surface += f.norm();
    work -= duration * f.dot(r.surface.velocity[k]);
    bound += f.norm() * offset[k];
  }
  EXPECT_LT(force.norm() / (size + on_surface), 1e-13);
  EXPECT_LT(coupler.audit().force_error, 1e-13);
  if (scheme != InterfaceScheme::fsa) {
    EXPECT_LT(turning.norm(), bound);
  }
  EXPECT_NEAR(coupler.audit().work_on_fluid, work, 1e-12 * std::abs(work));
  std::printf("[ %dD seed %u: force %.1e, moment %.1e h sum|f| (bound %.2f), %d contacts, %d pairs ]\n", D, seed,
              force.norm() / (size + on_surface), turning.norm() / (1.5 * dx * on_surface), bound / (1.5 * dx * on_surface),
              coupler.audit().contacts, coupler.audit().pairs);
}

// Seen to fail: with 1 - 1e-9 of the force on one side; with the force put on another point than the pair's; with a Riemann
// pressure that pulls when the sides part.
TEST(PairForces, CancelInAnyState) {
  for (const auto& [scheme, key, meaning] : interface_schemes)
    for (unsigned seed : {1u, 2u, 3u}) {
      check_balance<2>(seed, scheme);
      check_balance<3>(seed, scheme);
    }
}

// Contacts are looked for among the pairs whose particle stands over the patch of its point.
// Seen to fail: with the height left out of the distance beside the patch, and with the numbers of the pairs counted from those of the
// particle.
TEST(Pairs, StandOverTheirPatchesByTheDefinition) {
  std::mt19937 random(5);
  std::normal_distribution<double> any;
  Surface<3> surface = flat_plate<3>(12 * dx, 2 * dx, 0.6 * dx);
  for (auto& n : surface.normal) n = (n + 0.2 * Vector<3>(any(random), any(random), any(random))).normalized();
  InterfaceParticles<3> particles = fluid_layers<3>(12 * dx, 3, dx, true, 2 * dx);
  for (auto& x : particles.position) x += 0.1 * dx * Vector<3>(any(random), any(random), any(random));
  InterfacePairs<3> pairs(1.5 * dx, dx);
  pairs.find(particles, surface);
  std::vector<std::pair<int, int>> expected, standing;
  for (const auto& pair : pairs.pairs())
    if (stands_over<3>(surface.position[pair.point], surface.normal[pair.point], surface.area[pair.point],
                       particles.position[pair.particle]))
      expected.push_back({pair.particle, pair.point});
  pairs.for_each_standing({}, [&](const InterfacePair<3>& pair) { standing.push_back({pair.particle, pair.point}); });
  EXPECT_EQ(standing, expected);
  EXPECT_GT(expected.size(), 100u);
  EXPECT_LT(expected.size(), pairs.pairs().size() / 4);
}

// Contacts are settled from the first one on, which all threads look for, each in its parts of the particles.
// Seen to fail: with the first part that has one, but its first pair; and with the parts counted from the last one.
TEST(Pairs, FindTheFirstOneThatStandsAndHolds) {
  const Surface<3> surface = flat_plate<3>(12 * dx, 2 * dx, 0.6 * dx);
  InterfacePairs<3> pairs(1.5 * dx, dx);
  pairs.find(fluid_layers<3>(12 * dx, 3, dx, true, 2 * dx), surface);
  ASSERT_GT(pairs.parts(), 3);
  std::vector<std::pair<int, int>> all;
  pairs.for_each_standing({}, [&](const InterfacePair<3>& pair) { all.push_back({pair.particle, pair.point}); });
  const auto from = [&](auto&& holds) {
    std::vector<std::pair<int, int>> found;
    pairs.for_each_standing(pairs.first_standing(holds), [&](const InterfacePair<3>& pair) {
      found.push_back({pair.particle, pair.point});
    });
    return found;
  };
  for (const std::size_t m : {std::size_t{0}, all.size() / 3, all.size() / 2, all.size() - 1}) {
    const auto holds = [&](const InterfacePair<3>& pair) { return pair.particle >= all[m].first && pair.point == all[m].second; };
    EXPECT_EQ(from(holds), decltype(all)(all.begin() + static_cast<std::ptrdiff_t>(m), all.end()));
  }
  EXPECT_TRUE(from([](const InterfacePair<3>&) { return false; }).empty());
}

// The particles are shared out among threads; pairs past corners come behind all others. Points sum over them in parts.
// Seen to fail: with the number of parts that of the threads (the sums), and with the last part left out of the sums.
TEST(Pairs, AreTheSameForAnyNumberOfThreads) {
  Surface<3> surface = flat_plate<3>(12 * dx, 2 * dx, 0.6 * dx);
  for (std::size_t k = 0; k < surface.position.size(); ++k)  // a step, with faces round its edge
    if (surface.position[k][0] > 0) {
      surface.position[k][1] += 2 * dx * surface.normal[k][1] - 2 * dx;
      if (surface.position[k][0] < 0.6 * dx) surface.normal[k] = Vector<3>::UnitX();
    }
  InterfaceParticles<3> particles = fluid_layers<3>(12 * dx, 3, dx, true, 2 * dx);
  const int threads_before = omp_get_max_threads();
  std::vector<InterfacePair<3>> of_one;
  std::vector<double> filled_of_one, seen_of_one;
  std::size_t past_corners = 0;
  for (const int threads : {1, 2, 3, 7}) {
    omp_set_num_threads(threads);
    InterfacePairs<3> pairs(1.5 * dx, dx);
    pairs.find(particles, surface);
    const auto all = pairs.all_pairs();
    if (threads == 1) of_one.assign(all.begin(), all.end()), past_corners = pairs.back_facing_pairs().size();
    if (threads == 1) filled_of_one = pairs.filled(), seen_of_one = pairs.seen_share();
    ASSERT_EQ(all.size(), of_one.size());
    EXPECT_EQ(pairs.back_facing_pairs().size(), past_corners);
    EXPECT_EQ(pairs.filled(), filled_of_one);
    EXPECT_EQ(pairs.seen_share(), seen_of_one);
    std::size_t others = 0;
    for (std::size_t m = 0; m < all.size(); ++m)
      others += all[m].particle != of_one[m].particle || all[m].point != of_one[m].point || all[m].b != of_one[m].b ||
                all[m].offset != of_one[m].offset;
    EXPECT_EQ(others, 0u) << threads << " threads";
  }
  omp_set_num_threads(threads_before);
  EXPECT_GT(past_corners, 0u);
  std::vector<double> filled(surface.position.size(), 0);
  for (const auto& pair : of_one) filled[pair.point] -= pair.b.dot(surface.normal[pair.point]) / surface.area[pair.point];
  for (std::size_t k = 0; k < filled.size(); ++k) EXPECT_NEAR(filled[k], filled_of_one[k], 1e-12);
}

/// A face at rest and fluid moving onto it at `approach`; the dissipative pressure that arrives on the face [Pa].
double riemann_on_a_wall(double limiter, double approach, double drift) {
  Case c = scene(2, dx);
  c.coupling.riemann_limiter = limiter;
  auto surface = flat_plate<2>(12 * dx, 4 * dx, 0.5 * dx);
  auto particles = fluid_layers<2>(12 * dx, 4, dx);
  // Half of the approach by either side; a common drift along the face raises |u|max and with it c0 only.
  for (auto& u : particles.velocity) u = {drift, -0.5 * approach};
  for (auto& u : surface.velocity) u = {drift, 0.5 * approach};
  Coupler<2> coupler(c, properties(surface.position.size()));
  coupler.first_exchange(0, duration, surface, particles);
  return -mean_traction<2>(surface, coupler.surface_load(), 6 * dx, 1)[1];
}

constexpr double mean_of_both = 2 * 1000 * 1200 / 2200.0;  ///< [kg/m^3]

// Seen to fail: with the approach of the wrong sign; with the fluid's density for the mean; with the limiter not divided by c0.
TEST(RiemannDissipation, IsHalfEtaRhoTimesTheApproachSquaredWhateverTheSoundSpeed) {
  // Within what the face kernel transfers of a pressure on this lattice.
  const double expected = 0.5 * 3 * mean_of_both * 0.8 * 0.8;
  for (double drift : {0.0, 1.0, 7.0}) EXPECT_NEAR(riemann_on_a_wall(3, 0.8, drift), expected, 2e-3 * expected) << "drift " << drift;
  EXPECT_NEAR(riemann_on_a_wall(3, 0.8, 7), riemann_on_a_wall(3, 0.8, 0), 1e-9 * expected);
  EXPECT_NEAR(riemann_on_a_wall(3, 0.4, 1), 0.25 * riemann_on_a_wall(3, 0.8, 1), 1e-9 * expected);
}

// Seen to fail: without the check of the sign of the approach.
TEST(RiemannDissipation, IsNothingWhenTheSidesPart) {
  EXPECT_EQ(riemann_on_a_wall(3, -0.8, 1.0), 0);
  EXPECT_EQ(riemann_on_a_wall(3, 0, 1.0), 0);
  EXPECT_EQ(riemann_on_a_wall(3, 0, 0), 0);
}

// Seen to fail: without the cap.
TEST(RiemannDissipation, IsCappedWhereTheApproachExceedsTheSoundSpeedOverEta) {
  // Alone, the fastest speed is half the approach: c0 = 5 du, and eta = 20 puts du at 4 times c0/eta.
  const double approach = 0.8, sound_speed = 5 * approach;
  const double expected = 0.5 * mean_of_both * sound_speed * approach;
  EXPECT_NEAR(riemann_on_a_wall(20, approach, 0), expected, 2e-3 * expected);
  EXPECT_EQ(riemann_pressure(3, 1000, 30, 10), 0.5 * 1000 * 30 * 10.0);
  EXPECT_EQ(riemann_pressure(3, 1000, 30, 100), 0.5 * 1000 * 30 * 100.0);
  EXPECT_EQ(riemann_pressure(3, 1000, 30, -1), 0);
}

// Particles that come a quarter of a spacing nearer in a window lose a part of their approach, however heavy the face is: the first layer
// 0.32 of it beside its own density, twice that beside any. Seen to fail: with the arithmetic mean (300 times the approach, the other way).
TEST(RiemannDissipation, ThrowsNoParticleBackFromAHeavyBody) {
  constexpr double approach = 1, window = 0.25 * dx / approach;
  for (const double body : {1000.0, 2e6}) {
    Case c = scene(2, dx);
    c.coupling.riemann_limiter = 3;
    c.structure->bodies[0].density = body;
    const auto surface = flat_plate<2>(12 * dx, 4 * dx, 0.5 * dx);
    auto particles = fluid_layers<2>(12 * dx, 4, dx);
    for (auto& u : particles.velocity) u = {0, -approach};
    Coupler<2> coupler(c, properties(surface.position.size()));
    const auto load = coupler.first_exchange(0, window, surface, particles);
    double largest = 0;
    for (std::size_t i = 0; i < particles.id.size(); ++i) largest = std::max(largest, window / (1000 * dx * dx) * load.force[i][1]);
    std::printf("[ %g kg/m^3: %.2f of the approach ]\n", body, largest);
    EXPECT_GT(largest, 0.1 * approach);
    EXPECT_LT(largest, approach);
  }
}

// Seen to fail: with half the account; with 1 - 1e-9 of the force on one side.
TEST(RiemannDissipation, IsThePowerThePairsTakeFromBothSides) {
  for (unsigned seed : {4u, 5u}) {
    const auto r = random_interface<2>(seed);
    Case c = everything_on<2>();
    c.coupling.vem_coefficient.reset();
    Coupler<2> coupler(c, properties(r.surface.position.size()));
    const auto load = coupler.first_exchange(0, duration, r.surface, r.particles);
    double power = 0;
    for (std::size_t i = 0; i < r.particles.id.size(); ++i) power += load.force[i].dot(r.particles.velocity[i]);
    for (std::size_t k = 0; k < r.surface.position.size(); ++k) power += coupler.surface_load().force[k].dot(r.surface.velocity[k]);
    EXPECT_GT(coupler.audit().riemann_dissipation, 0);
    EXPECT_NEAR(coupler.audit().riemann_dissipation, -power * duration, 1e-12 * std::abs(power * duration)) << "seed " << seed;
  }
}

/// Coupling with the VEM term alone.
template <int D>
Case mitigation_only(double coefficient, VemForm form = VemForm::pairmax) {
  Case c = scene(D, dx);
  c.coupling.vem_coefficient = coefficient;
  c.coupling.vem_form = form;
  return c;
}

template <int D>
double power_of(const Surface<D>& surface, const InterfaceParticles<D>& particles, const SurfaceLoad<D>& on_surface,
                const InterfaceCondition<D>& on_band) {
  double power = 0;
  for (std::size_t i = 0; i < particles.id.size(); ++i) power += on_band.force[i].dot(particles.velocity[i]);
  for (std::size_t k = 0; k < surface.position.size(); ++k) power += on_surface.force[k].dot(surface.velocity[k]);
  return power;
}

/// A random interface whose particles have the divergence that the interface itself makes; `fastest`: of the particles at it.
template <int D>
RandomInterface<D> interface_with_its_divergence(unsigned seed, double& fastest) {
  auto r = random_interface<D>(seed);
  InterfacePairs<D> pairs(1.5 * dx, dx);
  pairs.find(r.particles, r.surface);
  std::fill(r.particles.divergence.begin(), r.particles.divergence.end(), 0.0);
  for (const auto& pair : pairs.pairs())
    r.particles.divergence[pair.particle] +=
        pair.b.dot(r.surface.velocity[pair.point] - r.particles.velocity[pair.particle]) / r.particles.volume[pair.particle];
  fastest = 0;
  std::vector<char> seen(r.particles.id.size(), 0);
  for (const auto& pair : pairs.pairs()) seen[pair.particle] = 1;
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (seen[i]) fastest = std::max(fastest, r.particles.velocity[i].norm());
  return r;
}

template <int D>
void check_mitigation(unsigned seed, VemForm form) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  double fastest;
  const auto r = interface_with_its_divergence<D>(seed, fastest);
  Coupler<D> coupler(mitigation_only<D>(5, form), properties(r.surface.position.size()));
  const auto load = coupler.first_exchange(0, duration, r.surface, r.particles);
  // p_i V_i div_i with p_i = -rho C h |u|max div_i; of pairmax where the divergence is negative.
  double expected = 0;
  for (std::size_t i = 0; i < r.particles.id.size(); ++i)
    if (r.particles.divergence[i] < 0 || form == VemForm::sum)
      expected -= 1000 * 5 * 1.5 * dx * fastest * r.particles.divergence[i] * r.particles.divergence[i] * r.particles.volume[i];
  ASSERT_LT(expected, 0);
  EXPECT_NEAR(power_of(r.surface, r.particles, coupler.surface_load(), load), expected, 1e-12 * std::abs(expected));
  EXPECT_NEAR(coupler.audit().mitigation_dissipation, -expected * duration, 1e-12 * std::abs(expected) * duration);
  Vector<D> sum = Vector<D>::Zero();
  double size = 0;
  for (const auto& f : load.force) sum += f, size += f.norm();
  for (const auto& f : coupler.surface_load().force) sum += f, size += f.norm();
  EXPECT_LT(sum.norm() / size, 1e-13);
  bool pulls = false;
  for (std::size_t k = 0; k < r.surface.position.size(); ++k) pulls = pulls || coupler.surface_load().force[k].dot(r.surface.normal[k]) > 0;
  EXPECT_EQ(pulls, form == VemForm::sum) << "pairmax pushes apart only";
}

// Seen to fail: with the velocity of the point left out of the account; with negative pressures let through.
TEST(VelocityDivergenceMitigation, TakesTheSquareOfTheDivergenceFromThePairs) {
  for (VemForm form : {VemForm::pairmax, VemForm::sum}) {
    check_mitigation<2>(6, form);
    check_mitigation<3>(7, form);
  }
}

// Equation 7 as printed: the sides of a pair take their switches from different pressures. It dissipates, if not in every
// state, but the forces of the two sides do not cancel, and the audit says by how much.
// Seen to fail: with the switch of the fluid's side used on both.
TEST(VelocityDivergenceMitigation, InThePublishedFormDissipatesAndLosesMomentum) {
  for (double body_density : {1000.0, 8000.0, 200.0}) {
    double power = 0, lost = 0, forces = 0;
    for (unsigned seed = 20; seed < 30; ++seed) {
      double fastest;
      const auto r = interface_with_its_divergence<2>(seed, fastest);
      Case c = mitigation_only<2>(5, VemForm::seed);
      c.structure->bodies[0].density = body_density;
      Coupler<2> coupler(c, properties(r.surface.position.size()));
      const auto load = coupler.first_exchange(0, duration, r.surface, r.particles);
      const double one_power = power_of(r.surface, r.particles, coupler.surface_load(), load);
      Vector<2> sum = Vector<2>::Zero();
      double size = 0;
      for (const auto& f : load.force) sum += f, size += f.norm();
      for (const auto& f : coupler.surface_load().force) sum += f, size += f.norm();
      coupler.last_exchange(pressure_field<2>(r.particles, [](const Vector<2>&) { return 0.0; }));
      power += one_power;
      lost += sum.norm();
      forces += size;
      EXPECT_NEAR(coupler.audit().mitigation_dissipation, -one_power * duration, 1e-12 * std::abs(one_power) * duration);
      if (coupler.audit().contacts == 0) {
        EXPECT_NEAR(coupler.audit().force_error, sum.norm() / size, 1e-12);
      }
    }
    EXPECT_LT(power, 0) << body_density;
    EXPECT_GT(lost / forces, 0.02) << body_density;
    EXPECT_LT(lost / forces, 0.15) << body_density;
    std::printf("[ density ratio %.1f: %.1f %% of the forces have no reaction; power %.0f W/m ]\n", body_density / 1000,
                100 * lost / forces, power / 10);
  }
}

// Seen to fail: with negative pressures let through.
TEST(VelocityDivergenceMitigation, IsNothingWhereTheFluidDoesNotConverge) {
  auto r = random_interface<2>(8);
  for (auto& d : r.particles.divergence) d = std::abs(d);
  r.particles.divergence[3] = 0;
  Coupler<2> coupler(mitigation_only<2>(5), properties(r.surface.position.size()));
  for (const auto& f : coupler.first_exchange(0, duration, r.surface, r.particles).force) EXPECT_EQ(f.norm(), 0);
  EXPECT_EQ(coupler.audit().mitigation_dissipation, 0);
  EXPECT_EQ(mitigation_pressure(VemForm::pairmax, -10, 0).on_fluid, 0);
  EXPECT_EQ(mitigation_pressure(VemForm::pairmax, 10, 0).on_fluid, 10);
}

}  // namespace
}  // namespace tern::coupler::testing
