// How the surface has answered, learnt from windows: of masses that the formula does not know, and of plates that answer as a whole.

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <tuple>

#include "coupler/acceleration/learnt_response.hpp"
#include "fixtures/interface_scenes.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double dx = 0.01, dt = 1e-3, guess = 20;

/// Faces of `length` along x, `apart` points, wet above and, where `thickness` is not 0, below.
Surface<2> faces(double length, double apart, double thickness) {
  Surface<2> surface;
  for (double x = 0.5 * apart; x < length; x += apart) {
    add_point<2>(surface, {x, 0.0}, {0.0, 1.0}, apart);
    if (thickness > 0) add_point<2>(surface, {x, -thickness}, {0.0, -1.0}, apart);
  }
  return surface;
}

/// Learns from windows in which random changes of pressure on all points are answered by `answer`: velocities from forces.
class Learner {
 public:
  /// `second`: of the points from there on, which are those of a second body, pressures change by a thousandth as much.
  explicit Learner(const Surface<2>& surface, double section_mass = guess, std::size_t second = std::string::npos, bool held = true)
      : setup_(two_bodies(held), properties_of(surface.position.size(), section_mass, second)),
        window_(setup_),
        second_(second) {
    window_.surface = surface;
    window_.duration = dt;
    window_.responding_mass.assign(surface.position.size(), section_mass);
    window_.share.assign(surface.position.size(), 1);
    response_.prepare(setup_, {surface.position, surface.normal, surface.area});
  }

  template <class Answer>
  void windows(int number, const Answer& answer) {
    const Surface<2>& surface = window_.surface;
    for (int window = 0; window < number; ++window) {
      push();
      const std::vector<Vector<2>> faster = answer(window_.answered_load.force);
      std::vector<Vector<2>> velocity = surface.velocity;
      for (std::size_t k = 0; k < velocity.size(); ++k) velocity[k] += faster[k];
      response_.learn(setup_, window_, velocity);
    }
  }

  void for_windows_of(double duration) { response_.adjust_to(duration); }
  SurfaceAnswer learnt() const { return response_.answer(setup_, window_.responding_mass, window_.surface.area); }

  /// What is foretold wrong of the answer to another push, over the answer; normal components.
  template <class Answer>
  double error(const Answer& answer) {
    push();
    const Surface<2>& surface = window_.surface;
    const SurfaceAnswer taken = learnt();
    LumpMotion<2> motion(taken.lumps, taken.mass, dt);
    for (std::size_t k = 0; k < surface.position.size(); ++k) motion.push(k, window_.answered_load.force[k]);
    const std::vector<Vector<2>> exact = answer(window_.answered_load.force);
    double wrong = 0, size = 0;
    for (std::size_t k = 0; k < exact.size(); ++k) {
      wrong += std::pow((motion.velocity(k) - exact[k]).dot(surface.normal[k]), 2);
      size += std::pow(exact[k].dot(surface.normal[k]), 2);
    }
    return std::sqrt(wrong / size);
  }

 private:
  void push() {
    const Surface<2>& surface = window_.surface;
    std::normal_distribution<double> pressure(0, 500);
    window_.assumed_load.force.assign(surface.position.size(), Vector<2>::Zero());
    window_.answered_load.force.clear();
    for (std::size_t k = 0; k < surface.position.size(); ++k)
      window_.answered_load.force.push_back((k < second_ ? -1 : -1e-3) * pressure(random_) * surface.area[k] * surface.normal[k]);
  }

  static Case two_bodies(bool held) {
    Case c = scene(2, dx);
    if (held) c.structure->bodies[0].clamps = {c.structure->bodies[0].shape};
    return with_another_body(c);
  }

  static SurfaceProperties properties_of(std::size_t points, double section_mass, std::size_t second) {
    SurfaceProperties of = properties(points, section_mass);
    for (std::size_t k = second; k < points; ++k) of.body[k] = 1;
    return of;
  }

  Setup<2> setup_;
  Workspace<2> window_;
  LearntResponse<2> response_;
  std::size_t second_;
  std::mt19937 random_{4};
};

/// Every point moves by itself, with this mass per area.
auto points_of(const Surface<2>& surface, std::vector<double> mass) {
  return [=](const std::vector<Vector<2>>& force) {
    std::vector<Vector<2>> faster;
    for (std::size_t k = 0; k < force.size(); ++k) faster.push_back(dt / (mass[k] * surface.area[k]) * force[k]);
    return faster;
  };
}

/// A thin plate with `mass` per area of each face: it moves as the forces on both faces push it, smoothed over this length.
auto plate_of(const Surface<2>& surface, double mass, double length) {
  return [=](const std::vector<Vector<2>>& force) {
    std::vector<Vector<2>> faster;
    for (const Vector<2>& x : surface.position) {
      Vector<2> pushed = Vector<2>::Zero();
      double moved = 0;
      for (std::size_t l = 0; l < force.size(); ++l) {
        const double near = std::exp(-std::pow((x[0] - surface.position[l][0]) / length, 2));
        pushed += near * force[l];
        moved += near * mass * surface.area[l];
      }
      faster.push_back(dt / moved * pushed);
    }
    return faster;
  };
}

// Seen to fail: with what is learnt left out of the answer.
TEST(LearntResponse, FindsMassesThatTheFormulaDoesNotKnow) {
  const Surface<2> surface = faces(0.2, 0.5 * dx, 0);
  std::vector<double> mass(surface.position.size());
  for (std::size_t k = 0; k < mass.size(); ++k) mass[k] = k < mass.size() / 2 ? 8 : 40;
  Learner learner(surface);
  learner.windows(10, points_of(surface, mass));
  const SurfaceAnswer learnt = learner.learnt();
  ASSERT_EQ(learnt.lumps.per_point, 1u) << "points that answer by themselves are lumps of their own";
  for (std::size_t k = 0; k < mass.size(); ++k)
    EXPECT_NEAR(learnt.mass[learnt.lumps.lump[k]], mass[k] * surface.area[k], 1e-9 * mass[k]) << k;
  EXPECT_LT(learner.error(points_of(surface, mass)), 1e-9);
}

// Seen to fail: with the mean of all bodies for what shows something; the second one then is taken to answer as it was guessed to.
TEST(LearntResponse, LearnsOfEachBodyByItself) {
  const Surface<2> surface = faces(0.2, 0.5 * dx, 0);
  const std::size_t second = surface.position.size() / 2;
  const std::vector<double> mass(surface.position.size(), 3 * guess);
  Learner learner(surface, guess, second);
  learner.windows(10, points_of(surface, mass));
  const SurfaceAnswer learnt = learner.learnt();
  ASSERT_EQ(learnt.lumps.per_point, 1u) << "points that answer by themselves are lumps of their own";
  for (std::size_t k = 0; k < mass.size(); ++k)
    EXPECT_NEAR(learnt.mass[learnt.lumps.lump[k]], mass[k] * surface.area[k], 1e-9 * mass[k]) << k;
}

// Seen to fail: with all windows kept.
TEST(LearntResponse, FollowsWhatChanges) {
  const Surface<2> surface = faces(0.2, 0.5 * dx, 0);
  const std::vector<double> before(surface.position.size(), 8), after(surface.position.size(), 30);
  Learner learner(surface);
  learner.windows(50, points_of(surface, before));
  learner.windows(30, points_of(surface, after));
  EXPECT_LT(learner.error(points_of(surface, after)), 0.05);
}

// A plate of a tenth of the spacing's section under fluid on both sides: an answer point by point misses most of it.
// Seen to fail: with points alone on trial; without the way of a point into the body, by which both faces share their lumps.
TEST(LearntResponse, FindsThatAThinPlateMovesAsAWhole) {
  for (const double length : {0.8 * dx, 1.6 * dx}) {
    const Surface<2> surface = faces(0.2, 0.25 * dx, 0.4 * dx);
    Learner learner(surface, 2.4);  // half the thickness of 1200 kg/m^3
    const auto plate = plate_of(surface, 2.4, length);
    EXPECT_GT(learner.error(plate), 0.9) << "before it has learnt";
    learner.windows(20, plate);
    EXPECT_EQ(learner.learnt().lumps.per_point, 4u);
    EXPECT_LT(learner.error(plate), 0.35) << length / dx << " dx";
  }
}

/// Mass of all lumps.
double mass_of_all(const Learner& learner) {
  const std::vector<double> mass = learner.learnt().mass;
  return std::accumulate(mass.begin(), mass.end(), 0.0);
}

// A stiff plate is held within a window: it answers as one of many times the mass of its section.
// Seen to fail: with four times the guess as the heaviest (the first); with a hundred times (the second).
TEST(LearntResponse, FindsThatAStiffPlateHardlyAnswers) {
  const Surface<2> surface = faces(0.2, 0.5 * dx, 0);
  const auto after_windows = [&](double times) {
    Learner learner(surface);
    learner.windows(50, points_of(surface, std::vector<double>(surface.position.size(), times * guess)));
    return learner;
  };
  EXPECT_LT(after_windows(30).error(points_of(surface, std::vector<double>(surface.position.size(), 30 * guess))), 0.05);
  EXPECT_GT(mass_of_all(after_windows(3e4)), 0.5 * 3e4 * guess * 0.2);
}

// A body that nothing holds answers what moves it as a whole with its mass, however little the loads so far have moved it. If it is lighter
// than the fluid that has to move with it, here 534 kg/m^2, it is taken for no heavier than an error of the load may come back from. Seen
// to fail: with the limit of bodies that are held.
TEST(LearntResponse, LimitsTheMassOfABodyThatNothingHolds) {
  const Surface<2> surface = faces(0.2, 0.5 * dx, 0);
  for (const auto& [section_mass, times, taken] :
       {std::tuple{20.0, 31.0, 2.078}, {20.0, 1.5, 1.5}, {20.0, -20.0, 2.078}, {400.0, 31.0, 7.98}, {600.0, 31.0, 31.0}}) {
    Learner learner(surface, section_mass, std::string::npos, false);
    learner.windows(50, points_of(surface, std::vector<double>(surface.position.size(), times * section_mass)));
    EXPECT_NEAR(mass_of_all(learner) / (section_mass * 0.2), taken, 0.01 * taken) << section_mass << ", " << times;
  }
}

// What holds a stiff plate within a window counts by the square of its length, what does not is as heavy in all. Seen to fail: without it
// (31 times the guess in half a window, too); with all that is heavier than the guess (1.05 for 1.19).
TEST(LearntResponse, FollowsTheLengthOfTheWindow) {
  const Surface<2> surface = faces(0.2, 0.5 * dx, 0);
  for (const auto& [times, in_half] : {std::pair{31.0, 8.64}, {0.5, 0.5}, {1.19, 1.19}}) {
    Learner learner(surface);
    learner.for_windows_of(dt);
    learner.windows(50, points_of(surface, std::vector<double>(surface.position.size(), times * guess)));
    learner.for_windows_of(0.5 * dt);
    EXPECT_NEAR(mass_of_all(learner), in_half * guess * 0.2, 0.02 * in_half * guess * 0.2) << times;
    learner.for_windows_of(dt);
    EXPECT_NEAR(mass_of_all(learner), times * guess * 0.2, 0.02 * times * guess * 0.2) << times;
  }
}

// Seen to fail: without the limits.
TEST(LearntResponse, StaysWithinLimitsOfTheGuess) {
  const Surface<2> surface = faces(0.2, 0.5 * dx, 0);
  const double guessed = mass_of_all(Learner(surface));
  Learner still(surface), wild(surface), wrong(surface);
  EXPECT_NEAR(guessed, guess * 0.2, 1e-12) << "before the first window";
  still.windows(3, points_of(surface, std::vector<double>(surface.position.size(), 1e15)));
  wild.windows(3, points_of(surface, std::vector<double>(surface.position.size(), 1e-9)));
  wrong.windows(3, points_of(surface, std::vector<double>(surface.position.size(), -20)));
  EXPECT_NEAR(mass_of_all(still), 1e6 * guessed, 1e-5);
  EXPECT_NEAR(mass_of_all(wild), 0.05 * guessed, 1e-9);
  EXPECT_NEAR(mass_of_all(wrong), 1e6 * guessed, 1e-5);
}

// The lumps of a thick body know of one face alone, and bodies have none in common.
// Seen to fail: with all of a section as the way into the body; with bodies left out of the key.
TEST(SurfaceLumps, AreOfOneBodyAndOfOneFaceOfAThickOne) {
  for (const double thickness : {0.2 * dx, 8 * dx}) {
    const Surface<2> surface = faces(0.1, 0.5 * dx, thickness);
    std::vector<std::uint32_t> body(surface.position.size(), 0);
    const std::vector<double> depth(surface.position.size(), 0.5 * thickness);
    const auto common = [&](std::size_t k, std::size_t l) {
      const SurfaceLumps lumps = lumps_of_width<2>(1.5 * dx, {surface.position, surface.normal, surface.area}, body, depth);
      double sum = 0;
      for (std::size_t s = 4 * k; s < 4 * k + 4; ++s)
        for (std::size_t t = 4 * l; t < 4 * l + 4; ++t) sum += lumps.lump[s] == lumps.lump[t] ? lumps.share[s] * lumps.share[t] : 0;
      return sum;
    };
    EXPECT_GT(common(0, 0), 0.2);
    if (thickness < dx) {
      EXPECT_NEAR(common(0, 1), common(0, 0), 1e-12) << "both faces at one place";
    } else {
      EXPECT_EQ(common(0, 1), 0);
    }
    body[1] = 1;
    EXPECT_EQ(common(0, 1), 0) << "of two bodies";
  }
}

// Widths are shared out among threads, and so are the pairs that carry pressures. Seen to fail with the sums of squares of all widths in
// one array.
TEST(Window, HasTheSameBitsForAnyNumberOfThreads) {
  const Surface<3> surface = flat_plate<3>(14 * dx, 2 * dx, 0.6 * dx);  // 4 232 points
  InterfaceParticles<3> particles = fluid_layers<3>(14 * dx, 3, dx, true, 2 * dx);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> disorder(-0.05 * dx, 0.05 * dx);
  for (auto& x : particles.position) x += Vector<3>(disorder(random), disorder(random), disorder(random));
  const std::size_t points = surface.position.size();
  const auto load_after_windows = [&](int threads) {
    omp_set_num_threads(threads);
    Coupler<3> coupler(scene(3, dx), properties(points, guess));
    SurfaceLoad<3> assumed;
    assumed.force.assign(points, Vector<3>::Zero());
    for (int window = 0; window < 4; ++window) {
      const auto pressure =
          pressure_field<3>(particles, [&](const Vector<3>& x) { return 1000 * std::sin(30 * x[0] + window) + 2000 * x[1]; });
      coupler.first_exchange(window * dt, dt, surface, particles);
      const SurfaceLoad<3>* load = coupler.next_load(pressure);
      std::vector<Vector<3>> velocity = surface.velocity;
      for (std::size_t k = 0; k < points; ++k) velocity[k] += dt / (2 * guess * surface.area[k]) * (load->force[k] - assumed.force[k]);
      coupler.accepts(velocity);
      coupler.last_exchange(pressure);
      assumed = coupler.surface_load();
    }
    std::vector<double> bits;
    for (const Vector<3>& force : assumed.force) bits.insert(bits.end(), force.data(), force.data() + 3);
    const auto& condition = coupler.first_exchange(4 * dt, dt, surface, particles);  // with what has been learnt
    bits.insert(bits.end(), condition.response.mass.begin(), condition.response.mass.end());
    return bits;
  };
  const int threads_before = omp_get_max_threads();
  const std::vector<double> of_one = load_after_windows(1);
  EXPECT_GT(of_one.size(), 3 * points);
  for (const int threads : {2, 3, 7}) EXPECT_EQ(load_after_windows(threads), of_one) << threads << " threads";
  omp_set_num_threads(threads_before);
}

}  // namespace
}  // namespace tern::coupler::testing
