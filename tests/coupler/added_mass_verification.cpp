// A column of water on a rigid piston of mass m_s per area, between slip walls. Exact: the water adds m_a = rho h to the
// piston; with a spring k per area omega^2 = k/(m_s + m_a). Explicit coupling multiplies the acceleration by -M = -m_a/m_s
// every step, whatever its length, and so cannot work for M > 1 (Causin, Gerbeau & Nobile 2005). Predict-project-correct
// must work for every M.

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "base/error.hpp"
#include "coupler/window.hpp"
#include "fixtures/interface_scenes.hpp"
#include "fluid/fluid.hpp"

namespace tern::coupler::testing {
namespace {

constexpr double dx = 0.01, rho = 1000;

/// Rigid horizontal lid under the water that moves along y on a spring; exact over a window of constant load.
class Piston {
 public:
  Piston(double width, double mass, double stiffness, double velocity, CouplingAlgorithm algorithm)
      : points_(static_cast<int>(std::lround(width / point_spacing))),
        width_(width),
        mass_(mass),
        stiffness_(stiffness),
        algorithm_(algorithm),
        velocity_(velocity) {
    load_.force.assign(points_, Vector<2>::Zero());
  }

  Surface<2> predict_surface(Ticks, Ticks duration) {
    duration_ = seconds(duration);
    saved_height_ = height_;
    saved_velocity_ = velocity_;
    if (algorithm_ == CouplingAlgorithm::explicit_staggering) return surface_at(height_ + duration_ * velocity_);
    move(load_);
    return surface_at(height_);
  }

  std::vector<Vector<2>> respond(const SurfaceLoad<2>& load) {
    apply(load);
    return surface_at(height_).velocity;
  }

  void apply(const SurfaceLoad<2>& load) {
    height_ = saved_height_;
    velocity_ = saved_velocity_;
    load_ = load;
    move(load_);
  }

  SurfaceProperties properties() const { return testing::properties(points_, mass_); }
  double height() const { return height_; }
  double velocity() const { return velocity_; }
  /// Of the water on the piston, in the last window [Pa].
  double pressure() const {
    double force = 0;
    for (const auto& f : load_.force) force -= f[1];
    return force / width_;
  }
  /// Force per area that no spring gives, e.g. weight and preload [Pa].
  double constant_pressure = 0;

 private:
  static constexpr double point_spacing = 0.5 * dx;

  Surface<2> surface_at(double height) const {
    Surface<2> surface;
    for (int k = 0; k < points_; ++k)
      add_point<2>(surface, {(k + 0.5) * point_spacing, height}, {0.0, 1.0}, point_spacing, {0.0, velocity_});
    return surface;
  }

  void move(const SurfaceLoad<2>& load) {
    double pressure = constant_pressure;
    for (const auto& f : load.force) pressure += f[1] / width_;
    if (stiffness_ == 0) {
      height_ += duration_ * (velocity_ + 0.5 * duration_ * pressure / mass_);
      velocity_ += duration_ * pressure / mass_;
      return;
    }
    const double omega = std::sqrt(stiffness_ / mass_), rest = pressure / stiffness_;
    const double c = std::cos(omega * duration_), s = std::sin(omega * duration_), a = height_ - rest, v = velocity_;
    height_ = rest + a * c + v / omega * s;
    velocity_ = v * c - a * omega * s;
  }

  int points_;
  double width_, mass_, stiffness_;
  CouplingAlgorithm algorithm_;
  double height_ = 0, velocity_, saved_height_ = 0, saved_velocity_ = 0, duration_ = 0;
  SurfaceLoad<2> load_;
};

struct Column {
  int across = 10, high = 20;  ///< in dx
  double mass_ratio = 1;       ///< M = rho h/m_s
  double gravity = 0;
  double stiffness = 0;  ///< k per area [Pa/m]
  double piston_velocity = 0, water_velocity = 0;
  double step = 1e-3;
  Coupling coupling = Coupling::one_pass;
  InterfaceScheme scheme = InterfaceScheme::riemann;
  double riemann_limiter = 3;
  double robin_mass_factor = 1;
  std::optional<double> tolerance;

  double added_mass() const { return rho * high * dx; }
  double piston_mass() const { return added_mass() / mass_ratio; }
};

struct History {
  std::vector<double> height, velocity, pressure, water_velocity;
  bool failed = false;  ///< ended by an error of the fluid or the coupler

  double largest_velocity() const {
    double largest = 0;
    for (double v : velocity) largest = std::max(largest, std::abs(v));
    return failed ? 1e300 : largest;
  }
};

History run(const Column& column, int windows) {
  const double width = column.across * dx, height = column.high * dx;
  Case c = scene(2, dx);
  c.gravity = constant(0, -column.gravity);
  WallCase walls;
  walls.name = "walls";
  walls.container = true;
  walls.shape = box({0, -0.5 * height, 0}, {width, 2 * height, 0});
  walls.open = {"y_min", "y_max"};
  c.walls.push_back(walls);
  FluidBody water;
  water.shape = box({0, 0, 0}, {width, height, 0});
  water.velocity = constant(0, column.water_velocity);
  c.fluid->bodies.push_back(water);
  choose(column.coupling, c.coupling);
  c.coupling.scheme = column.scheme;
  c.coupling.riemann_limiter = column.riemann_limiter;
  if (column.tolerance) c.coupling.tolerance = column.tolerance;
  c.coupling.robin_mass_factor = column.robin_mass_factor;

  Piston piston(width, column.piston_mass(), column.stiffness, column.piston_velocity, c.coupling.algorithm);
  piston.constant_pressure = column.gravity * column.added_mass();  // the piston starts at rest under the water
  fluid::Fluid<2> fluid(c);
  Coupler<2> coupler(c, piston.properties());
  History history;
  const Ticks duration = to_ticks(column.step);
  try {
    for (int n = 0; n < windows; ++n) {
      run_window<2>(fluid, piston, coupler, n * duration, duration);
      history.height.push_back(piston.height());
      history.velocity.push_back(piston.velocity());
      history.pressure.push_back(piston.pressure());
      history.water_velocity.push_back(fluid.momentum()[1] / (width * column.added_mass()));
    }
  } catch (const NumericalFailure&) {
    history.failed = true;
  }
  return history;
}

double mean(const std::vector<double>& values, std::size_t first) {
  double sum = 0;
  for (std::size_t n = first; n < values.size(); ++n) sum += values[n];
  return sum / static_cast<double>(values.size() - first);
}

double range(const std::vector<double>& values, std::size_t first, std::size_t count) {
  const auto [low, high] = std::minmax_element(values.begin() + first, values.begin() + first + count);
  return *high - *low;
}

/// A column without gravity whose piston is pushed upwards once.
History pushed(double mass_ratio, Coupling coupling, double push, double robin_mass_factor = 1,
               InterfaceScheme scheme = InterfaceScheme::riemann, double tolerance = 1e-4) {
  Column column;
  column.scheme = scheme;
  column.tolerance = tolerance;
  column.mass_ratio = mass_ratio;
  column.coupling = coupling;
  column.piston_velocity = push;
  column.robin_mass_factor = robin_mass_factor;
  return run(column, 100);
}

/// Change of the piston's velocity in a window.
double jump(const History& h, std::size_t n) { return h.velocity[n] - h.velocity[n - 1]; }

/// True when the change of velocity per window grows from window 20 to the end; the push is so small that nothing but the
/// coupling decides.
bool grows(const History& h) { return h.failed || std::abs(jump(h, h.velocity.size() - 1)) > std::abs(jump(h, 20)); }

// Seen to fail: with the Robin condition set for explicit coupling too.
TEST(AddedMass, ExplicitCouplingHoldsForAHeavyPistonAndRunsAwayForALightOne) {
  constexpr double push = 1e-9;
  for (const auto& [scheme, key, meaning] : interface_schemes) {
    const auto heavy = pushed(0.3, Coupling::explicit_staggering, push, 1, scheme);
    EXPECT_LE(heavy.largest_velocity(), push);
    EXPECT_NEAR(heavy.velocity.back() / push, 1 / 1.3, 0.03);
  }
  const auto light = pushed(2, Coupling::explicit_staggering, push);
  const std::size_t windows = light.velocity.size();  // until the load that turns round is noticed
  ASSERT_GT(windows, 10u);
  EXPECT_TRUE(light.failed);
  EXPECT_GT(std::abs(jump(light, windows - 1)), 1e3 * push);
  for (std::size_t n = 2; n < std::min<std::size_t>(windows, 20); ++n)
    EXPECT_LT(jump(light, n) * jump(light, n - 1), 0) << "alternates, window " << n;
}

// One particle of fluid is smeared over the face, so the threshold need not be M = 1 to the last per cent.
// Seen to fail: with the Robin condition set for explicit coupling too.
TEST(AddedMass, ExplicitCouplingTurnsUnstableNearEqualMasses) {
  double onset = 0.5;
  while (onset < 2 && !grows(pushed(onset, Coupling::explicit_staggering, 1e-9))) onset += 0.05;
  EXPECT_GT(onset, 0.7);
  EXPECT_LE(onset, 1.5);
  std::printf("[ onset of the instability of explicit coupling at M = %.2f ]\n", onset);
}

// Seen to fail: with the reference pressure left at zero.
TEST(AddedMass, APushedPistonAndItsWaterMoveOnTogetherAtTheSharedMomentum) {
  constexpr double push = 0.1;
  for (const auto& [scheme, key, meaning] : interface_schemes)
    for (double m : {0.5, 2.0, 5.0, 20.0, 100.0}) {
      Column column;
      column.mass_ratio = m;
      column.scheme = scheme;
      column.piston_velocity = push;
      const auto history = run(column, 100);
      ASSERT_FALSE(history.failed) << "M " << m;
      EXPECT_LE(history.largest_velocity(), push) << "M " << m;
      const double shared = push / (1 + m), piston = mean(history.velocity, 80), water = mean(history.water_velocity, 80);
      // With "fsa" the velocity of so light a piston jumps to several times this one now and then.
      EXPECT_NEAR(piston / shared, 1, scheme == InterfaceScheme::fsa && m == 100 ? 0.03 : 0.02) << "M " << m;
      EXPECT_NEAR(water / shared, 1, 0.02) << "M " << m;
      std::printf("[ M %5.1f: piston %.4f, water %.4f of the shared velocity ]\n", m, piston / shared, water / shared);
    }
}

// Lumped model of a window, loads as impulses: the fluid solves P' (1/m_a + 1/m_p) = e + P (1/m_p - 1/m_s) for the mismatch e
// of the velocities, the piston then leaves e' = e - P' (1/m_s + 1/m_a). m_p = m_s leaves none; an eigenvalue passes -1 at
// m_p/m_s = 4/(3 - m_s/m_a), which is 4/3 for a light piston. Measured: 1.37 at M 100, 1.41 at 20, 1.5 at 5, 1.75 at 2.
// Seen to fail: with the factor left out; with the reference pressure left at zero.
TEST(AddedMass, BearsARobinMassUpToFourThirdsOfTheMassOfALightPiston) {
  constexpr double push = 1e-9;
  for (const auto& [scheme, key, meaning] : interface_schemes)
    for (double m : scheme == InterfaceScheme::riemann ? std::vector<double>{2, 20, 100} : std::vector<double>{20}) {
      SCOPED_TRACE("scheme " + std::to_string(static_cast<int>(scheme)) + ", M " + std::to_string(m));
      const double onset = 4 / (3 - 1 / m);
      for (double part : {0.25, 0.5, 0.9})
        EXPECT_LE(pushed(m, Coupling::one_pass, push, part * onset, scheme).largest_velocity(), push) << part;
      EXPECT_GT(pushed(m, Coupling::one_pass, push, 1.2 * onset, scheme).largest_velocity(), 1e3 * push);
    }
}

// Seen to fail: with the fluid left in the state of the first trial; with the surface's new velocity not told to the fluid.
TEST(AddedMass, RepeatedWindowsHoldAPistonOfAnyLightnessToTheSharedMomentum) {
  constexpr double push = 0.1;
  for (double m : {0.5, 20.0, 1000.0}) {
    // Of a piston of a thousandth of the mass of its water the default tolerance of the load is two fifths of the velocity in some windows.
    const auto h = pushed(m, Coupling::repeated, push, 1, InterfaceScheme::riemann, m > 100 ? 1e-6 : 1e-4);
    ASSERT_FALSE(h.failed) << "M " << m;
    const double expected = push / (1 + m);
    for (std::size_t n : {std::size_t{5}, std::size_t{99}}) {
      EXPECT_NEAR(h.velocity[n] / expected, 1, 0.03) << "M " << m << ", window " << n;
      EXPECT_NEAR(h.water_velocity[n] / expected, 1, 0.03) << "M " << m << ", window " << n;
    }
    std::vector<double> sorted(h.velocity.begin() + 5, h.velocity.end());
    std::nth_element(sorted.begin(), sorted.begin() + 47, sorted.end());
    EXPECT_NEAR(sorted[47] / expected, 1, 0.02) << "M " << m << ", median";
    std::printf("[ M %6.1f: piston %.4f, water %.4f of the expected velocity after six windows, piston in the median %.4f ]\n", m,
                h.velocity[5] / expected, h.water_velocity[5] / expected, sorted[47] / expected);
  }
}

/// Static load as a fraction of the weight of the water, on a stiff spring.
double static_load(int across) {
  Column column;
  column.across = across;
  column.gravity = 9.81;
  column.stiffness = std::pow(2 * std::numbers::pi / 0.05, 2) * (column.piston_mass() + column.added_mass());
  const auto history = run(column, 600);
  return history.failed ? 0 : mean(history.pressure, 300) / (9.81 * column.added_mass());
}

// Without the images of the fluid behind the walls each corner loses 0.278 dx of its face: 0.945 and 0.972 of the weight.
// Measured: 0.997 and 0.999.
// Seen to fail: without images; with the weight between particle and face subtracted from the pressure instead of added.
TEST(AddedMass, TheLoadAtRestIsTheWeightOfTheWaterUpToTheCorners) {
  for (int across : {10, 20}) {
    const double load = static_load(across);
    EXPECT_NEAR(load, 1, 5e-3) << across << " dx wide";
    std::printf("[ %d dx: load %.4f of the weight ]\n", across, load);
  }
}

// Measured: 0.9989 to 1.0012 of the exact period. With patches of the walls that vanish and appear whole where the piston passes
// them: 1.015 to 1.054, and a third to two thirds of the swing left after three periods. Without images: 0.978 to 0.993.
// Seen to fail: with walls that are not clipped; without images.
TEST(AddedMass, ShowsInThePeriodOfAPistonOnASpring) {
  struct Sample {
    int across;
    double mass_ratio;
  };
  for (const auto& [across, m] : {Sample{10, 0.5}, {10, 5}, {10, 20}, {20, 5}}) {
    Column column;
    column.across = across;
    column.mass_ratio = m;
    column.gravity = 9.81;
    constexpr double exact = 0.25, omega = 2 * std::numbers::pi / exact;
    constexpr int per_period = 250, periods = 6;
    column.stiffness = omega * omega * (column.piston_mass() + column.added_mass());
    column.piston_velocity = column.water_velocity = 0.05;
    const auto h = run(column, periods * per_period);
    ASSERT_FALSE(h.failed);
    const double middle = mean(h.height, 0);
    std::vector<double> crossings;  // upwards through the mean height
    for (std::size_t n = 1; n < h.height.size(); ++n)
      if (h.height[n - 1] < middle && h.height[n] >= middle)
        crossings.push_back(static_cast<double>(n) - (h.height[n] - middle) / (h.height[n] - h.height[n - 1]));
    ASSERT_GE(crossings.size(), 5u);
    const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1) * column.step;
    EXPECT_NEAR(period / exact, 1, 5e-3) << across << " dx wide, M " << m;
    // A spring without any loss, and the lag of one pass: at M 20 and 250 windows a period the swing grows by 1.5 % a period, with
    // 500 it falls. (The structure proper gives the fluid another velocity, coupled_structure.hpp.)
    const double second = range(h.height, per_period, per_period), last = range(h.height, (periods - 1) * per_period, per_period);
    EXPECT_NEAR(last / second, 1, m > 10 ? 0.15 : 0.05) << across << " dx wide, M " << m;
    std::printf("[ %d dx, M %4.1f: period %.4f of the exact one, swing %.2f of that of the second in the sixth ]\n", across, m,
                period / exact, last / second);
  }
}

}  // namespace
}  // namespace tern::coupler::testing
