// A surface that is not that of the case's bodies, or does not go where its velocity says, is found by name; nothing sound is taken for it.

#include "coupler/stability/surface_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "fixtures/coupled_scenes.hpp"

namespace tern::coupler::testing {
namespace {

constexpr int points = 12;
constexpr double mass = 5, area = 0.01;  // kg/m^2, m

SurfaceProperties properties() {
  return {std::vector<std::uint32_t>(points, 0), std::vector<double>(points, mass), std::vector<double>(points, 1e6),
          std::vector<double>(points, mass)};
}

/// What is run: points on springs, under loads of which all but the last of a window may have been tried.
struct Motion {
  double frequency = 0;                      ///< of the springs [1/s]
  double kept = 0.8;                         ///< of the velocity at the begin
  bool true_end = false;                     ///< the velocity at the end is sent as it is
  bool tried = true;                         ///< the last load has been tried
  double steady = 0, noise = 0, impact = 0;  ///< of the load, by the velocity it gives in a window [m/s]
  double shorter = 1;                        ///< every other window
};

using Spoil = std::function<void(std::vector<Vector<2>>& velocity)>;

/// Window in which a fault is found; 0: in none of so many.
int found(const Motion& motion, int windows, const Spoil& spoil = {}, const Spoil& spoil_position = {}) {
  struct State {
    Vector<2> u{0, 0}, v{0, 0};
  };
  SurfaceMotion<2> check(properties(), 1, true);
  std::vector<State> state(points);
  std::vector<Vector<2>> sent(points, Vector<2>::Zero()), load(points, Vector<2>::Zero());
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int n = 1; n <= windows; ++n) {
    const double dt = 1e-3 * (n % 2 ? 1 : motion.shorter);
    const auto advance = [&](State s, const Vector<2>& force) {
      const Vector<2> a = force / (area * mass);
      if (motion.frequency == 0) return State{s.u + dt * s.v + 0.5 * dt * dt * a, s.v + dt * a};
      const double w = motion.frequency, c = std::cos(w * dt), d = std::sin(w * dt);
      const Vector<2> rest = a / (w * w);
      return State{rest + (s.u - rest) * c + s.v / w * d, s.v * c - (s.u - rest) * w * d};
    };
    const auto velocity = [&](const std::vector<State>& end) {
      std::vector<Vector<2>> v(points);
      for (int k = 0; k < points; ++k)
        v[k] = motion.true_end ? end[k].v : (1 + motion.kept) * (end[k].u - state[k].u) / dt - motion.kept * sent[k];
      return v;
    };
    const auto all = [&](const std::vector<Vector<2>>& force) {
      std::vector<State> end(points);
      for (int k = 0; k < points; ++k) end[k] = advance(state[k], force[k]);
      return end;
    };
    const auto spoilt = [&](std::vector<Vector<2>> v) {
      if (spoil) spoil(v);
      return v;
    };
    const auto trial = all(load);
    Surface<2> surface;
    for (int k = 0; k < points; ++k) surface.position.push_back(0.5 * (state[k].u + trial[k].u) + Vector<2>(0.01 * k, 0));
    if (spoil_position && n % 2 == 0) spoil_position(surface.position);
    surface.velocity = spoilt(velocity(trial));
    surface.normal.assign(points, Vector<2>(1, 0));
    surface.area.assign(points, area);
    if (!check.surface(dt, surface).empty()) return n;
    for (int k = 0; k < points; ++k) {
      const double scale = area * mass / 1e-3, along = motion.steady * (1 + 0.1 * k) + (n == 30 ? motion.impact : 0);
      load[k] = scale * (along * Vector<2>(1, 0.2) + motion.noise * Vector<2>(normal(random), normal(random)));
    }
    const auto end = all(load);
    if (motion.tried) check.answer({load}, spoilt(velocity(end)));
    check.apply({load});
    sent = velocity(end);
    state = end;
  }
  return 0;
}

// Seen to fail: without the doubt of a load that was not tried, without that of the trial, without the change of the velocity in a window.
TEST(SurfaceMotion, NothingSoundIsRefused) {
  for (const double theta : {0.0, 0.1, 1.0, 2.0, 3.1, 3.2, 6.2, 6.3, 20.0, 50.0})
    for (const bool tried : {true, false})
      for (const double shorter : {1.0, 0.1})
        for (const double noise : {0.0, 0.3}) {
          const Motion motion{.frequency = theta * 1e3, .tried = tried, .steady = 0.05, .noise = noise, .impact = 30, .shorter = shorter};
          EXPECT_EQ(found(motion, 300), 0) << theta << ' ' << tried << ' ' << shorter << ' ' << noise;
        }
  // Another mixture, and the velocity at the end itself where the windows resolve the motion.
  for (const double kept : {0.0, 1.0}) EXPECT_EQ(found({.frequency = 300, .kept = kept, .steady = 0.05, .noise = 0.01}, 300), 0) << kept;
  for (const double theta : {0.0, 0.1, 1.0})
    EXPECT_EQ(found({.frequency = theta * 1e3, .true_end = true, .steady = 0.05, .noise = 0.02, .impact = 30}, 300), 0) << theta;
}

// Seen to fail: with all of the sum of both distances granted (interleaved, mm/s, sign), with 40 times the change of the velocity allowed.
TEST(SurfaceMotion, WrongVelocitiesAreFoundWithinTensOfWindows) {
  const Spoil apart = [](std::vector<Vector<2>>& v) {
    const std::vector<Vector<2>> whole = v;
    const auto entry = [&](int n) { return n < points ? whole[n][0] : whole[n - points][1]; };
    for (int k = 0; k < points; ++k) v[k] = Vector<2>(entry(2 * k), entry(2 * k + 1));
  };
  const auto times = [](double factor) {
    return [factor](std::vector<Vector<2>>& v) {
      for (auto& u : v) u *= factor;
    };
  };
  const Spoil turned = [](std::vector<Vector<2>>& v) {
    for (auto& u : v) u = Vector<2>(-u[1], u[0]);
  };
  const Spoil backwards = [](std::vector<Vector<2>>& v) { std::reverse(v.begin(), v.end()); };
  for (const double noise : {0.0, 0.01})
    for (const double frequency : {0.0, 100.0}) {
      const Motion motion{.frequency = frequency, .steady = 0.05, .noise = noise};
      const auto expect_found = [&](const char* name, int n) {
        EXPECT_GT(n, 0) << name << ' ' << noise << ' ' << frequency;
        EXPECT_LE(n, 40) << name << ' ' << noise << ' ' << frequency;
      };
      expect_found("interleaved", found(motion, 100, apart));
      expect_found("mm/s", found(motion, 100, times(1000)));
      expect_found("km/s", found(motion, 100, times(1e-3)));
      expect_found("sign", found(motion, 100, times(-1)));
      expect_found("turned", found(motion, 100, turned));
      expect_found("jump", found(motion, 100, {}, backwards));
    }
}

Surface<2> at_rest(const Case& scene) {
  const auto sampled = sample_surface<2>(scene.structure->bodies[0].shape, plate_spacing);
  return {sampled.position, std::vector<Vector<2>>(sampled.position.size(), Vector<2>::Zero()), sampled.normal, sampled.area};
}

using Change = std::function<void(Surface<2>&)>;

/// What is said of a surface in the first window, or in the second after a sound one.
std::string said(const Change& change, bool first, bool from_start = true) {
  const Case scene = case_of(CoupledScene{});
  Surface<2> surface = at_rest(scene);
  const std::size_t count = surface.area.size();
  const SurfaceProperties of_surface{std::vector<std::uint32_t>(count, 0), std::vector<double>(count, mass),
                                     std::vector<double>(count, 1e6), std::vector<double>(count, mass)};
  SurfaceCheck<2> check(scene, of_surface, from_start);
  if (!first) {
    EXPECT_EQ(check.surface(to_ticks(1e-3), surface), "");
  }
  change(surface);
  return check.surface(to_ticks(1e-3), surface);
}

Change moved_to(const std::function<Vector<2>(const Vector<2>&)>& place) {
  return [place](Surface<2>& s) {
    for (auto& x : s.position) x = place(x);
  };
}

// Seen to fail: with each of the limits far wider, without "first", and with it after a checkpoint.
TEST(SurfaceCheck, TheFirstSurfaceIsThatOfTheBodies) {
  const auto says = [](const std::string& text, const char* words) {
    EXPECT_NE(text.find(words), std::string::npos) << '"' << text << '"';
  };
  const Change nothing = [](Surface<2>&) {}, shifted = moved_to([](const Vector<2>&x) { return Vector<2>(x[0] + 0.05, x[1]); });
  EXPECT_EQ(said(nothing, true), "");
  EXPECT_EQ(said(moved_to([](const Vector<2>& x) { return Vector<2>(x[0] + 0.9 * plate_spacing, x[1]); }), true), "");
  says(said(shifted, true), "outside the shape of the body 'plate'; at the start it must lie on it to 0.005 m");
  EXPECT_EQ(said(shifted, true, false), "") << "after a checkpoint it is where it has got to";
  says(said(moved_to([](const Vector<2>& x) { return Vector<2>(2 * x); }), true), "the shape of the body");
  says(said(moved_to([](const Vector<2>& x) { return Vector<2>(-x[0], x[1]); }), true), "outside the shape of the body");
  says(said(moved_to([](const Vector<2>& x) { return Vector<2>(1000 * x); }), true), "outside the shape of the body");
  says(said([](Surface<2>& s) { s.normal[3] *= -1; }, true), "normal[3] = ");
  for (const double factor : {1000.0, 0.001, 2.0, 0.5})
    says(said(
             [&](Surface<2>& s) {
               for (double& a : s.area) a *= factor;
             },
             true),
         "the sum of area over the body 'plate' is ");
}

// A body that has gone farther than it is thick by the middle of the first window, with its tank. Seen to fail: with the shape at the start
// beside the points as they are then.
TEST(SurfaceCheck, TheFirstSurfaceMayHaveMoved) {
  const Vector<2> velocity(100, -30);
  const Change gone = [&](Surface<2>& s) {
    for (auto& x : s.position) x += 0.5e-3 * velocity;
    for (auto& v : s.velocity) v = velocity;
  };
  EXPECT_EQ(said(gone, true), "");
}

/// The points of a body at rest that are chosen, and how much of a surface their areas are said to be.
std::string said_of_part(const std::function<bool(const Vector<2>&, const Vector<2>&)>& chosen, double factor, std::size_t every = 1) {
  const Case scene = case_of(CoupledScene{});
  const Surface<2> whole = at_rest(scene);
  Surface<2> part;
  for (std::size_t k = 0, n = 0; k < whole.area.size(); ++k) {
    if (!chosen(whole.position[k], whole.normal[k]) || n++ % every != 0) continue;
    part.position.push_back(whole.position[k]), part.velocity.push_back(whole.velocity[k]), part.normal.push_back(whole.normal[k]);
    part.area.push_back(factor * static_cast<double>(every) * whole.area[k]);
  }
  const std::size_t count = part.area.size();
  const SurfaceProperties of_surface{std::vector<std::uint32_t>(count, 0), std::vector<double>(count, mass),
                                     std::vector<double>(count, 1e6), std::vector<double>(count, mass)};
  return SurfaceCheck<2>(scene, of_surface, true).surface(to_ticks(1e-3), part);
}

// Of all of a body, of one face, of half of that face, and of every third point of it. Seen to fail: against all of the surface.
TEST(SurfaceCheck, AreasAreThoseOfTheSurfaceBesideThePoints) {
  const auto all = [](const Vector<2>&, const Vector<2>&) { return true; };
  const auto upper = [](const Vector<2>&, const Vector<2>& n) { return n[1] > 0.9; };
  const auto half = [](const Vector<2>& x, const Vector<2>& n) { return n[1] > 0.9 && x[0] < 0.12; };
  for (const auto& chosen : {std::function<bool(const Vector<2>&, const Vector<2>&)>(all), {upper}, {half}})
    for (const std::size_t every : {1u, 3u}) {
      for (const double right : {0.9, 1.0, 1.1}) EXPECT_EQ(said_of_part(chosen, right, every), "") << right << ' ' << every;
      for (const double wrong : {0.5, 2.0})
        EXPECT_NE(said_of_part(chosen, wrong, every).find("the sum of area over the body 'plate' is "), std::string::npos)
            << wrong << ' ' << every;
    }
}

// Seen to fail: without a look at it.
TEST(SurfaceCheck, AParticleHasTheMassOfItsVolume) {
  const Case scene = case_of(CoupledScene{});
  const SurfaceCheck<2> check(scene, properties(), true);
  InterfaceParticles<2> particles;
  particles.id = {0}, particles.position = {Vector<2>(0.1, 0.1)}, particles.velocity = {Vector<2>::Zero()};
  particles.volume = {1e-4}, particles.mass = {scene.fluid->density * 1e-4};
  EXPECT_EQ(check.particles(to_ticks(1e-3), particles), "");
  particles.mass[0] *= 1e-9;
  EXPECT_NE(check.particles(to_ticks(1e-3), particles).find("mass[0] is "), std::string::npos);
}

// Seen to fail: without each of the four; with a tenfold stretch whatever the way.
TEST(SurfaceCheck, JumpsAreNamed) {
  EXPECT_NE(said([](Surface<2>& s) { s.normal[3] *= -1; }, false).find("normal[3] = "), std::string::npos);
  EXPECT_EQ(said([](Surface<2>& s) { s.normal[3] = Vector<2>(s.normal[3][1], -s.normal[3][0]); }, false), "") << "a quarter of a turn";
  // By no more than the points go against each other, and not tenfold.
  const auto stretched = [](double factor, double way) {
    return said(
        [&](Surface<2>& s) {
          s.area[4] *= factor;
          s.position[4][1] += way;
        },
        false);
  };
  EXPECT_EQ(stretched(1.2, 0), "");
  EXPECT_EQ(stretched(1 / 1.2, 0), "");
  EXPECT_NE(stretched(1.5, 0).find("area[4] is "), std::string::npos);
  EXPECT_NE(stretched(1 / 1.5, 0).find("area[4] is "), std::string::npos);
  EXPECT_EQ(stretched(1.5, 0.002), "");
  EXPECT_NE(stretched(11, 0.05).find("area[4] is "), std::string::npos);
  EXPECT_NE(said([](Surface<2>& s) { s.position[2][1] = 4; }, false).find("position[2] = "), std::string::npos);
  EXPECT_NE(said([](Surface<2>& s) { s.velocity[5][0] = 1e4; }, false).find("velocity[5] = "), std::string::npos);
}

}  // namespace
}  // namespace tern::coupler::testing
