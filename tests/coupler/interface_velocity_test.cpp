// One mode of a structure, of mass 1 and frequency omega, moves a fluid of mass M. Over a window the load p is constant, the
// structure moves exactly, and the fluid has to follow the velocity that followed_velocity() makes of its motion.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "fluid/pressure/enclosed_regions.hpp"
#include "structure/coupled_structure.hpp"

namespace tern::structure {
namespace {

using Followed = FollowedVelocity<double>;

/// A state: displacement, velocity, and both velocities that the fluid follows.
using Mode = Eigen::Vector4d;

/// The map of a window with omega dt = y, dt = 1; `follow(mean, velocity at the end, followed before)`.
template <class Follow>
Eigen::Matrix4d window_map(double y, double fluid_mass, Follow&& follow) {
  const double c = std::cos(y), s = std::sin(y);
  // After the window, under a load.
  const auto after = [&](const Mode& q, double load) {
    const double displacement = c * q[0] + s / y * q[1] + (1 - c) / (y * y) * load, velocity = -y * s * q[0] + c * q[1] + s / y * load;
    const Followed followed = follow(displacement - q[0], velocity, Followed{q[2], q[3]});
    return Mode(displacement, velocity, followed.given, followed.own);
  };
  Eigen::Matrix4d map;
  for (int column = 0; column < 4; ++column) {
    const Mode q = Mode::Unit(column);
    // The fluid takes w' = w - load/M, and w' is the velocity given: linear in the load.
    const double at_rest = after(q, 0)[2], mobility = after(Mode::Zero(), 1)[2];
    map.col(column) = after(q, (q[2] - at_rest) / (mobility + 1 / fluid_mass));
  }
  return map;
}

Followed follow_mean(double mean, double, const Followed& before) { return followed_velocity<double>(mean, before, 1); }

/// Largest factor by which a state grows in a window.
double largest_growth(auto&& follow) {
  double largest = 0;
  for (double fluid_mass : {0.1, 1.0, 10.0, 100.0, 1e4})
    for (double y = 0.01; y < 50; y *= 1.02)
      largest = std::max(largest, window_map(y, fluid_mass, follow).eigenvalues().cwiseAbs().maxCoeff());
  return largest;
}

// Seen to fail: with 1.2 in place of 0.2 of a motion left; the velocity at the end is the next test.
TEST(InterfaceVelocity, NeverLetsAModeGrowWhateverItsStiffnessAndMass) { EXPECT_LE(largest_growth(follow_mean), 1 + 1e-6); }

// Why not simply the velocity of the structure at the end of the window.
TEST(InterfaceVelocity, AtTheEndOfAWindowTheStructureMayMoveAgainstTheLoad) {
  EXPECT_GT(largest_growth([](double, double at_end, const Followed&) { return Followed{at_end, at_end}; }), 10);
}

// Seen to fail: with 1.8 times the mean less 0.8 times the velocity at the begin (1/18 of a window).
TEST(InterfaceVelocity, OfSteadyAccelerationDoesNotLag) {
  Followed seen{0, 0};
  for (int n = 0; n < 200; ++n) seen = followed_velocity<double>(n + 0.5, seen, 1);  // true velocity n + 1 at the end
  EXPECT_NEAR(seen.given, 200, 1e-11);
}

// Nor do windows of changing length. Seen to fail: with the ratio of their lengths left out (0.02 of a window).
TEST(InterfaceVelocity, OfSteadyAccelerationDoesNotLagInWindowsThatGrowOrShrink) {
  Followed seen{0, 0};
  double time = 0, length = 1, largest = 0;
  for (int n = 0; n < 200; ++n) {
    const double ratio = n == 0 ? 1 : n % 30 < 15 ? 1.1 : 1 / 1.1;
    length *= ratio;
    seen = followed_velocity<double>(time + 0.5 * length, seen, ratio);
    time += length;
    if (n >= 100) largest = std::max(largest, std::abs(seen.given - time) / length);
  }
  EXPECT_LT(largest, 1e-9);
}

/// As Mode of a free body: displacement and velocity of a mode that takes the part 1 - `rigid` of the answer to a load, velocity of the
/// centre of mass, and what both velocities that the fluid follows are more than that one.
using FreeBody = Eigen::Vector<double, 5>;

Eigen::Matrix<double, 5, 5> window_map_of_free_body(double rigid, double y, double fluid_mass) {
  const double c = std::cos(y), s = std::sin(y);
  const auto after = [&](const FreeBody& q, double load) {
    const double pull = (1 - rigid) * load;
    const double displacement = c * q[0] + s / y * q[1] + (1 - c) / (y * y) * pull;
    const Followed followed = follow_mean(displacement - q[0], 0, Followed{q[3], q[4]});
    return FreeBody(displacement, -y * s * q[0] + c * q[1] + s / y * pull, q[2] + rigid * load, followed.given, followed.own);
  };
  const auto given = [](const FreeBody& q) { return q[2] + q[3]; };
  Eigen::Matrix<double, 5, 5> map;
  for (int column = 0; column < 5; ++column) {
    const FreeBody q = FreeBody::Unit(column);
    const double mobility = given(after(FreeBody::Zero(), 1));
    map.col(column) = after(q, (given(q) - given(after(q, 0))) / (mobility + 1 / fluid_mass));
  }
  return map;
}

// The motion of the centre of mass is given as it is, what the body vibrates by is followed. Seen to fail: with the mode's velocity at the
// end given as well (316).
TEST(InterfaceVelocity, NeverLetsAFreeBodyGrowThatVibratesAsWell) {
  double largest = 0;
  for (const double rigid : {0.02, 0.3, 0.5, 0.8, 0.95})
    for (const double fluid_mass : {0.1, 1.0, 10.0, 100.0, 1e4})
      for (double y = 0.01; y < 50; y *= 1.02)
        largest = std::max(largest, window_map_of_free_body(rigid, y, fluid_mass).eigenvalues().cwiseAbs().maxCoeff());
  EXPECT_LE(largest, 1 + 1e-6);
}

// A load that alternates from window to window moves a body that nothing holds to and fro within windows, not from one to the next. Its
// mean velocity does not show that, and the load would die out slowly, the more so the lighter the body. Its velocity at the end does.
TEST(InterfaceVelocity, OfAFreeBodyShowsALoadThatAlternates) {
  const auto least = [](const auto& map) { return map.eigenvalues().real().minCoeff(); };
  for (const auto& [fluid_mass, by_the_mean] : {std::pair{1.0, -0.673}, {3.0, -0.836}, {10.0, -0.940}}) {
    EXPECT_NEAR(least(window_map(1e-4, fluid_mass, follow_mean)), by_the_mean, 0.002) << fluid_mass;
    EXPECT_GE(least(window_map_of_free_body(1, 0.01, fluid_mass)), -0.2 - 1e-6) << "stiff, " << fluid_mass;
  }
}

// Of a vibration with as much fluid as its own mass: angle and loss a period, with 44 and with 89 windows a period. Seen to fail: with
// 1.8 times the mean less 0.8 times the velocity at the begin (losses of 8.7e-3 and 4.4e-3, first order).
TEST(InterfaceVelocity, MakesAnErrorOfSecondOrderAndALossOfThird) {
  const auto measured = [](double phi) {
    const double y = phi * std::sqrt(2.0);  // the body alone
    std::complex<double> root;
    for (const std::complex<double>& value : window_map(y, 1.0, follow_mean).eigenvalues())
      if (value.imag() > 0 && std::abs(value) > 0.9) root = value;
    return std::pair(std::arg(root) / phi - 1, 2 * std::numbers::pi / phi * (1 - std::abs(root)));
  };
  const auto [angle, loss] = measured(0.1414);
  const auto [half_angle, half_loss] = measured(0.0707);
  std::printf("[ frequency %+.2e, loss a period %.2e; half the window: %+.2e, %.2e ]\n", angle, loss, half_angle, half_loss);
  EXPECT_NEAR(angle / half_angle, 4, 0.1);
  EXPECT_NEAR(loss / half_loss, 8, 0.4);
  EXPECT_LT(std::abs(angle), 1e-3);
  EXPECT_LT(loss, 5e-4);
}

/// A mode of omega dt = y that has a volume which enclosed fluid keeps: its load is what takes away taken_away(rate, pushed in), by an
/// answer to it of which the true one is `answers` times as much. A second one, of omega dt = `y_slow`, takes the part `slow` of it.
/// A state: as Mode, the load of the last window, displacement and velocity of the slow mode.
template <class TakenAway>
class HeldMode {
 public:
  using State = Eigen::Vector<double, 7>;
  HeldMode(double y, double answers, TakenAway taken_away, double slow = 0, double y_slow = 0.01)
      : y_(y), y_slow_(y_slow), slow_(slow), mobility_(after(State::Zero(), 1)[2] / answers), taken_away_(std::move(taken_away)) {}

  /// After a window, where the fluid's walls have gone `way`, in its middle, at the speed `speed`.
  State operator()(const State& q, double way = 0, double speed = 0) const {
    const State trial = after(q, q[4]);
    const double taken = taken_away_(trial[2] - speed, 0.5 * (q[0] + q[5] + trial[0] + trial[5]) - way);
    return after(q, q[4] - taken / mobility_);
  }

  double growth() const {
    Eigen::Matrix<double, 7, 7> map;
    for (int column = 0; column < 7; ++column) map.col(column) = (*this)(State::Unit(column));
    return map.eigenvalues().cwiseAbs().maxCoeff();
  }

 private:
  /// Displacement and velocity of a mode of mass 1 after a window.
  static std::pair<double, double> moved(double y, double displacement, double velocity, double load) {
    const double c = std::cos(y), s = std::sin(y);
    return {c * displacement + s / y * velocity + (1 - c) / (y * y) * load, -y * s * displacement + c * velocity + s / y * load};
  }
  State after(const State& q, double load) const {
    const auto [x, v] = moved(y_, q[0], q[1], (1 - slow_) * load);
    const auto [x_slow, v_slow] = moved(y_slow_, q[5], q[6], slow_ * load);
    const Followed followed = follow_mean(x - q[0] + x_slow - q[5], 0, Followed{q[2], q[3]});
    return {x, v, followed.given, followed.own, load, x_slow, v_slow};
  }
  double y_, y_slow_, slow_, mobility_;
  TakenAway taken_away_;
};

/// What the level of a region takes away, which knows what has been pushed in so far.
struct Level {
  double mean = 0, mean_size = 0;
  double operator()(double rate, double pushed_in) {
    mean += fluid::newest_in_mean * (pushed_in - mean);
    mean_size += fluid::newest_in_mean * (std::abs(pushed_in) - mean_size);
    return fluid::level_taken_away(rate, pushed_in, mean_size > 0 ? mean / mean_size : 1);
  }
};

/// Factor by which the motion of a stiff and a slow mode of omega dt = y, y_slow grows in a window, over the last half of 6000 windows.
double growth_by_level(double answers, double y, double slow = 0, double y_slow = 0.01) {
  constexpr int windows = 6000, seen = 1500;
  double before = 0, after = 0;
  Level level;
  const HeldMode mode(y, answers, std::ref(level), slow, y_slow);
  Eigen::Vector<double, 7> q = Eigen::Vector<double, 7>::Zero();
  q[0] = q[5] = 1;
  for (int n = 0; n < windows; ++n) {
    q = mode(q);
    const double energy = y * y * q[0] * q[0] + q[1] * q[1] + (slow > 0 ? y_slow * y_slow * q[5] * q[5] + q[6] * q[6] : 0);
    if (n >= windows / 2 - seen && n < windows / 2) before = std::max(before, energy);
    if (n >= windows - seen) after = std::max(after, energy);
  }
  return after > 1e-60 ? std::pow(after / before, 1. / windows) : 0;
}

/// Largest factor by which a state of one mode grows in a window, from omega dt = 0.001 to 50, ...
double growth_in_enclosed_fluid(double answers, auto&& taken_away) {
  double largest = 0;
  for (double y = 0.001; y < 50; y *= 1.02) largest = std::max(largest, HeldMode(y, answers, taken_away).growth());
  return largest;
}

/// ... and of two modes, each stiff or not for the windows, that share the answer in every proportion: the largest of growth(y, share of
/// the slow one, y_slow).
double growth_of_two_modes(double ratio, auto&& growth) {
  double largest = 0;
  for (const double y_slow : {0.001, 0.01, 0.03, 0.1, 0.2, 0.5, 1.0, 3.0, 3.3})
    for (double y = 1.1 * y_slow; y < 50; y *= ratio)
      for (const double slow : {0.003, 0.03, 0.2, 0.5, 0.8, 0.97}) largest = std::max(largest, growth(y, slow, y_slow));
  return largest;
}

/// Windows by which a mode lags behind the walls, which go on at a constant speed.
double lag_in_enclosed_fluid(double y) {
  Level level;
  const HeldMode mode(y, 1, std::ref(level));
  Eigen::Vector<double, 7> q = Eigen::Vector<double, 7>::Zero();
  double sum = 0;
  for (int n = 0; n < 1000; ++n) {
    q = mode(q, n + 0.5, 1);
    if (n >= 900) sum += n + 1 - q[0];
  }
  return sum / 100;
}

double part_of_the_rate(double rate, double) { return 0.95 * rate; }

// Seen to fail: with all of the rate taken away and half of what has been pushed in (1.4 to 3.0).
TEST(InterfaceVelocity, OfAModeThatEnclosedFluidHoldsDiesOutWhateverItsStiffness) {
  for (const double answers : {0.5, 0.75, 0.9, 1.0, 1.03})
    for (double y = 0.001; y < 50; y *= 1.1) EXPECT_LE(growth_by_level(answers, y) - 1, 1e-8) << answers << ", " << y;
}

// A part of the rate makes of enclosed fluid a spring that several modes hold. A spring feeds no motion. Seen to fail: with 1.05 times the
// rate, a spring that pushes the wrong way.
TEST(InterfaceVelocity, OfSeveralModesThatEnclosedFluidHoldsDoesNotGrow) {
  for (const double answers : {0.5, 0.9, 1.0, 1.03})
    EXPECT_LE(growth_of_two_modes(
                  1.1, [&](double y, double slow, double y_slow) { return HeldMode(y, answers, part_of_the_rate, slow, y_slow).growth(); }),
              1 + 1e-6)
        << answers;
}

// What has been pushed in is an integral, and feeds slow motion, unless only what lasts is given back.
// Seen to fail: with a tenth of all that has been pushed in (1.0019), with 0.65 of the rate (1.0037).
TEST(InterfaceVelocity, OfSeveralModesThatEnclosedFluidHoldsHardlyGrowsByWhatIsGivenBack) {
  const double growth = growth_of_two_modes(1.3, [](double y, double slow, double y_slow) { return growth_by_level(1, y, slow, y_slow); });
  std::printf("[ %.6f a window ]\n", growth);
  EXPECT_LE(growth, 1.0003);
}

// A stiff mode has to be loaded anew in every window, and what a window leaves of it comes back by what has been pushed in.
// Seen to fail: with 0.65 of the rate (10.7 windows), with 0.02 of what lasts in place of 0.1 (7.4).
TEST(InterfaceVelocity, OfAModeThatEnclosedFluidDrivesOnLagsByLessThanAWindow) {
  double largest = 0;
  for (const double y : {0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0}) largest = std::max(largest, std::abs(lag_in_enclosed_fluid(y)));
  std::printf("[ %.2f windows ]\n", largest);
  EXPECT_LT(largest, 0.8);
}

// Why the answer is learnt: more than all of the rate turns the velocity round for ever.
TEST(InterfaceVelocity, WouldTurnRoundForEverInEnclosedFluidIfMoreThanAllOfTheRateWereTakenAway) {
  EXPECT_GT(growth_in_enclosed_fluid(1.1, part_of_the_rate), 1.04);
}

}  // namespace
}  // namespace tern::structure
