// Whether fluid and structure agree after a pass.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "coupler/acceleration/agreement.hpp"
#include "fixtures/interface_scenes.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double dx = 0.01, dt = 1e-3, load = 5e3;

/// Two bodies with a face of ten points each, at rest under `load` [Pa], and the velocities that the structure answers with.
class Faces {
 public:
  Faces() : setup_(with_another_body(scene(2, dx)), properties_of_two()), state_(setup_), window_(setup_) {
    Surface<2>& surface = window_.surface;
    for (int k = 0; k < 2 * points; ++k) add_point<2>(surface, {(k + 0.5) * dx, 0.0}, {0.0, 1.0}, dx);
    window_.duration = dt;
    window_.share.assign(2 * points, 1);
    window_.answer = {lumps_of_points(2 * points), std::vector<double>(2 * points, 20 * dx), 1};
    window_.assumed_load.force.assign(2 * points, Vector<2>{0, -load * dx});
    answer_ = window_.assumed_load;
    velocity_.assign(2 * points, Vector<2>::Zero());
  }

  /// The structure is faster than the fluid took it to be, in one body.
  bool agree_with_error(double error, int body) {
    for (int k = 0; k < points; ++k) velocity_[static_cast<std::size_t>(body * points + k)][1] = error;
    const bool agree = disagreement(setup_, state_, window_, answer_, velocity_).agrees();
    for (Vector<2>& v : velocity_) v.setZero();
    return agree;
  }

  /// Error of velocity that stands for this share of the load of a body.
  double error_of(double share, int body) const { return share * load * dt / setup_.moved_mass[static_cast<std::size_t>(body)]; }

  /// The other load that the fluid answers with has moved the surface as told.
  void push_on(double pressure) {
    for (Vector<2>& f : answer_.force) f[1] -= pressure * dx;
    for (Vector<2>& v : velocity_) v[1] = -pressure * dt / 20;
  }

  void dry(int body) { std::fill_n(window_.share.begin() + body * points, points, 0.0); }

  Disagreement now() const { return disagreement(setup_, state_, window_, answer_, velocity_); }
  std::vector<Vector<2>>& velocity() { return velocity_; }

 private:
  static constexpr int points = 10;

  static SurfaceProperties properties_of_two() {
    SurfaceProperties of = properties(2 * points, 4);  // less than half a layer: light
    for (std::size_t k = points; k < 2 * points; ++k) of.body[k] = 1;
    return of;
  }

  Setup<2> setup_;
  State<2> state_;
  Workspace<2> window_;
  SurfaceLoad<2> answer_;
  std::vector<Vector<2>> velocity_;
};

// At rest under a load the velocity is next to nothing, and a share of it says nothing of the load.
// Seen to fail: with a share of the speed of a spacing per window in place of the load.
TEST(Agreement, CountsWhatAnErrorOfVelocityIsWorthAsALoad) {
  Faces faces;
  EXPECT_TRUE(faces.agree_with_error(faces.error_of(0.029, 0), 0));
  EXPECT_FALSE(faces.agree_with_error(faces.error_of(0.031, 0), 0));
}

// Seen to fail: with sums over all bodies.
TEST(Agreement, HoldsForEveryBodyByItself) {
  Faces faces;
  for (const int body : {0, 1}) EXPECT_FALSE(faces.agree_with_error(faces.error_of(0.04, body), body)) << body;
}

// A body in the air agrees with everything, and says nothing of the one in the water. Seen to fail: with the sums of a dry body, 0 and 0,
// held against those of a wet one.
TEST(Agreement, IsNotThatOfADryBody) {
  for (const int wet : {0, 1}) {
    Faces faces;
    faces.dry(1 - wet);
    EXPECT_FALSE(faces.agree_with_error(faces.error_of(0.04, wet), wet)) << wet;
    EXPECT_TRUE(faces.agree_with_error(1, 1 - wet)) << wet;
  }
}

// Seen to fail: without the change of velocity; with the answer of the lumps left out.
TEST(Agreement, AcceptsAShareOfTheChangeOfVelocity) {
  Faces faces;
  faces.push_on(4e4);
  EXPECT_LT(faces.now().size, 1e-12) << "it has moved as told";
  const std::vector<Vector<2>> told = faces.velocity();
  for (const double share : {0.09, 0.11}) {
    for (std::size_t k = 0; k < told.size(); ++k) faces.velocity()[k] = (1 + share) * told[k];
    EXPECT_EQ(faces.now().agrees(), share < 0.1) << share;
  }
}

// In a later pass, too, it is the surface itself that is asked, before the fluid is asked once more. What its lumps make of the last
// change of the load is a bound that is far too large for a surface that moves as they say.
// Seen to fail: with the bound alone in later passes; with the load of the quasi-Newton steps left out after a refusal.
TEST(Agreement, OfALaterPassIsThatOfTheSurfaceItself) {
  constexpr double mass = 20;
  const Surface<2> surface = flat_plate<2>(12 * dx, 4 * dx, dx);
  const InterfaceParticles<2> particles = fluid_layers<2>(12 * dx, 4, dx);
  const auto answered = [&](double pressure) { return pressure_field<2>(particles, [&](const Vector<2>&) { return pressure; }); };
  for (const bool as_told : {true, false}) {
    Coupler<2> coupler(scene(2, dx), properties(surface.position.size(), mass));
    coupler.first_exchange(0, dt, surface, particles);
    const SurfaceLoad<2>* next = coupler.next_load(answered(1e3));
    ASSERT_NE(next, nullptr);
    const SurfaceLoad<2> first = *next;
    std::vector<Vector<2>> velocity = surface.velocity;
    for (Vector<2>& v : velocity) v[1] = 2;
    EXPECT_FALSE(coupler.accepts(velocity));
    EXPECT_EQ(coupler.accelerated_load(), nullptr) << "the surface has moved under the load to go on with";
    coupler.repeat_exchange(velocity);

    next = coupler.next_load(answered(2e5));
    ASSERT_NE(next, nullptr);
    const SurfaceLoad<2> second = *next;
    for (std::size_t k = 0; as_told && k < velocity.size(); ++k)
      velocity[k] += dt / (mass * surface.area[k]) * (second.force[k] - first.force[k]);
    EXPECT_EQ(coupler.accepts(velocity), as_told);
    EXPECT_EQ(coupler.agreed(), as_told);
    if (!as_told) {
      EXPECT_NE(coupler.accelerated_load(), nullptr);
    }
    EXPECT_EQ(coupler.iterations(), 2);
  }
}

}  // namespace
}  // namespace tern::coupler::testing
