// Riemann diffusion: blind to what F sees, opposed to what it does not.

#include <fmt/format.h>
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

  explicit BlockState(double n) : reference(build(n)) {
    state = state_at_rest(reference, 0);
    work = workspace_for(reference);
  }
  static Reference<D> build(double n) {
    StructureCase structure = block<D>(n);
    structure.numerics.riemann_diffusion = 1;
    return build_reference<D>(structure);
  }
  /// Largest force of the diffusion on a particle or in a pair.
  double largest_force() {
    deformation_gradient(reference, state, work);
    diffusion_force(reference, state, work);
    double largest = 0;
    for (const auto* forces : {&state.internal_force, &work.drag})
      for (const auto& axis : *forces)
        for (double f : axis) largest = std::max(largest, std::abs(f));
    return largest;
  }
  /// Power of the diffusion, sum f . v.
  double power() {
    deformation_gradient(reference, state, work);
    diffusion_force(reference, state, work);
    double total = 0;
    for (const auto row : reference.particle_row) total += row_vector<D>(state.internal_force, row).dot(row_vector<D>(state.velocity, row));
    return total;
  }
};

template <int D>
double force_in_an_affine_velocity_field() {
  BlockState<D> s(6);
  Matrix<D> a = Matrix<D>::Constant(0.4);
  a(0, 1) = -1.1;
  set_rows<D>(s.reference, s.state.velocity, [&](const Vector<D>& x) -> Vector<D> { return a * x; });
  return s.largest_force() / (1000 * s.reference.bodies[0].material.pressure_wave_speed());
}

// Seen to fail: without the reconstruction the force is 0.15 of rho c.
TEST(RiemannDiffusion, DoesNotSeeAnAffineVelocityField) {
  EXPECT_LT(force_in_an_affine_velocity_field<2>(), 1e-12);
  EXPECT_LT(force_in_an_affine_velocity_field<3>(), 1e-12);
}

template <int D>
void expect_loss_in_random_velocity_fields(double size, int count) {
  std::mt19937 random(11);
  BlockState<D> s(size);
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
    return e.kinetic + e.strain;
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

/// The body is deformed without order.
template <int D>
void disorder(BlockState<D>& s, std::mt19937& random) {
  set_rows<D>(s.reference, s.state.displacement, [&](const Vector<D>& x) -> Vector<D> {
    return random_vector<D>(random, 0.05) + Vector<D>::Constant(0.02 * x[0] * x[1]) - 0.1 * x;
  });
}

template <int D>
double force_in_a_rigid_motion() {
  BlockState<D> s(5);
  std::mt19937 random(3);
  disorder(s, random);
  Matrix<D> spin = Matrix<D>::Zero();
  spin(0, 1) = -1.1;
  spin(1, 0) = 1.1;
  if (D == 3) spin(D - 1, 0) = -(spin(0, D - 1) = 0.7);
  for (const auto row : s.reference.particle_row) {
    const Vector<D> v = Vector<D>::Constant(0.3) + spin * (s.reference.position_of(row) + row_vector<D>(s.state.displacement, row));
    for (int a = 0; a < D; ++a) s.state.velocity[a][row] = v[a];
  }
  return s.largest_force() / (1000 * s.reference.bodies[0].material.pressure_wave_speed());
}

// Seen to fail: with the reconstruction in the reference configuration, v_j - v_i - (L_i + L_j)/2 X_ji (0.2 of rho c).
TEST(RiemannDiffusion, DoesNotSeeARigidMotionOfADeformedBody) {
  EXPECT_LT(force_in_a_rigid_motion<2>(), 1e-12);
  EXPECT_LT(force_in_a_rigid_motion<3>(), 1e-12);
}

template <int D>
void expect_no_force_and_no_moment() {
  BlockState<D> s(5);
  std::mt19937 random(7);
  disorder(s, random);
  set_rows<D>(s.reference, s.state.velocity, [&](const Vector<D>&) { return random_vector<D>(random, 1.0); });
  const double size = s.largest_force();
  const auto [force, moment] = force_and_moment(s.reference, s.state);
  EXPECT_LT(force.norm(), 1e-11 * size);
  EXPECT_LT(moment.norm(), 1e-11 * size);
}

// Seen to fail: without the stress that the reconstruction answers with (0.13 of the largest force in 2D, 1 in 3D).
TEST(RiemannDiffusion, OfARandomMotionHasNoResultantAndNoMoment) {
  expect_no_force_and_no_moment<2>();
  expect_no_force_and_no_moment<3>();
}

/// What is lost of the angular momentum of a free body that spins fast, from no strain on.
template <int D>
double lost_angular_momentum(double n, int windows) {
  StructureBody b = body("block", {-0.5 * n, -0.5 * n, -0.5 * n}, {0.5 * n, 0.5 * n, 0.5 * n}, 1);
  const double spin = 16 / n;  // [rad/s]: the faces move at a quarter of the speed of pressure waves
  b.velocity[0] = Expression(fmt::format("{}*y", -spin));
  b.velocity[1] = Expression(fmt::format("{}*x", spin));
  if (D == 3) b.velocity[2] = Expression("2*sin(3*x)*cos(2*y)");
  Structure<D> structure(scene(D, {b}));
  const Momentum before = structure.momentum();
  for (int k = 0; k < windows; ++k) structure.trial(structure.time(), to_ticks(10 * structure.largest_sub_step()));
  const Momentum after = structure.momentum();
  EXPECT_GT(structure.energies().diffusion, 1e-3 * structure.energies().kinetic) << "the diffusion does work";
  double squared = 0;
  for (int a = 0; a < 3; ++a) squared += std::pow(after.angular[a] - before.angular[a], 2);
  return std::sqrt(squared) / std::abs(before.angular[2]);
}

// Seen to fail: without the stress of the reconstruction (2.3e-4 in 2D, 2.7e-4 in 3D; with a limiter beside it 0.03 and 0.04).
TEST(RiemannDiffusion, LeavesTheAngularMomentumOfAFreeBodyAlone) {
  EXPECT_LT(lost_angular_momentum<2>(10, 100), 1e-12);
  EXPECT_LT(lost_angular_momentum<3>(6, 40), 1e-12);
}

/// A block that is clamped at its foot, where the reconstruction of the particles on the face has its share.
Reference<2> clamped_block() {
  StructureCase structure = block<2>(6);
  structure.bodies[0].clamps = {box({-1, -1, 0}, {7, 2, 0})};
  return build_reference<2>(structure);
}

// Pairs whose reconstruction overshoots, a kink, a wave of four particles, and a clamp: the power is that of the jumps, so that no pair
// gains. Seen to fail: with the stress of the reconstruction left out, and with that of the particles on a face left out.
TEST(RiemannDiffusion, TakesWhatItsPairsLose) {
  BlockState<2> s(12);
  std::mt19937 random(13);
  disorder(s, random);
  set_rows<2>(s.reference, s.state.velocity, [](const Vector<2>& x) { return Vector<2>(std::sin(1.6 * x[0]), std::abs(x[0] - 6)); });
  const auto expect_balance = [](const Reference<2>& reference, State<2>& state, Workspace<2>& work) {
    deformation_gradient(reference, state, work);
    diffusion_force(reference, state, work);
    double power = 0, loss = 0;
    for (const auto row : reference.particle_row) power += row_vector<2>(state.internal_force, row).dot(row_vector<2>(state.velocity, row));
    for (const auto& block : state.diffusion_power) loss += sum(block);
    EXPECT_NEAR(-power, loss, 1e-12 * loss);
    EXPECT_GT(loss, 0);
  };
  expect_balance(s.reference, s.state, s.work);
  const auto reference = clamped_block();
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  set_rows<2>(reference, state.velocity,
              [&](const Vector<2>& x) -> Vector<2> { return x[1] < 2 ? Vector<2>(0.1, 0) : random_vector<2>(random, 1.0); });
  expect_balance(reference, state, work);
}

// The loss that is counted is what the kick takes from the kinetic energy, in one kick as in two. Seen to fail: with pairs counted twice,
// and with the velocity of the begin of the kick instead of that of its middle.
TEST(RiemannDiffusion, CountsTheEnergyItTakes) {
  BlockState<2> s(6);
  std::mt19937 random(5);
  set_rows<2>(s.reference, s.state.velocity, [&](const Vector<2>&) { return random_vector<2>(random, 1.0); });
  constexpr double dt = 2e-3;
  evaluate(s.reference, s.state, s.work);
  const auto kinetic = [&] { return energies_of(s.reference, s.state, s.work).kinetic; };
  const double before = kinetic();
  kick(s.reference, 0.3 * dt, s.state);
  kick(s.reference, 0.7 * dt, s.state);
  double loss = 0;
  for (const auto& block : s.state.diffusion_loss) loss += sum(block);
  EXPECT_NEAR(loss, before - kinetic(), 1e-12 * loss);
  EXPECT_GT(loss, 0.05 * before);
}

}  // namespace
}  // namespace tern::structure::testing
