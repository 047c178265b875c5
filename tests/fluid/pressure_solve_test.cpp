// The pressure Poisson equation: its matrix, its solver, and hydrostatic pressure from one solve at rest.

#include <gtest/gtest.h>
#include <omp.h>

#include <Eigen/SparseCholesky>

#include "fixtures/fluid_scenes.hpp"

namespace tern::fluid::testing {
namespace {

constexpr unsigned seed = 20240119;

/// All entries, read off by products with unit vectors of the unknowns: edges come out to the last bit.
Eigen::SparseMatrix<double> entries_of(const Fluid<2>& fluid) {
  const EdgeMatrix& matrix = fluid.pressure_matrix();
  std::vector<double> unit(matrix.rows(), 0), column(matrix.rows());
  std::vector<Eigen::Triplet<double>> entries;
  for (int j = 0; j < matrix.rows(); ++j) {
    if (!fluid.state().particle_class[j].pressure_unknown()) {
      entries.emplace_back(j, j, 1);
      continue;
    }
    unit[j] = 1;
    matrix.multiply(unit, column);
    unit[j] = 0;
    for (int i = 0; i < matrix.rows(); ++i)
      if (column[i] != 0) entries.emplace_back(i, j, column[i]);
  }
  Eigen::SparseMatrix<double> result(matrix.rows(), matrix.rows());
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

Eigen::VectorXd head(const std::vector<double>& values, std::size_t n) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(n));
}

/// A column that has collapsed for `until` seconds.
Fluid<2> collapsed(int nx, int ny, double until, double tolerance = 1e-6) {
  Fluid<2> fluid(solved_to(tolerance, dam_break(nx, ny)));
  run(fluid, until, [] {});
  return fluid;
}

// Seen to fail: with the edges of every second row larger by a millionth (not symmetric), and with the sign of the
// missing part of a support turned.
TEST(PressureMatrix, IsSymmetricToTheLastBitAndPositiveDefinite) {
  Fluid<2> fluid = collapsed(20, 40, 0.2);
  solve(fluid, 1e-4);
  const Eigen::SparseMatrix<double> a = entries_of(fluid);
  const Eigen::SparseMatrix<double> difference = a - Eigen::SparseMatrix<double>(a.transpose());
  EXPECT_EQ(difference.coeffs().cwiseAbs().maxCoeff(), 0);
  for (int j = 0; j < a.outerSize(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator entry(a, j); entry; ++entry)
      ASSERT_TRUE(entry.row() == j ? entry.value() > 0 : entry.value() < 0) << entry.row() << " " << j;
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky(a);
  EXPECT_EQ(cholesky.info(), Eigen::Success);
}

// Measured differences: 3e-8 at a tolerance of 1e-6, 3e-12 at 1e-10. Seen to fail: with ten thousand times the
// tolerance, and with p advanced by 1.0001 of the step that the residual takes.
TEST(PressureSolve, AgreesWithAFreshCholeskyFactorisation) {
  for (double tolerance : {1e-6, 1e-10}) {
    Fluid<2> fluid = collapsed(25, 50, 0.15, tolerance);
    solve(fluid, 5e-4);
    const std::size_t n = fluid.state().size();
    const Eigen::SparseMatrix<double> a = entries_of(fluid);
    const Eigen::VectorXd b = head(fluid.pressure_source(), n), p = head(fluid.pressure_solution(), n);
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky(a);
    const Eigen::VectorXd reference = cholesky.solve(b);
    EXPECT_LE((b - a * p).norm(), 1.01 * tolerance * b.norm());
    EXPECT_LT((p - reference).norm(), 10 * tolerance * reference.norm());
  }
}

// Water on the block at the end. Measured: 5.3 on the mean and 6 at most in 2D, 5.7 and 6 in 3D. Seen to fail: 43 at most in
// 2D and 22 in 3D, with the free surface's part c_i left out of the grid operator.
TEST(PressureSolve, TakesFewIterationsInADamBreakOnABlock) {
  const auto expect_few = [](const std::string& dimensions, auto fluid) {
    const Iterations iterations = count_iterations(fluid, 0.25);
    RecordProperty(dimensions + "_mean", std::to_string(iterations.mean()));
    RecordProperty(dimensions + "_most", iterations.most);
    EXPECT_LE(iterations.mean(), 8);
    EXPECT_LE(iterations.most, 12);
    EXPECT_EQ(fluid.fallback_solves(), 0);
    EXPECT_EQ(fluid.leaked() + fluid.removed(), 0u);
  };
  expect_few("in_2d", Fluid<2>(solved_to(1e-6, dam_break_on_block(2, 0.2 / 50))));
  expect_few("in_3d", Fluid<3>(solved_to(1e-6, dam_break_on_block(3, 0.2 / 10))));
}

// The pressures on the two sides of a thin plate have nothing to do with each other, which a grid must be told. Measured: 4.3 to
// 6.3 iterations on the mean. Seen to fail: 7.2 in 3D to 11.2 with the bent plate, with one node at each place of the grids.
TEST(PressureSolve, TakesFewIterationsWithAThinPlateWetOnBothSides) {
  const auto expect_few = [](const std::string& name, auto fluid) {
    const Iterations iterations = count_iterations_from_disorder(fluid);
    std::printf("[ %s: %zu particles, %.1f iterations, %d at most ]\n", name.c_str(), fluid.state().size(), iterations.mean(),
                iterations.most);
    EXPECT_LE(iterations.mean(), 7) << name;
    EXPECT_LE(iterations.most, 9) << name;
  };
  constexpr double dx = 0.2 / 45;
  expect_few("parts the tank", Fluid<2>(solved_to(1e-6, parted_tank(2, dx, dx, 0.5))));
  expect_few("bent", Fluid<2>(solved_to(1e-6, parted_tank(2, dx, dx, 0.5, 0.04))));
  expect_few("ends at half the depth", Fluid<2>(solved_to(1e-6, parted_tank(2, dx, dx, 0.1))));
  constexpr double coarse = 0.2 / 12;
  expect_few("in 3D", Fluid<3>(solved_to(1e-6, parted_tank(3, coarse, coarse, 0.5))));
  expect_few("in 3D, ends at half the depth", Fluid<3>(solved_to(1e-6, parted_tank(3, coarse, coarse, 0.1))));
}

State<2> three_steps(int threads) {
  omp_set_num_threads(threads);
  std::mt19937 random(seed);
  Fluid<2> fluid(scene(2, 0.01, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {2, 2, 0})}));
  EXPECT_GT(static_cast<std::ptrdiff_t>(fluid.state().size()), parallel_threshold);
  jitter(fluid, 0.1, random);
  for (int k = 0; k < 3; ++k) step(fluid, 5e-4);
  return fluid.state();
}

// Seen to fail: with the scalar products of the conjugate gradients summed by thread.
TEST(FluidStep, GivesTheSameBitsWithOneAndWithTwoThreads) {
  const int before = omp_get_max_threads();
  const State<2> one = three_steps(1), two = three_steps(2);
  omp_set_num_threads(before);
  EXPECT_EQ(one.id, two.id);
  EXPECT_EQ(one.pressure, two.pressure);
  EXPECT_EQ(one.position, two.position);
  EXPECT_EQ(one.velocity, two.velocity);
}

/// A tank 1 m x 1 m, 20 particles a side, moved at random; its pressure from one solve at rest, without density source.
Fluid<2> tank_at_rest(double size_of_jitter, std::mt19937& random) {
  Case c = scene(2, 0.05, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {1, 2, 0})});
  c.fluid->numerics.density_relaxation = 0;
  Fluid<2> fluid(c);
  jitter(fluid, size_of_jitter, random);
  solve(fluid, 1e-3);
  return fluid;
}

// Without density source and for a small step, before r* has fallen towards the floor. Above half height the marks of the
// walls beyond the water show (noise 6e-4 rho g H at 20 particles a side). Seen to fail: slope 1.0015 with only two of the
// three layers within the support calibrated.
TEST(HydrostaticPressure, OnALatticeHasTheSlopeOfTheWeight) {
  Case c = scene(2, 0.05, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {1, 2, 0})});
  c.fluid->numerics.density_relaxation = 0;
  Fluid<2> fluid(c);
  solve(fluid, 1e-4);
  const PressureLine line = fit_pressure(fluid, 0.5);
  RecordProperty("slope", std::to_string(line.slope / (-density * gravity)));
  EXPECT_NEAR(line.slope, -density * gravity, 5e-4 * density * gravity);
  EXPECT_LT(line.noise, 1e-4 * density * gravity);
}

// One draw scatters: over 40 draws the slope was 1.001 +- 0.011, the noise 3.4e-3 rho g H. The density source is off:
// at a step of 1 ms it would ask for more divergence than gravity makes in one step, and settles only as particles
// move. Seen to fail: with the mirror factor 2 of the wall flux left out, with the factor 2 of the Laplacian's
// edges left out, and (slope 0.42) with the correction of the pressure answering what keeps the particles in order.
TEST(HydrostaticPressure, HasTheSlopeOfTheWeightOnTheMeanOverDisorderedTanks) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  constexpr int draws = 40;
  double slope = 0;
  for (int k = 0; k < draws; ++k) {
    const PressureLine line = fit_pressure(tank_at_rest(0.1, random), 2.0);
    slope += line.slope / (-density * gravity) / draws;
    EXPECT_LT(line.noise, 0.01 * density * gravity);
  }
  RecordProperty("slope", std::to_string(slope));
  EXPECT_NEAR(slope, 1, 0.005);
}

// Nothing ties the pressure of a full box to a value. Measured after ten steps: slope 0.9999 of the weight, noise 8e-5
// rho g H on a lattice; 0.991 and 4e-3 from 10 % disorder, still settling. Seen to fail: without the mean taken out of
// the pressure or of the source, and with walls that hide only half of tr M (deficits tie the pressure to zero).
TEST(SealedBox, HasAPressureOfMeanZeroAndTheSlopeOfTheWeight) {
  for (double size_of_jitter : {0.0, 0.1}) {
    Fluid<2> fluid(scene(2, 0.05, {box({0, 0, 0}, {1, 1, 0})}, {tank({0, 0, 0}, {1, 1, 0}, {})}));
    std::mt19937 random(seed);
    jitter(fluid, size_of_jitter, random);
    for (int k = 0; k < 10; ++k) {
      step(fluid, 2e-3);
      ASSERT_TRUE(fluid.last_solve().converged);
      EXPECT_LE(fluid.last_solve().iterations, 8);
      const auto& pressure = fluid.state().pressure;
      ASSERT_EQ(fluid.spray_particles(), 0u);
      EXPECT_LT(std::abs(ordered_sum(pressure)) / static_cast<double>(pressure.size()), 1e-9 * density * gravity);
    }
    EXPECT_EQ(fluid.fallback_solves(), 0);
    EXPECT_NEAR(fit_pressure(fluid, 2.0).slope, -density * gravity, (size_of_jitter > 0 ? 0.02 : 5e-4) * density * gravity);
  }
}

}  // namespace
}  // namespace tern::fluid::testing
