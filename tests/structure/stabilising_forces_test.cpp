// Riemann diffusion and hourglass penalty: blind to what F sees, opposed to what it does not.

#include <gtest/gtest.h>

#include "fixtures/structure_scenes.hpp"
#include "structure/energy.hpp"

namespace tern::structure::testing {
namespace {

template <int D>
struct BlockState {
  Reference<D> reference;
  State<D> state;
  Workspace<D> work;

  BlockState(double n, double diffusion, double penalty) : reference(build(n, diffusion, penalty)) {
    state = state_at_rest(reference, 0);
    work = workspace_for(reference);
  }
  static Reference<D> build(double n, double diffusion, double penalty) {
    StructureCase structure = block<D>(n);
    structure.numerics.riemann_diffusion = diffusion;
    structure.numerics.hourglass_penalty = penalty;
    return build_reference<D>(structure);
  }
  /// Largest stabilising force in a pair.
  double largest_pair_force() {
    deformation_gradient(reference, state, work);
    stabilising_forces(reference, 0, state, work);
    double largest = 0;
    for (const auto& axis : work.pair_force)
      for (double f : axis) largest = std::max(largest, std::abs(f));
    return largest;
  }
  /// Power of the diffusion, sum f . v.
  double power() {
    evaluate(reference, state, work);
    double total = 0;
    for (const auto row : reference.particle_row) total += row_vector<D>(state.internal_force, row).dot(row_vector<D>(state.velocity, row));
    return total;
  }
};

template <int D>
double force_in_an_affine_velocity_field() {
  BlockState<D> s(6, 1, 0);
  Matrix<D> a = Matrix<D>::Constant(0.4);
  a(0, 1) = -1.1;
  set_rows<D>(s.reference, s.state.velocity, [&](const Vector<D>& x) -> Vector<D> { return a * x; });
  return s.largest_pair_force() / (1000 * s.reference.bodies[0].material.pressure_wave_speed());
}

// Seen to fail: without the reconstruction the force is 0.15 of rho c.
TEST(RiemannDiffusion, DoesNotSeeAnAffineVelocityField) {
  EXPECT_LT(force_in_an_affine_velocity_field<2>(), 1e-12);
  EXPECT_LT(force_in_an_affine_velocity_field<3>(), 1e-12);
}

template <int D>
void expect_loss_in_random_velocity_fields(double size, int count) {
  std::mt19937 random(11);
  BlockState<D> s(size, 1, 0);
  for (int n = 0; n < count; ++n) {
    set_rows<D>(s.reference, s.state.velocity, [&](const Vector<D>&) { return random_vector<D>(random, 1.0); });
    EXPECT_LT(s.power(), 0) << "seed 11, field " << n;
  }
}

// Seen to fail: with the opposite sign of the jump every power is positive.
TEST(RiemannDiffusion, TakesEnergyFromEveryRandomVelocityField) {
  expect_loss_in_random_velocity_fields<2>(6, 100);
  expect_loss_in_random_velocity_fields<3>(5, 20);
}

/// Largest rise of the energy of a body that is let go with a rough velocity field, over its energy at the start;
/// looked at after every window of `sub_steps` steps.
template <int D>
double largest_energy_rise(double n, int windows, int sub_steps) {
  StructureBody b = body("block", {0, 0, 0}, {n, n + 1, n}, 1);
  b.velocity[0] = Expression("sin(2*x)+0.1*y");
  b.velocity[1] = Expression("cos(3*y)-0.1*x+sin(x*y)");
  b.velocity[2] = Expression("sin(3*z)*cos(x)");
  Structure<D> structure(scene(D, {b}));
  const auto energy = [&] {
    const Energies e = structure.energies();
    return e.kinetic + e.strain + e.penalty;
  };
  const double at_start = energy();
  double lowest = at_start, rise = 0;
  Ticks now = 0;
  for (int k = 0; k < windows; ++k) {
    const Ticks window = to_ticks(sub_steps * structure.largest_sub_step());
    structure.trial(now, window);
    now += window;
    rise = std::max(rise, energy() - lowest);
    lowest = std::min(lowest, energy());
  }
  EXPECT_LT(lowest, 0.9 * at_start);  // the diffusion does work
  return rise / at_start;
}

// Seen to fail: with the diffusion reversed the body bursts.
TEST(RiemannDiffusion, NeverLetsTheEnergyOfAFreeBodyRise) {
  EXPECT_LT(largest_energy_rise<2>(10, 200, 10), 1e-4);
  EXPECT_LT(largest_energy_rise<3>(5, 100, 10), 1e-4);
}

// The limiter works per pair, so even a field whose reconstruction overshoots everywhere must not gain energy: a kink, and
// a smooth wave of four particles. Seen to fail: without the limiter of
// the normal part, and without that of the tangential part.
TEST(RiemannDiffusion, LetsNoPairGainEnergy) {
  BlockState<2> s(12, 1, 0);
  set_rows<2>(s.reference, s.state.velocity, [](const Vector<2>& x) { return Vector<2>(std::sin(1.6 * x[0]), std::abs(x[0] - 6)); });
  evaluate(s.reference, s.state, s.work, 1e-9);
  for (std::size_t n = 0; n < s.reference.blocks.size(); ++n) EXPECT_GT(sum(s.state.diffusion_loss[n]), -1e-14) << "block " << n;
}

// The loss that is counted is what the kick takes from the kinetic energy. Seen to fail: with pairs counted twice, and with the
// velocity of the begin of the kick instead of that of its middle.
TEST(RiemannDiffusion, CountsTheEnergyItTakes) {
  BlockState<2> s(6, 1, 0);
  std::mt19937 random(5);
  set_rows<2>(s.reference, s.state.velocity, [&](const Vector<2>&) { return random_vector<2>(random, 1.0); });
  constexpr double dt = 2e-3;
  evaluate(s.reference, s.state, s.work, dt);
  const auto kinetic = [&] { return energies_of(s.reference, s.state, s.work).kinetic; };
  const double before = kinetic();
  kick(s.reference, s.work, dt, s.state);
  double loss = 0;
  for (const auto& block : s.state.diffusion_loss) loss += sum(block);
  EXPECT_NEAR(loss, before - kinetic(), 1e-12 * loss);
  EXPECT_GT(loss, 0.05 * before);
}

template <int D>
double penalty_in_an_affine_deformation() {
  BlockState<D> s(6, 0, 0.05);
  Matrix<D> a = Matrix<D>::Constant(0.1);
  a(0, 1) = -0.2;
  set_rows<D>(s.reference, s.state.displacement, [&](const Vector<D>& x) -> Vector<D> { return a * x; });
  return s.largest_pair_force() / 1e6;
}

// Seen to fail: with X_ji instead of F X_ji the penalty resists the deformation (8e-4 of E).
TEST(HourglassPenalty, DoesNotSeeAnAffineDeformation) {
  EXPECT_LT(penalty_in_an_affine_deformation<2>(), 1e-14);
  EXPECT_LT(penalty_in_an_affine_deformation<3>(), 1e-14);
}

// A checkerboard is invisible to F inside the body. Seen to fail: with the opposite sign the pattern is driven.
TEST(HourglassPenalty, PushesACheckerboardBack) {
  BlockState<2> s(8, 0, 0.05);
  set_rows<2>(s.reference, s.state.displacement, [](const Vector<2>& x) {
    const bool odd = (static_cast<int>(x[0]) + static_cast<int>(x[1])) % 2;
    return Vector<2>(odd ? 0.02 : -0.02, 0.0);
  });
  deformation_gradient(s.reference, s.state, s.work);
  stabilising_forces(s.reference, 0, s.state, s.work);
  double along = 0;
  for (const auto row : s.reference.particle_row) along += s.state.internal_force[0][row] * s.state.displacement[0][row];
  EXPECT_LT(along, -1.0);
}

}  // namespace
}  // namespace tern::structure::testing
