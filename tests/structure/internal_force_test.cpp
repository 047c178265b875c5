// The internal force is the exact negative gradient of the strain energy and conserves both momenta.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "fixtures/structure_scenes.hpp"
#include "structure/energy.hpp"

namespace tern::structure::testing {
namespace {

constexpr unsigned seed = 3;

template <int D>
double strain_energy(const Reference<D>& reference, const State<D>& state, Workspace<D>& work) {
  deformation_gradient(reference, state, work);
  return energies_of(reference, state, work).strain;
}

/// Largest |f + dE/dx| over a sample of particles, relative to the largest |f|.
template <int D>
double gradient_error(StructureCase structure) {
  structure.numerics.riemann_diffusion = 0;
  const auto reference = build_reference<D>(structure);
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  std::mt19937 random(seed);
  set_rows<D>(reference, state.displacement, [&](const Vector<D>&) { return random_vector<D>(random, 0.03); });
  evaluate(reference, state, work);
  double largest = 0, error = 0;
  const double step = 1e-4;
  for (std::size_t p = 0; p < reference.particle_row.size(); p += 3) {
    const auto row = reference.particle_row[p];
    for (int a = 0; a < D; ++a) {
      double& d = state.displacement[a][row];
      const double at = d, force = state.internal_force[a][row];
      // Fourth-order difference, so that neither truncation nor round-off reaches the bound.
      const double weights[] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
      double slope = 0;
      for (int k = 0; k < 4; ++k) {
        d = at + step * (k < 2 ? k - 2 : k - 1);
        slope += weights[k] * strain_energy(reference, state, work) / step;
      }
      d = at;
      largest = std::max(largest, std::abs(force));
      error = std::max(error, std::abs(force + slope));
    }
  }
  return error / largest;
}

// Seen to fail: with g_ij in place of g_ji in the second term the error is 1.6; with the opposite sign, 2.
TEST(InternalForce, IsTheNegativeGradientOfTheStrainEnergy) {
  EXPECT_LT(gradient_error<2>(block<2>(6)), 1e-8) << "seed " << seed;
  EXPECT_LT(gradient_error<3>(block<3>(4)), 1e-8) << "seed " << seed;
}

// Seen to fail: without the quadratic term of the strain of St Venant-Kirchhoff together with F33 of plane stress held at 1, and
// without the part of the strain gradient in P and Q.
TEST(InternalForce, IsTheNegativeGradientOfTheStrainEnergyForEveryMaterial) {
  for (const std::string& law : material_keys()) {
    for (const bool plane_stress : {false, true}) {
      StructureCase structure = block<2>(6);
      structure.bodies[0].material = law;
      structure.bodies[0].plane_stress = plane_stress;
      EXPECT_LT(gradient_error<2>(structure), 1e-8) << law << ", seed " << seed;
    }
    StructureCase structure = block<3>(4);
    structure.bodies[0].material = law;
    EXPECT_LT(gradient_error<3>(structure), 1e-8) << law << ", seed " << seed;
  }
}

/// A block with a region clamped in its middle: faces, edges and corners of a clamp.
template <int D>
StructureCase pinned_block(double n) {
  StructureCase structure = block<D>(n);
  structure.bodies[0].clamps = {box({-1, -1, -1}, {n / 2, n / 2 - 0.6, n / 2})};
  return structure;
}

// Also what the clamp feels is the gradient, at its face particles. Seen to fail: with energy in the face particles.
TEST(InternalForce, IsTheNegativeGradientOfTheStrainEnergyBesideAClamp) {
  EXPECT_LT(gradient_error<2>(pinned_block<2>(8)), 1e-8) << "seed " << seed;
  EXPECT_LT(gradient_error<3>(pinned_block<3>(6)), 1e-8) << "seed " << seed;
}

/// A ball: lattice lines of every length, blocks of four that begin and end anywhere.
template <int D>
StructureCase ball() {
  StructureBody b = body("ball", {}, {}, 1.0);
  b.shape.kind = Shape::Kind::ball;
  b.shape.radius = D == 2 ? 7.3 : 4.3;
  return *scene(D, {b}).structure;
}

// Seen to fail: as above; the error is 4.2.
TEST(InternalForce, IsTheNegativeGradientOfTheStrainEnergyInABall) { EXPECT_LT(gradient_error<2>(ball<2>()), 1e-8) << "seed " << seed; }

/// A free body of so many particles along its sides, of unit spacing.
template <int D>
StructureCase brick(std::array<double, 3> sides) {
  return *scene(D, {body("brick", {0, 0, 0}, sides, 1.0)}).structure;
}

/// Fewer than three layers in one, two and three directions.
const std::array<double, 3> thin[] = {{6, 5, 2}, {2, 6, 2}, {2, 2, 2}};

// Seen to fail: without what is added to P (errors from 0.013 on), without what is added to Q (from 0.033), and with amplitudes of K in
// place of those of G^-1 K (from 0.01).
TEST(InternalForce, IsTheNegativeGradientOfTheStrainEnergyInTwoLayers) {
  for (const std::string& law : material_keys()) {
    for (const bool plane_stress : {false, true}) {
      StructureCase structure = brick<2>({7, 2, 0});
      structure.bodies[0].material = law;
      structure.bodies[0].plane_stress = plane_stress;
      EXPECT_LT(gradient_error<2>(structure), 1e-8) << law << ", seed " << seed;
    }
    for (const auto& sides : thin) {
      StructureCase structure = brick<3>(sides);
      structure.bodies[0].material = law;
      EXPECT_LT(gradient_error<3>(structure), 1e-8) << law << ", seed " << seed;
    }
  }
}

template <int D>
void expect_no_net_force(const StructureCase& structure) {
  const auto reference = build_reference<D>(structure);
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  std::mt19937 random(seed);
  set_rows<D>(reference, state.displacement, [&](const Vector<D>&) { return random_vector<D>(random, 0.03); });
  set_rows<D>(reference, state.velocity, [&](const Vector<D>&) { return random_vector<D>(random, 1.0); });
  evaluate(reference, state, work);
  double total = 0;
  for (const auto row : reference.particle_row) total += row_vector<D>(state.internal_force, row).norm();
  const auto [force, moment] = force_and_moment(reference, state);
  EXPECT_GT(total, 0);
  EXPECT_LT(force.norm(), 1e-12 * total) << "seed " << seed;
  // Riemann diffusion is antisymmetric but not central: its moment is checked apart, without it.
  if (structure.numerics.riemann_diffusion == 0) {
    EXPECT_LT(moment.norm(), 1e-11 * total) << "seed " << seed;
  }
}

// Seen to fail: with the pair forces added at one end only, and, for the balls, with lines not separated by empty rows.
TEST(InternalForce, HasNoNetForceAndNoNetMoment) {
  for (double diffusion : {0.0, 1.0})
    for (StructureCase structure : {block<2>(6), ball<2>(), brick<2>({7, 2, 0})}) {
      structure.numerics.riemann_diffusion = diffusion;
      expect_no_net_force<2>(structure);
    }
  for (double diffusion : {0.0, 1.0})
    for (StructureCase structure : {block<3>(5), ball<3>(), brick<3>(thin[0]), brick<3>(thin[1])}) {
      structure.numerics.riemann_diffusion = diffusion;
      expect_no_net_force<3>(structure);
    }
}

/// A body that turns, stretches and vibrates freely, without diffusion: `steps` sub-steps in windows of 100.
/// Returns the drift of linear and of angular momentum over sum m |v| and sum m |x| |v|.
template <int D>
std::pair<double, double> momentum_drift(std::array<double, 3> sides, int steps) {
  StructureBody b = body("block", {0, 0, 0}, sides, 1);
  b.velocity[0] = Expression("3-6*(y-2)+sin(2*x)");
  b.velocity[1] = Expression("1+6*(x-2)+cos(3*y)");
  b.velocity[2] = Expression("0.5+2*(x-2)");
  Case c = scene(D, {b});
  c.structure->numerics.riemann_diffusion = 0;
  Structure<D> structure(c);
  const Momentum before = structure.momentum();
  const auto fields = structure.fields();
  const double mass = 1000;  // per particle
  double linear_scale = 0, angular_scale = 0;
  for (std::size_t p = 0; p < fields.velocity.size(); ++p) {
    linear_scale += mass * fields.velocity[p].norm();
    angular_scale += mass * fields.velocity[p].norm() * fields.position[p].norm();
  }
  Ticks now = 0;
  for (int done = 0; done < steps; done += structure.sub_steps()) {
    const Ticks window = to_ticks(100 * structure.largest_sub_step());
    structure.trial(now, window);
    now += window;
  }
  const Momentum after = structure.momentum();
  double linear = 0, angular = 0;
  for (int a = 0; a < 3; ++a) {
    linear = std::max(linear, std::abs(after.linear[a] - before.linear[a]));
    angular = std::max(angular, std::abs(after.angular[a] - before.angular[a]));
  }
  return {linear / linear_scale, angular / angular_scale};
}

TEST(Momentum, OfATumblingBodyIsKeptToRoundOffOverTenThousandSteps) {
  const auto [linear_2d, angular_2d] = momentum_drift<2>({8, 9, 0}, 10000);
  EXPECT_LT(linear_2d, 1e-12);
  EXPECT_LT(angular_2d, 1e-12);
  const auto [linear_3d, angular_3d] = momentum_drift<3>({5, 6, 5}, 10000);
  EXPECT_LT(linear_3d, 1e-12);
  EXPECT_LT(angular_3d, 1e-12);
  const auto [linear_thin, angular_thin] = momentum_drift<3>({2, 6, 5}, 10000);
  EXPECT_LT(linear_thin, 1e-12);
  EXPECT_LT(angular_thin, 1e-12);
}

/// Eigenvalues of the stiffness at rest of a free body over E, smallest first, without diffusion.
template <int D>
Eigen::VectorXd stiffnesses(const StructureBody& b) {
  StructureCase structure = *scene(D, {b}).structure;
  structure.numerics.riemann_diffusion = 0;
  const auto reference = build_reference<D>(structure);
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  const auto size = static_cast<Eigen::Index>(D * reference.particle_row.size());
  const double step = 1e-6 * b.spacing;
  Eigen::MatrixXd stiffness(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (const int sign : {1, -1}) {
      state.displacement[i % D][reference.particle_row[i / D]] = sign * step;
      evaluate(reference, state, work);
      for (Eigen::Index k = 0; k < size; ++k) {
        const double force = state.internal_force[k % D][reference.particle_row[k / D]];
        stiffness(k, i) = sign > 0 ? -force : (stiffness(k, i) + force) / (2 * step);
      }
    }
    state.displacement[i % D][reference.particle_row[i / D]] = 0;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (stiffness + stiffness.transpose()));
  return solver.eigenvalues() / b.young_modulus;
}

/// Least stiffness -f.u/(E u.u), in the middle of a block of n particles a side, of the motions u that alternate from particle
/// to particle along one or more axes. (Near the surface even F_i sees them.)
template <int D>
double least_alternating_stiffness(double n) {
  StructureCase structure = block<D>(n);
  structure.numerics.riemann_diffusion = 0;
  const auto reference = build_reference<D>(structure);
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  const double size = 1e-6;
  double least = 1e300;
  for (int axes = 1; axes < (1 << D); ++axes)
    for (int component = 0; component < D; ++component) {
      set_rows<D>(reference, state.displacement, [&](const Vector<D>& x) {
        int sum = 0;
        for (int a = 0; a < D; ++a) sum += (axes >> a & 1) * static_cast<int>(x[a]);
        return Vector<D>((sum % 2 ? size : -size) * Vector<D>::Unit(component));
      });
      evaluate(reference, state, work);
      double along = 0, squares = 0;
      for (const auto row : reference.particle_row) {
        const Vector<D> x = reference.position_of(row);
        if (x.minCoeff() < 5 || x.maxCoeff() > n - 5) continue;
        along -= state.internal_force[component][row] * state.displacement[component][row];
        squares += size * size;
      }
      least = std::min(least, along / squares / structure.bodies[0].young_modulus);
    }
  return least;
}

/// The stiffness of a free body vanishes for its rigid motions only.
template <int D>
void expect_rigid_motions_only(const StructureBody& b) {
  const Eigen::VectorXd values = stiffnesses<D>(b);
  constexpr int rigid_motions = D == 2 ? 3 : 6;
  for (int n = 0; n < rigid_motions; ++n) EXPECT_LT(std::abs(values[n]), 1e-8);
  EXPECT_GT(values[rigid_motions], 0.005);
}

// Motions that alternate from particle to particle leave F_i inside a body as it is; the energy of the strain gradient holds
// them with 0.5 (2D) and 0.3 E dx^(D-2) (3D). Seen to fail: with W = Psi(F_i) alone (1e-34).
TEST(ElasticForce, HoldsEveryMotionButTheRigidOnes) {
  expect_rigid_motions_only<2>(body("square", {0, 0, 0}, {8, 8, 0}, 1));
  expect_rigid_motions_only<2>(body("two across", {0, 0, 0}, {2, 8, 0}, 1));
  expect_rigid_motions_only<3>(body("cube", {0, 0, 0}, {4, 4, 4}, 1));
  expect_rigid_motions_only<3>(body("plate of two across", {0, 0, 0}, {5, 5, 2}, 1));
  expect_rigid_motions_only<3>(body("bar of two by two", {0, 0, 0}, {2, 4, 2}, 1));
  EXPECT_GT(least_alternating_stiffness<2>(14), 0.2);
  EXPECT_GT(least_alternating_stiffness<3>(12), 0.2);
}

}  // namespace
}  // namespace tern::structure::testing
