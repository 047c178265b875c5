// Every material of the registry: its stress, its tangent and its limit at small strain; and the closed forms of Mooney-Rivlin.

#include <gtest/gtest.h>

#include <random>

#include "base/error.hpp"
#include "fixtures/structure_scenes.hpp"

namespace tern::structure::testing {
namespace {

MaterialParameters parameters(bool plane_stress = false) {
  return {.density = 1000, .young_modulus = 1e6, .poisson_ratio = 0.4, .mooney_ratio = 0.3, .plane_stress = plane_stress};
}

template <int D>
Matrix<D> random_deformation(std::mt19937& random) {
  Matrix<D> f = Matrix<D>::Identity();
  f(0, 0) = 1.3;
  for (int a = 0; a < D; ++a) f.col(a) += random_vector<D>(random, 0.15);
  return f;
}

/// P of one particle, in numbers of type Number.
template <int D, class Number = double, class Law>
Matrix<D> stress_at(const Law& law, const Matrix<D>& f) {
  const Matrix<D> inverse = f.inverse();
  Number h[D][D], f_of[D][D], inverse_transposed[D][D], p[D][D];
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) {
      h[a][b] = Number{} + (f(a, b) - (a == b));
      f_of[a][b] = Number{} + f(a, b);
      inverse_transposed[a][b] = Number{} + inverse(b, a);
    }
  law.template stress<D>(h, f_of, inverse_transposed, Number{} + f.determinant(), p);
  Matrix<D> result;
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) {
      if constexpr (std::is_same_v<Number, double>)
        result(a, b) = p[a][b];
      else
        result(a, b) = p[a][b][2];
    }
  return result;
}

template <int D, class Law>
void check_law(const Law& law, std::mt19937& random) {
  const double step = 1e-4, largest = law.young_modulus;
  const Matrix<D> f = random_deformation<D>(random), identity = Matrix<D>::Identity();
  const Matrix<D> p = stress_at<D>(law, f);
  const Tangent4<D> tangent = law.template tangent<D>(f);
  for (int k = 0; k < D; ++k)
    for (int l = 0; l < D; ++l) {
      Matrix<D> unit = Matrix<D>::Zero();
      unit(k, l) = step;
      const auto energy = [&](double n) { return law.template energy_density<D>(f + n * unit - identity, f + n * unit); };
      const auto stress = [&](double n) { return stress_at<D>(law, f + n * unit); };
      EXPECT_NEAR(p(k, l), (8 * (energy(1) - energy(-1)) - (energy(2) - energy(-2))) / (12 * step), 1e-8 * largest) << law.name;
      const Matrix<D> change = (8 * (stress(1) - stress(-1)) - (stress(2) - stress(-2))) / (12 * step);
      for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) EXPECT_NEAR(tangent(i * D + j, k * D + l), change(i, j), 1e-7 * largest) << law.name;
    }
  EXPECT_LT((stress_at<D, Lanes>(law, f) - p).norm(), 1e-12 * largest) << law.name;
  // Small strain.
  Matrix<D> h = Matrix<D>::Zero();
  for (int a = 0; a < D; ++a) h.col(a) = random_vector<D>(random, 1e-5);  // differences of 1 keep five digits of an energy
  const Matrix<D> e = 0.5 * (h + h.transpose()), hooke = law.template strain_stress<D>(e);
  EXPECT_LT((stress_at<D>(law, identity + h) - hooke).norm(), 2e-4 * hooke.norm()) << law.name;
  EXPECT_NEAR(law.template energy_density<D>(h, identity + h), law.template strain_energy<D>(e), 2e-4 * law.template strain_energy<D>(e));
  EXPECT_NEAR(law.modulus_at(1), law.plane_lambda + 2 * law.mu, 1e-9 * largest) << law.name;
}

TEST(Material, HasAStressThatIsTheGradientOfItsEnergyAndATangentThatIsThatOfItsStress) {
  std::mt19937 random(5);
  for_each_material([&]<class Law>() {
    for (int n = 0; n < 5; ++n) {
      check_law<2>(Law(parameters()), random);
      check_law<2>(Law(parameters(true)), random);
      check_law<3>(Law(parameters()), random);
    }
  });
}

// sigma_33 of a plane law is that of the same deformation in space, and zero in plane stress.
TEST(Material, KnowsTheStressAcrossThePlane) {
  std::mt19937 random(6);
  for_each_material([&]<class Law>() {
    for (const bool plane_stress : {false, true}) {
      const Law law(parameters(plane_stress)), in_space(parameters());
      // Half of it: in plane stress St Venant-Kirchhoff has no thickness left where tr E reaches (1 - nu)/(2 nu).
      const Matrix<2> f = 0.5 * (Matrix<2>::Identity() + random_deformation<2>(random));
      const OutOfPlane across = law.template out_of_plane<2>(f - Matrix<2>::Identity(), f.determinant());
      Matrix<3> full = Matrix<3>::Identity();
      full.topLeftCorner<2, 2>() = f;
      full(2, 2) = across.stretch;
      const Matrix<3> p = stress_at<3>(in_space, full);
      EXPECT_NEAR(across.stress, p(2, 2) * across.stretch / full.determinant(), 1e-9 * law.young_modulus) << law.name;
      const Matrix<2> in_plane = stress_at<2>(law, f);
      EXPECT_LT((p.topLeftCorner<2, 2>() - in_plane).norm(), 1e-9 * law.young_modulus) << law.name;
    }
  });
}

TEST(Material, OfAnUnknownNameIsRefused) {
  MaterialParameters rubber = parameters();
  rubber.material = "rubber";
  EXPECT_THROW(Material{rubber}, BadInput);
}

// F = I + gamma e_1 x e_2: P_12 = 2 (C10 + C01) gamma, P_22 = -2/3 (C10 + 2 C01) gamma^2.
TEST(MooneyRivlin, HasTheClosedFormOfSimpleShear) {
  const MooneyRivlin law(parameters());
  EXPECT_NEAR(law.c01 / (law.c10 + law.c01), 0.3, 1e-15);
  const double gamma = 0.8;
  Matrix<2> in_plane = Matrix<2>::Identity();
  Matrix<3> in_space = Matrix<3>::Identity();
  in_plane(0, 1) = in_space(0, 1) = gamma;
  for (const Matrix<2>& p : {Matrix<2>(stress_at<2>(law, in_plane)), Matrix<2>(stress_at<3>(law, in_space).topLeftCorner<2, 2>())}) {
    EXPECT_NEAR(p(0, 1), 2 * (law.c10 + law.c01) * gamma, 1e-9 * law.mu);
    EXPECT_NEAR(p(1, 1), -2.0 / 3 * (law.c10 + 2 * law.c01) * gamma * gamma, 1e-9 * law.mu);
  }
}

// F = diag(s, t, t), J = s t^2: P_11 s = 4/3 a (s^2 - t^2) + 4/3 b t^2 (s^2 - t^2) + kappa (J - 1) J with a = C10 J^-2/3, b = C01 J^-4/3.
TEST(MooneyRivlin, HasTheClosedFormOfUniaxialStretch) {
  const MooneyRivlin law(parameters());
  for (const double s : {0.6, 1.7}) {
    const double t = 0.9, j = s * t * t, difference = s * s - t * t;
    const double a = law.c10 * std::pow(j, -2.0 / 3), b = law.c01 * std::pow(j, -4.0 / 3);
    const Matrix<3> f = Vector<3>(s, t, t).asDiagonal();
    const Matrix<3> p = stress_at<3>(law, f);
    EXPECT_NEAR(p(0, 0) * s, 4.0 / 3 * difference * (a + b * t * t) + law.kappa * (j - 1) * j, 1e-9 * law.mu);
    EXPECT_NEAR(p(1, 1) * t, -2.0 / 3 * difference * (a + b * t * t) + law.kappa * (j - 1) * j, 1e-9 * law.mu);
  }
}

/// Stretch of the middle of a bar in plane stress that hangs on one end and is pulled at the other by `traction`, at rest.
double stretch_of_a_pulled_bar(Integrator integrator, double traction) {
  StructureBody b = body("bar", {0, 0, 0}, {0.02, 0.1, 0}, 0.005);
  b.material = "mooney_rivlin";
  b.young_modulus = 1e5;
  b.poisson_ratio = 0.49;
  b.mooney_ratio = 0.3;
  b.plane_stress = true;
  b.mass_damping = 300;
  b.clamps = {box({-1, -1, -1}, {1, 0.01, 1})};
  Case c = scene(2, {b});
  c.structure->numerics.integrator = integrator;
  LoadCase load;
  load.body = "bar";
  load.region = box({-1, 0.0999, -1}, {1, 1, 1});
  load.value[1] = Expression(traction);
  c.structure->loads.push_back(load);
  Structure<2> bar(c);
  const auto low = bar.material_point("bar", {0.01, 0.05, 0}), high = bar.material_point("bar", {0.01, 0.08, 0});
  for (int n = 0; n < 250; ++n) bar.trial(bar.time(), to_ticks(1e-3));
  return 1 + (bar.displacement(high) - bar.displacement(low))[1] / 0.03;
}

// Nominal stress of the incompressible solid, P = 2 (s - s^-2) (C10 + C01/s); nu = 0.49 is within 2 % of it.
TEST(MooneyRivlin, StretchesAPulledBarAsTheClosedFormSays) {
  const double mu = 1e5 / (2 * 1.49), c10 = 0.35 * mu, c01 = 0.15 * mu, s = 1.5;
  const double traction = 2 * (s - 1 / (s * s)) * (c10 + c01 / s);
  for (const Integrator integrator : {Integrator::explicit_steps, Integrator::implicit_steps})
    EXPECT_NEAR(stretch_of_a_pulled_bar(integrator, traction), s, 0.02) << static_cast<int>(integrator);
}

}  // namespace
}  // namespace tern::structure::testing
