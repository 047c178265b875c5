// Gradient vectors, deformation gradient and stress.

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "fixtures/structure_scenes.hpp"
#include "structure/gradient_vectors.hpp"

namespace tern::structure::testing {
namespace {

template <int D>
double gradient_error_of_a_quadratic_field() {
  std::vector<Vector<D>> offsets;
  const int reach = 2;  // a corner: neighbours on one side only
  for (int n = 1; n < (D == 2 ? 16 : 64); ++n) {
    Vector<D> x;
    x[0] = n % 4;
    x[1] = n / 4 % 4;
    if constexpr (D == 3) x[2] = n / 16;
    if (x.norm() < 1.3 * reach) offsets.push_back(0.1 * x);
  }
  const auto g = derivative_fit<D>(offsets, 0.01, 0.13).vectors;
  Matrix<D> curvature = Matrix<D>::Identity();
  curvature(0, 1) = curvature(1, 0) = -0.7;
  Vector<D> slope = Vector<D>::LinSpaced(1.0, 2.0), sum = Vector<D>::Zero();
  for (std::size_t n = 0; n < offsets.size(); ++n)
    sum += 0.01 * (slope.dot(offsets[n]) + 5 * offsets[n].dot(curvature * offsets[n])) * g[n].gradient;
  return (sum - slope).norm();
}

// Seen to fail: with the linear basis alone the error is 0.56 in 2D and 0.78 in 3D.
TEST(Gradient, IsExactForQuadraticFieldsEvenAtACorner) {
  EXPECT_LT(gradient_error_of_a_quadratic_field<2>(), 1e-12);
  EXPECT_LT(gradient_error_of_a_quadratic_field<3>(), 1e-12);
}

// Two layers do not determine a quadratic. Seen to fail: without the fallback g is empty and the scene is refused.
TEST(Gradient, FallsBackToLinearExactnessInTwoLayers) {
  const auto reference = build_reference<2>(*scene(2, {body("strip", {0, 0, 0}, {8, 2, 0}, 1)}).structure);
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  set_rows<2>(reference, state.displacement, [](const Vector<2>& x) { return Vector<2>(0.1 * x[1], 0.2 * x[0]); });
  deformation_gradient(reference, state, work);
  for (const auto row : reference.particle_row) {
    const Matrix<2> f = deformation_gradient_of<2>(work, row);
    EXPECT_NEAR(f(0, 1), 0.1, 1e-12);
    EXPECT_NEAR(f(1, 0), 0.2, 1e-12);
  }
}

// Seen to fail: without the check the missing vectors are read all the same, and the test crashes.
TEST(Gradient, RefusesOneLayerWithTheRemedy) {
  try {
    build_reference<2>(*scene(2, {body("film", {0, 0, 0}, {8, 1, 0}, 1)}).structure);
    FAIL() << "accepted";
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("'film'"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("make the spacing"), std::string::npos) << error.what();
  }
}

template <int D>
void affine_patch() {
  const auto reference = build_reference<D>(block<D>(6));
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  Matrix<D> a = Matrix<D>::Identity() * 1.1;
  a(0, 1) = 0.3;
  a(1, 0) = -0.1;
  set_rows<D>(reference, state.displacement, [&](const Vector<D>& x) -> Vector<D> { return a * x - x; });
  deformation_gradient(reference, state, work);
  for (const auto row : reference.particle_row) EXPECT_LT((deformation_gradient_of<D>(work, row) - a).norm(), 1e-12);
}

// Seen to fail: with the first neighbour left out of the sum F is off by 1e-3.
TEST(DeformationGradient, IsExactInAnAffinePatch) {
  affine_patch<2>();
  affine_patch<3>();
}

/// Largest error of F in a body under a displacement that is quadratic in X, relative to the largest |H|.
template <int D>
double quadratic_patch_error() {
  const auto reference = build_reference<D>(block<D>(6));
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  set_rows<D>(reference, state.displacement, [](const Vector<D>& x) {
    Vector<D> d = 0.1 * x;
    d[0] += 0.02 * x[0] * x[1] - 0.01 * x[1] * x[1];
    d[D - 1] += 0.03 * x[0] * x[0] - 0.02 * x[0] * x[D - 1];
    return d;
  });
  deformation_gradient(reference, state, work);
  double error = 0, largest = 0;
  for (const auto row : reference.particle_row) {
    const Vector<D> x = reference.position_of(row);
    Matrix<D> h = 0.1 * Matrix<D>::Identity();
    h(0, 0) += 0.02 * x[1];
    h(0, 1) += 0.02 * x[0] - 0.02 * x[1];
    h(D - 1, 0) += 0.06 * x[0] - 0.02 * x[D - 1];
    h(D - 1, D - 1) -= 0.02 * x[0];
    largest = std::max(largest, h.norm());
    error = std::max(error, (deformation_gradient_of<D>(work, row) - Matrix<D>::Identity() - h).norm());
  }
  return error / largest;
}

// At every particle, those of faces, edges and corners included. Seen to fail: with the linear basis alone, 0.2.
TEST(DeformationGradient, IsExactInAQuadraticPatch) {
  EXPECT_LT(quadratic_patch_error<2>(), 1e-12);
  EXPECT_LT(quadratic_patch_error<3>(), 1e-12);
}

template <int D>
double stress_under_a_right_angle_over_mu() {
  const auto reference = build_reference<D>(block<D>(5));
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  set_rows<D>(reference, state.displacement, [](const Vector<D>& x) {
    Vector<D> d = Vector<D>::Zero();
    d[0] = -x[1] - x[0];
    d[1] = x[0] - x[1];
    return d;
  });
  evaluate(reference, state, work);
  double largest = 0;
  for (const auto row : reference.particle_row)
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) largest = std::max(largest, std::abs(work.stress[a][b][row]));
  return largest / reference.bodies[0].material.mu;
}

// Seen to fail: with F^-1 in place of F^-T, P is 2 mu.
TEST(Stress, VanishesUnderARotationByNinetyDegrees) {
  EXPECT_LT(stress_under_a_right_angle_over_mu<2>(), 1e-9);
  EXPECT_LT(stress_under_a_right_angle_over_mu<3>(), 1e-9);
}

// Small uniaxial strain: P_11 = (lambda + 2 mu) e, P_22 = lambda e. Seen to fail: with mu in place of lambda.
TEST(Stress, FollowsHookesLawForSmallStrain) {
  const auto reference = build_reference<2>(block<2>(6));
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  const double strain = 1e-6;
  set_rows<2>(reference, state.displacement, [&](const Vector<2>& x) { return Vector<2>(strain * x[0], 0.0); });
  evaluate(reference, state, work);
  const Material& m = reference.bodies[0].material;
  const auto row = reference.particle_row[10];
  EXPECT_NEAR(work.stress[0][0][row], (m.lambda + 2 * m.mu) * strain, 1e-5 * m.mu * strain + 1e-9 * m.mu);
  EXPECT_NEAR(work.stress[1][1][row], m.lambda * strain, 1e-5 * m.mu * strain + 1e-9 * m.mu);
}

/// P_11 and P_22 of a block of `law` stretched by `strain` along x and free of strain along y, over E.
std::array<double, 2> stress_of_a_stretched_block(const std::string& law, bool plane_stress, double strain) {
  StructureCase structure = block<2>(6);
  structure.bodies[0].material = law;
  structure.bodies[0].plane_stress = plane_stress;
  const auto reference = build_reference<2>(structure);
  auto state = state_at_rest(reference, 0);
  auto work = workspace_for(reference);
  set_rows<2>(reference, state.displacement, [&](const Vector<2>& x) { return Vector<2>(strain * x[0], 0.0); });
  evaluate(reference, state, work);
  const auto row = reference.particle_row[10];
  return {work.stress[0][0][row] / 1e6, work.stress[1][1][row] / 1e6};
}

// E/(1 - nu^2) along, nu times that across. Seen to fail: with lambda of plane strain.
TEST(Stress, InPlaneStressFollowsHookesLawForSmallStrain) {
  for (const std::string& law : material_keys()) {
    const auto [along, across] = stress_of_a_stretched_block(law, true, 1e-7);
    EXPECT_NEAR(along, 1e-7 / (1 - 0.09), 1e-6 * 1e-7 + 1e-13);
    EXPECT_NEAR(across, 0.3e-7 / (1 - 0.09), 1e-6 * 1e-7 + 1e-13);
  }
}

// S = (lambda + 2 mu) E_11, E_11 = e + e^2/2, P = (1 + e) S. Seen to fail: without the quadratic term of the strain.
TEST(Stress, OfStVenantAndKirchhoffIsQuadraticInTheStretch) {
  const Hooke m({.density = 1000, .young_modulus = 1e6, .poisson_ratio = 0.3});
  const double e = 0.5, strain = e + 0.5 * e * e;
  const auto [along, across] = stress_of_a_stretched_block("st_venant_kirchhoff", false, e);
  EXPECT_NEAR(along, 1.5 * (m.lambda + 2 * m.mu) * strain / 1e6, 1e-12);
  EXPECT_NEAR(across, m.lambda * strain / 1e6, 1e-12);
}

// Seen to fail: after one step of Newton's method 0.13, after three 5e-6.
TEST(Stress, AcrossThePlaneVanishesInPlaneStressAtAnyStretch) {
  const NeoHookean m({.density = 1000, .young_modulus = 1e6, .poisson_ratio = 0.45, .plane_stress = true});
  for (const double log_j2 : {-1.5, -0.3, 1e-9, 0.4, 2.0}) {
    const double y = m.log_thickness_stretch(log_j2);
    EXPECT_LT(std::abs(m.mu * (std::exp(2 * y) - 1) + m.lambda * (log_j2 + y)), 1e-12 * (m.lambda + m.mu));
  }
}

}  // namespace
}  // namespace tern::structure::testing
