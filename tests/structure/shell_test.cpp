// A layer of particles by itself: energy, forces, static and modal answers.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "base/error.hpp"
#include "fixtures/shell_model.hpp"

namespace tern::structure::testing {
namespace {

template <int D>
ShellModel<D> sample(const char* law, Edge low);
template <>
ShellModel<2> sample<2>(const char* law, Edge low) {
  return line(1, 0.08, 8, shell_material(1e6, 0.3, law), low);
}
template <>
ShellModel<3> sample<3>(const char* law, Edge low) {
  return plate({1, 0.9}, 0.1, {5, 6}, shell_material(1e6, 0.3, law), {low, Edge::free, low, Edge::free});
}

template <int D>
void displace(ShellModel<D>& model, double amplitude) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> some(-amplitude, amplitude);
  for (auto& x : model.x)
    for (int a = 0; a < D; ++a) x[a] += some(random) + (a == D - 1 ? 0.3 * x[0] * x[0] : 0);
}

template <int D>
void expect_gradient(const char* law, Edge low) {
  auto model = sample<D>(law, low);
  displace(model, 0.02);
  model.evaluate();
  const auto force = model.force;
  double largest = 0;
  for (const auto& f : force) largest = std::max(largest, f.norm());
  constexpr double step = 1e-6;
  for (std::size_t i = 0; i < model.x.size(); ++i)
    for (int a = 0; a < D; ++a) {
      const auto at = model.x;
      model.x[i][a] += step;
      const double above = model.evaluate();
      model.x = at;
      model.x[i][a] -= step;
      const double below = model.evaluate();
      model.x = at;
      EXPECT_NEAR(force[i][a], (below - above) / (2 * step), 1e-7 * largest) << D << "D, " << law << ", particle " << i << " axis " << a;
    }
}

// Seen to fail: with the force of the cell term, or of the bending, on x_,a left out.
TEST(Shell, ForcesAreTheGradientOfTheEnergyInTwoAndThreeDimensionsForBothMaterialsAndAllEdges) {
  for (const char* law : {"st_venant_kirchhoff", "neo_hookean"})
    for (const Edge low : {Edge::free, Edge::hinge, Edge::clamp}) {
      expect_gradient<2>(law, low);
      expect_gradient<3>(law, low);
    }
}

/// Energy density of particle i where it is.
double density_of(ShellModel<3>& model, std::size_t i) {
  ShellDerivatives<3> unused;
  return shell_energy_density<3>(model.layer, i, model.derivatives[i], model.turn, unused);
}

/// C(A, A) of a symmetric A.
double hooke_square(const ShellLayer<3>& layer, double a11, double a22, double a12) {
  const double nu = layer.poisson_ratio();
  return layer.modulus() * ((1 - nu) * (a11 * a11 + a22 * a22 + 2 * a12 * a12) + nu * (a11 + a22) * (a11 + a22));
}

// Quadratic fields have exact derivatives, so that every particle has the energy of the formula. The thickness is between both spacings.
// Seen to fail: without the cell term, with the two lengths of the cell exchanged, with twice the twist.
TEST(Shell, EnergiesOfQuadraticFieldsAreThoseOfTheFormula) {
  constexpr double t = 0.18, a = 0.3, b = 0.2, kappa = 0.5, twist = 0.4;
  auto model = plate({1, 0.9}, t, {5, 6}, shell_material(1e6, 0.3), {Edge::free, Edge::free, Edge::free, Edge::free});
  const double c1 = t * t / 12, c2 = 0.15 * 0.15 / 12;
  const auto& start = model.layer.particles.position;
  // Along and across: x = X (1 + a X/2) + b X Y.
  for (std::size_t i = 0; i < start.size(); ++i) model.x[i][0] += 0.5 * a * start[i][0] * start[i][0] + b * start[i][0] * start[i][1];
  model.evaluate();
  for (std::size_t i = 0; i < start.size(); ++i) {
    // x_,1 = (f, 0), x_,2 = (g, 1), x_,11 = (a, 0), x_,12 = (b, 0)
    const double x = start[i][0], f = 1 + a * x + b * start[i][1], g = b * x;
    const double expected =
        t / 2 *
        (hooke_square(model.layer, (f * f - 1) / 2, g * g / 2, f * g / 2) +
         c1 * hooke_square(model.layer, a * f, b * g, (a * g + b * f) / 2) + c2 * hooke_square(model.layer, b * f, 0, b * g / 2));
    EXPECT_NEAR(density_of(model, i), expected, 1e-10 * expected) << i;
  }
  // Bent and twisted: z = kappa X^2/2 + twist X Y.
  model.x = start;
  for (std::size_t i = 0; i < start.size(); ++i)
    model.x[i][2] += 0.5 * kappa * start[i][0] * start[i][0] + twist * start[i][0] * start[i][1];
  model.evaluate();
  for (std::size_t i = 0; i < start.size(); ++i) {
    const double u = kappa * start[i][0] + twist * start[i][1], v = twist * start[i][0], l = std::sqrt(1 + u * u + v * v);
    const double expected = t / 2 *
                                (hooke_square(model.layer, u * u / 2, v * v / 2, u * v / 2) +
                                 c1 * hooke_square(model.layer, kappa * u, twist * v, (kappa * v + twist * u) / 2) +
                                 c2 * hooke_square(model.layer, twist * u, 0, twist * v / 2)) +
                            t * t * t / 24 * hooke_square(model.layer, kappa / l, 0, twist / l);
    EXPECT_NEAR(density_of(model, i), expected, 1e-10 * expected) << i;
  }
}

// On the edge: stretched by s, curved by kappa as the clamp allows, whichever edge it is.
// Seen to fail: with the plain second derivatives on the edge, with a cell term there, without bending there, with a whole cell of area.
TEST(Shell, ParticlesOnAClampedEdgeHaveTheEnergyOfTheirStretchAndOfTheCurvatureOfTheClamp) {
  constexpr double t = 0.18, s = 0.05, kappa = 0.5;
  for (int edge = 0; edge < 4; ++edge) {
    std::array<Edge, 4> edges{Edge::free, Edge::free, Edge::free, Edge::free};
    edges[edge] = Edge::clamp;
    const std::array<double, 2> length{1, 0.9};
    auto model = plate(length, t, {5, 6}, shell_material(1e6, 0.3), edges);
    const int along = edge / 2;
    const double at = edge % 2 == 0 ? 0 : length[along];
    const auto& start = model.layer.particles.position;
    for (std::size_t i = 0; i < start.size(); ++i) {
      const double distance = start[i][along] - at;
      model.x[i][along] += s * distance;
      model.x[i][2] += 0.5 * kappa * distance * distance;
    }
    model.evaluate();
    const double e = s + s * s / 2;
    const double expected = t / 2 * hooke_square(model.layer, e, 0, 0) + t * t * t / 24 * hooke_square(model.layer, kappa, 0, 0);
    double total = 0;
    int found = 0;
    for (std::size_t i = 0; i < start.size(); ++i) {
      total += model.layer.particles.area[i];
      if (model.layer.particles.clamp[i] < 0) continue;
      ++found;
      EXPECT_NEAR(density_of(model, i), expected, 1e-10 * expected) << edge << ", " << i;
    }
    EXPECT_EQ(found, along == 0 ? 6 : 5);
    EXPECT_NEAR(total, 0.9, 1e-14);
    // A plate that leaves the clamp under a small angle is bent there, by between one and two times the angle over the spacing.
    constexpr double angle = 1e-3;
    model.x = start;
    for (std::size_t i = 0; i < start.size(); ++i) model.x[i][2] += angle * (start[i][along] - at);
    model.evaluate();
    const double least = t * t * t / 24 * hooke_square(model.layer, angle / model.layer.particles.spacing[along], 0, 0);
    for (std::size_t i = 0; i < start.size(); ++i) {
      if (model.layer.particles.clamp[i] < 0) continue;
      EXPECT_GT(density_of(model, i), least) << edge << ", " << i;
      EXPECT_LT(density_of(model, i), 4 * least) << edge << ", " << i;
    }
  }
}

template <int D>
Matrix<D> turned() {
  if constexpr (D == 2)
    return Eigen::Rotation2D<double>(2.1).toRotationMatrix();
  else
    return Eigen::AngleAxis<double>(2.1, Vector<3>(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
}

template <int D>
void expect_the_same_when_turned(const char* law, double amplitude) {
  auto model = sample<D>(law, Edge::clamp);
  const double scale = model.layer.modulus() * model.layer.thickness;
  if (amplitude > 0) displace(model, amplitude);
  const double energy = model.evaluate();
  const auto force = model.force;
  const Matrix<D> r = turned<D>();
  for (auto& x : model.x) x = r * x + Vector<D>::Constant(0.4);
  std::fill(model.turn.begin(), model.turn.end(), r);
  EXPECT_NEAR(model.evaluate(), energy, 1e-15 * scale + 1e-12 * energy);
  for (std::size_t i = 0; i < force.size(); ++i) EXPECT_LT((model.force[i] - r * force[i]).norm(), 1e-12 * scale);
  EXPECT_LT(amplitude == 0 ? energy : 0, 1e-15 * scale);
}

// Seen to fail: with the normal of a clamp that does not turn with it (the bent body alone shows it).
TEST(Shell, RigidMotionsCostNoEnergyAndTurnTheForces) {
  for (const char* law : {"st_venant_kirchhoff", "neo_hookean"})
    for (const double amplitude : {0.0, 0.02}) {
      expect_the_same_when_turned<2>(law, amplitude);
      expect_the_same_when_turned<3>(law, amplitude);
    }
}

// Seen to fail: with the reference normal in place of the present one there is a torque.
TEST(Shell, InternalForcesSumToZeroAndHaveNoMoment) {
  auto model = sample<3>("neo_hookean", Edge::free);
  displace(model, 0.02);
  model.evaluate();
  Vector<3> total = Vector<3>::Zero(), moment = Vector<3>::Zero();
  double scale = 0;
  for (std::size_t i = 0; i < model.x.size(); ++i) {
    total += model.force[i];
    moment += model.x[i].cross(model.force[i]);
    scale += model.force[i].norm();
  }
  EXPECT_LT(total.norm(), 1e-13 * scale);
  EXPECT_LT(moment.norm(), 1e-13 * scale);
}

/// Seen from the deformed state, which is made the reference, the elastic stress of a small motion is C times its rates.
template <int D>
void expect_stress_of_rates(Edge low) {
  auto model = sample<D>("st_venant_kirchhoff", low);
  displace(model, 0.02);
  model.evaluate();
  const auto start = model.derivatives;
  model.layer.reference = start;
  for (std::size_t i = 0; i < model.layer.rest.size(); ++i)
    if constexpr (D == 3) model.layer.rest[i] = shell_rest(model.layer, i);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> some(-1, 1);
  constexpr double step = 1e-6, time = 0.7;
  const std::vector<Matrix<D>> still(model.turn.size(), Matrix<D>::Zero());
  for (std::size_t i = 0; i < start.size(); ++i) {
    ShellDerivatives<D> rate, viscous, above, below;
    for (auto& entry : rate.reshaped()) entry = some(random);
    shell_viscous_stress<D>(model.layer, i, start[i], rate, model.turn, still, time, viscous);
    shell_energy_density<D>(model.layer, i, start[i] + step * rate, model.turn, above);
    shell_energy_density<D>(model.layer, i, start[i] - step * rate, model.turn, below);
    EXPECT_LT((viscous - time / (2 * step) * (above - below)).norm(), 1e-7 * viscous.norm()) << D << "D, particle " << i;
  }
}

// Seen to fail: with the turn of the normal left out, with half of the rate of G.
TEST(Shell, ViscousStressIsHookesLawOfTheRatesOfStrain) {
  for (const Edge low : {Edge::free, Edge::clamp}) {
    expect_stress_of_rates<2>(low);
    expect_stress_of_rates<3>(low);
  }
}

// Seen to fail: with the turn of the normal left out, with half of the rate of G.
TEST(Shell, ARigidMotionHasNoViscousStress) {
  auto model = sample<3>("neo_hookean", Edge::free);
  displace(model, 0.02);
  model.evaluate();
  std::vector<ShellDerivatives<3>> rate(model.x.size());
  std::vector<Vector<3>> v;
  for (const auto& x : model.x) v.push_back(Vector<3>(3, 1, -2) + Vector<3>(0.3, -0.5, 0.8).cross(x));
  shell_derivatives_of<3>(model.layer, v, model.turn, rate);
  for (std::size_t i = 0; i < v.size(); ++i) {
    ShellDerivatives<3> viscous;
    shell_viscous_stress<3>(model.layer, i, model.derivatives[i], rate[i], model.turn, model.turn, 1, viscous);
    EXPECT_LT(viscous.norm(), 1e-12 * model.layer.modulus() * model.layer.thickness) << i;
  }
}

template <int D>
int modes_without_energy(ShellModel<D> model) {
  const auto values = model.squared_frequencies(1e-6);
  const double lowest = 1e-7 * values[values.size() - 1];
  return static_cast<int>(std::count_if(values.begin(), values.end(), [&](double v) { return std::abs(v) < lowest; }));
}

/// A body of radius 1 in the shape of a ring or an arc, or of a line of 360 corners along it.
StructureBody bent_body(double thickness, int count, double turn = Shape::whole_turn, bool as_line = false) {
  StructureBody body;
  static_cast<MaterialParameters&>(body) = shell_material(1e9, 0);
  body.name = "ring";
  body.is_shell = true;
  body.spacing = turn / count;
  Shape& shape = body.shape;
  shape.kind = Shape::Kind::ring;
  shape.radius = 1, shape.thickness = thickness, shape.end = turn;
  if (as_line) {
    shape.kind = Shape::Kind::line;
    shape.closed = turn == Shape::whole_turn;
    for (int n = 0; n < 360 + (shape.closed ? 0 : 1); ++n) shape.vertices.push_back({std::cos(n * turn / 360), std::sin(n * turn / 360)});
  }
  return body;
}

template <int D>
ShellModel<D> model_of(const StructureBody& body) {
  const MidSurface<D> surface = mid_surface<D>(body);
  return ShellModel<D>(make_shell_layer<D>(body.name, shell_particles(surface), Material(body), surface.thickness));
}

/// Lowest frequency in bending over that of a thin ring, sqrt(36/5 E' t^2/(12 rho R^4)).
double frequency_of_a_ring(double thickness, int count, bool as_line) {
  const auto values = model_of<2>(bent_body(thickness, count, Shape::whole_turn, as_line)).squared_frequencies(1e-7);
  EXPECT_LT(std::abs(values[2]), 1e-3 * values[3]);
  EXPECT_LT(values[4] / values[3], 1.01);  // two directions of the same mode
  return std::sqrt(values[3] / (36.0 / 5 * 1e6 * thickness * thickness / 12));
}

// Seen to fail: without the cell term there is a fourth mode without energy; with a cell as long as the spacing the ring is too stiff.
TEST(Shell, ARingSwingsAtTheFrequencyOfAThinRing) {
  for (const double thickness : {1e-2, 1e-3}) {
    EXPECT_NEAR(frequency_of_a_ring(thickness, 20, false), 1.065, 3e-3) << thickness;
    EXPECT_NEAR(frequency_of_a_ring(thickness, 40, false), 1.015, 2e-3) << thickness;
    EXPECT_NEAR(frequency_of_a_ring(thickness, 80, false), 1.004, 2e-3) << thickness;
  }
  EXPECT_NEAR(frequency_of_a_ring(1e-2, 40, true), 1.015, 3e-3);
}

/// Pressure p R^3/(E' I) at which a ring of R/t = 1000 buckles: where its second free motion has no stiffness.
double buckling_pressure(int count) {
  constexpr double t = 1e-3, rigidity = 1e9 * t * t * t / 12;
  const auto stiffness = [&](double p) {
    auto model = model_of<2>(bent_body(t, count));
    for (auto& x : model.x) x *= 1 - p * rigidity / (1e9 * t);
    model.load = [p, rigidity](const auto& m, auto& force) {
      for (std::size_t i = 0; i < force.size(); ++i) {
        const Vector<2> a = m.derivatives[i].col(0);  // the normal of the frame looks inwards
        force[i] += p * rigidity * m.layer.particles.area[i] * Vector<2>(-a[1], a[0]);
      }
    };
    const auto values = model.squared_frequencies(1e-7);
    return values[0] < -1e-3 * values[4] ? values[0] : values[3];
  };
  double low = 2, high = 5;
  for (int n = 0; n < 12; ++n) (stiffness(0.5 * (low + high)) > 0 ? low : high) = 0.5 * (low + high);
  return low;
}

TEST(Shell, ARingBucklesUnderTheThreefoldOfItsRigidityOverTheCubeOfItsRadius) {
  EXPECT_NEAR(buckling_pressure(40), 3.13, 0.02);
  EXPECT_NEAR(buckling_pressure(80), 3.03, 0.02);
}

/// A tube along x that is open or closed.
StructureBody tube_body(double radius, double length, double thickness, double begin, double end, double spacing) {
  StructureBody body = bent_body(thickness, 40);
  Shape& shape = body.shape;
  shape.kind = Shape::Kind::tube;
  shape.axis = 0;
  shape.center = {0.5 * length, 0, 0};
  shape.radius = radius, shape.length = length, shape.begin = begin, shape.end = end;
  body.spacing = spacing;
  return body;
}

TEST(Shell, RingsArcsAndTubesHaveNoOtherFreeMotionsThanRigidOnes) {
  EXPECT_EQ(modes_without_energy(model_of<2>(bent_body(0.1, 12))), 3);
  EXPECT_EQ(modes_without_energy(model_of<2>(bent_body(0.1, 12, 2.5))), 3);
  EXPECT_EQ(modes_without_energy(model_of<2>(bent_body(0.1, 12, 2.5, true))), 3);
  EXPECT_EQ(modes_without_energy(model_of<3>(tube_body(1, 2, 0.1, 0, Shape::whole_turn, 0.45))), 6);
  EXPECT_EQ(modes_without_energy(model_of<3>(tube_body(1, 2, 0.1, 0.3, 2.2, 0.3))), 6);
}

/// A hollow ball of radius 1, each edge of the icosahedron cut into so many parts.
StructureBody ball_body(double thickness, int parts) {
  StructureBody body = bent_body(thickness, 40);
  body.poisson_ratio = 0.3;
  Shape outer;
  outer.kind = Shape::Kind::ball;
  outer.radius = 1 + 0.5 * thickness;
  Shape inner = outer;
  inner.radius = 1 - 0.5 * thickness;
  body.shape = Shape{};
  body.shape.kind = Shape::Kind::difference;
  body.shape.parts = {outer, inner};
  body.spacing = std::sqrt(4 * std::numbers::pi / (10 * parts * parts + 2));
  return body;
}

/// Squared frequency of a thin sphere in the lower of its motions with n waves (Junger and Feit), E/rho = 1e6, Poisson's ratio 0.3.
double squared_frequency_of_a_sphere(int n, double thickness) {
  constexpr double nu = 0.3;
  const double l = n * (n + 1), b = thickness * thickness / 12;
  const double p = 1 + 3 * nu + l - b * (1 - nu - l * l - nu * l);
  const double q = (l - 2) * (1 - nu * nu) + b * (l * l * l - 4 * l * l + l * (5 - nu * nu) - 2 * (1 - nu * nu));
  return 0.5 * (p - std::sqrt(p * p - 4 * q)) * 1e6 / (1 - nu * nu);
}

// Seen to fail: with the nearest neighbours alone.
TEST(Shell, AHollowBallMovesFreelyAsARigidOneAndSwingsAsAThinSphere) {
  auto model = model_of<3>(ball_body(0.1, 5));
  ASSERT_EQ(model.x.size(), 252u);
  double area = 0;
  for (const double a : model.layer.particles.area) area += a;
  EXPECT_NEAR(area, 4 * std::numbers::pi, 1e-12);
  const auto values = model.squared_frequencies(1e-6);
  for (int n = 0; n < 6; ++n) EXPECT_LT(std::abs(values[n]), 1e-6 * values[6]);
  for (int n = 6; n < 11; ++n) EXPECT_NEAR(std::sqrt(values[n] / squared_frequency_of_a_sphere(2, 0.1)), 0.9915, 2e-3) << n;
  for (int n = 11; n < 18; ++n) EXPECT_NEAR(std::sqrt(values[n] / squared_frequency_of_a_sphere(3, 0.1)), 0.944, 4e-3) << n;
}

// Seen to fail: with equal areas. u = p R^2 (1 - nu)/(2 E t) in the mean. Every load that is not quite even bends it: the force on a
// particle is that on its triangles.
TEST(Shell, AHollowBallUnderPressureGrowsAsAThinSphere) {
  auto model = model_of<3>(ball_body(0.1, 5));
  constexpr double stiffness = 1e9 * 0.1, p = 1e-6 * stiffness, exact = p * 0.7 / (2 * stiffness);
  model.load = [&](const auto& m, auto& force) {
    for (std::size_t i = 0; i < force.size(); ++i) {
      const Vector<3>& place = m.layer.particles.position[i];
      force[i] += m.layer.particles.area[i] * (p * place - 1e-4 * stiffness * (m.x[i] - place));  // and a soft spring against rigid motions
    }
  };
  model.newton(1e-6);
  double mean = 0, farthest = 0;
  std::vector<double> grown;
  for (std::size_t i = 0; i < model.x.size(); ++i)
    grown.push_back((model.x[i].norm() - 1) / exact), mean += grown.back() / static_cast<double>(model.x.size());
  for (const double g : grown) farthest = std::max(farthest, std::abs(g - mean));
  EXPECT_NEAR(mean, 1, 2e-3);
  EXPECT_LT(farthest, 0.2);
}

TEST(Shell, ABallThatIsHeldOrTooCoarseForWhatBendsOnItIsRefused) {
  StructureBody ball = ball_body(0.1, 5);
  EXPECT_NO_THROW(mid_surface<3>(ball));
  ball.clamps = {Shape{}};
  EXPECT_THROW(mid_surface<3>(ball), BadInput);
  ball.clamps.clear();
  ball.spacing = 0.45;
  EXPECT_THROW(mid_surface<3>(ball), BadInput);
  ball.spacing = 0.93 * std::sqrt(0.1);
  EXPECT_NO_THROW(mid_surface<3>(ball));
  ball.shape.parts[1].center = {0.01, 0, 0};
  EXPECT_THROW(mid_surface<3>(ball), BadInput);
}

TEST(Shell, AStraightLineAtAnAngleIsThePlateTurned) {
  StructureBody body = bent_body(0.004, 18);
  body.shape.kind = Shape::Kind::line;
  body.shape.vertices = {{0.1, 0.2}, {0.1 + 0.09 * 0.6, 0.2 + 0.09 * 0.4}, {0.1 + 0.09 * 0.8, 0.2 + 0.09 * 0.4 * 0.8 / 0.6}};
  body.spacing = 0.005;
  const auto bent = model_of<2>(body).squared_frequencies(1e-9);
  const double length = 0.09 * 0.8 * std::sqrt(1 + 4.0 / 9);
  auto straight = line(length, 0.004, static_cast<int>(std::lround(length / 0.005)), shell_material(1e9, 0), Edge::free);
  const auto expected = straight.squared_frequencies(1e-9);
  EXPECT_NEAR(bent[3] / expected[3], 1, 1e-6);
}

TEST(Shell, APathWithASharpCornerIsRefusedByName) {
  StructureBody body = bent_body(0.01, 40);
  body.shape.kind = Shape::Kind::line;
  body.shape.vertices = {{0, 0}, {1, 0}, {1, 1}};
  body.spacing = 0.05;
  try {
    mid_surface<2>(body);
    FAIL();
  } catch (const BadInput& fault) {
    EXPECT_NE(std::string(fault.what()).find("turns by 90 degrees within a spacing"), std::string::npos) << fault.what();
  }
  EXPECT_NO_THROW(mid_surface<2>(bent_body(0.1, 10)));
  EXPECT_THROW(mid_surface<2>(bent_body(0.1, 9)), BadInput);
  EXPECT_THROW(mid_surface<2>(bent_body(0.1, 9, Shape::whole_turn, true)), BadInput);
}

// A spiral of two turns. Seen to fail: with all particles within reach in space.
TEST(Shell, PartsOfALayerThatLieOverEachOtherAreNoNeighbours) {
  StructureBody body = bent_body(1e-3, 40);
  body.shape.kind = Shape::Kind::line;
  for (int n = 0; n <= 400; ++n) {
    const double angle = 4 * std::numbers::pi * n / 400, r = 1 + 0.01 * angle;
    body.shape.vertices.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  const auto model = model_of<2>(body);
  for (std::size_t i = 0; i < model.layer.size(); ++i)
    for (auto n = model.layer.first[i]; n < model.layer.first[i + 1]; ++n)
      EXPECT_LE(std::abs(static_cast<int>(model.layer.neighbour[n]) - static_cast<int>(i)), 2);
}

TEST(Shell, OnlyRigidMotionsAreFree) {
  EXPECT_EQ(modes_without_energy(sample<2>("st_venant_kirchhoff", Edge::free)), 3);
  EXPECT_EQ(modes_without_energy(sample<3>("st_venant_kirchhoff", Edge::free)), 6);
}

double frequency_of_the_paper_plate(int count) {
  auto material = shell_material(3.5e6, 0.45);
  material.density = 1161.54;
  auto model = line(0.09, 0.004, count, material, Edge::clamp);
  return std::sqrt(model.squared_frequencies(1e-9)[0]) / (2 * std::numbers::pi);
}

// Euler and Bernoulli: 4.9035 Hz.
TEST(Shell, FirstFrequencyOfAClampedPlateConvergesInSecondOrderToThinPlateTheory) {
  const double coarse = frequency_of_the_paper_plate(9) / 4.9035 - 1, fine = frequency_of_the_paper_plate(18) / 4.9035 - 1;
  EXPECT_LT(std::abs(coarse), 3e-3);
  EXPECT_LT(std::abs(fine), 1e-3);
  EXPECT_GT(std::log2(coarse / fine), 1.7);
}

/// First bending frequency over that of Euler and Bernoulli, which is (root/L)^2 sqrt(EI/(rho t)). `rigid`: motions without energy.
double first_bending_frequency(int count, Edge low, Edge high, double root, int rigid) {
  constexpr double t = 1e-3;
  auto model = line(1, t, count, shell_material(1e9, 0), low, high);
  return std::sqrt(model.squared_frequencies(1e-7)[rigid]) / (root * root * std::sqrt(1e9 * t * t / 12 / 1000));
}

TEST(Shell, HingedLinesSwingAtTheFrequenciesOfThinBeamTheory) {
  EXPECT_NEAR(first_bending_frequency(18, Edge::hinge, Edge::hinge, std::numbers::pi, 0), 1, 3e-3);
  EXPECT_NEAR(first_bending_frequency(18, Edge::hinge, Edge::free, 3.926602, 1), 1, 2e-3);
  EXPECT_NEAR(first_bending_frequency(18, Edge::clamp, Edge::hinge, 3.926602, 0), 1, 7e-3);
  const double coarse = first_bending_frequency(9, Edge::clamp, Edge::hinge, 3.926602, 0) - 1;
  const double fine = first_bending_frequency(36, Edge::clamp, Edge::hinge, 3.926602, 0) - 1;
  EXPECT_GT(0.5 * std::log2(coarse / fine), 1.7);
}

double first_axial_frequency(int count, Edge edge) {
  auto model = line(1, 0.01, count, shell_material(1e6, 0), edge);
  for (std::size_t i = 0; i < model.x.size(); ++i) model.is_fixed[2 * i + 1] = true;
  return std::sqrt(model.squared_frequencies(1e-7)[0]) / (0.5 * std::numbers::pi * std::sqrt(1e6 / 1000));
}
// Seen to fail: with no cell of the line at its hinge, where every other particle then gives way (0.78).
TEST(Shell, AClampAndAHingeHoldTheStretch) {
  for (const Edge edge : {Edge::clamp, Edge::hinge}) {
    const double frequency = first_axial_frequency(18, edge);
    std::printf("[ %.4f ]\n", frequency);
    EXPECT_NEAR(frequency, 1, 0.02);
  }
}

/// Deflection of the middle of a square plate under a pressure, times D/(q L^4).
double middle_of_a_square(int count, Edge edge) {
  auto model = plate({1, 1}, 0.01, {count, count}, shell_material(1e9, 0.3), {edge, edge, edge, edge});
  constexpr double q = 1e-3;
  model.load = [](const auto& m, auto& force) {
    for (std::size_t i = 0; i < force.size(); ++i) force[i][2] += q * m.layer.particles.area[i];
  };
  for (std::size_t k = 0; k < model.is_fixed.size(); ++k)
    if (k % 3 != 2) model.is_fixed[k] = true;
  model.newton(1e-7);
  const double rigidity = 1e9 * 1e-6 / (12 * (1 - 0.09));
  return model.x[model.x.size() / 2][2] * rigidity / q;
}

TEST(Shell, SquarePlatesClampedAndSimplySupportedApproachThinPlateTheory) {
  EXPECT_NEAR(middle_of_a_square(15, Edge::clamp), 0.001336, 2e-6);  // .0012653 in the limit
  EXPECT_NEAR(middle_of_a_square(15, Edge::hinge), 0.004111, 2e-6);  // .00406
}

/// Largest deflection of a line of length 1 under a uniform load, over the load, times EI.
double sag(int count, Edge low, Edge high) {
  constexpr double t = 1e-3, ei = 1e9 * t * t * t / 12;
  auto model = line(1, t, count, shell_material(1e9, 0), low, high);
  model.load = [](const auto& m, auto& force) {
    for (std::size_t i = 0; i < force.size(); ++i) force[i][1] += 1e-6 * m.layer.particles.area[i];
  };
  for (std::size_t i = 0; i < model.x.size(); ++i) model.is_fixed[2 * i] = true;
  model.newton(1e-7);
  double largest = 0;
  for (const auto& x : model.x) largest = std::max(largest, std::abs(x[1]));
  return largest * ei / 1e-6;
}

TEST(Shell, ALineBetweenHingesOrAClampAndAHingeSagsAsItShould) {
  EXPECT_NEAR(sag(39, Edge::hinge, Edge::hinge) * 384 / 5, 1, 2e-3);
  EXPECT_NEAR(sag(39, Edge::clamp, Edge::hinge) * 184.6, 1, 5e-3);
}

/// Rows of the free end of a line: x(tip) = sum_j position_j x_j, x'(tip) = sum_j slope_j x_j.
struct Tip {
  std::vector<double> position, slope;

  explicit Tip(const ShellLayer<2>& layer) : position(layer.size(), 0), slope(layer.size(), 0) {
    const std::size_t last = layer.size() - 1;
    const double xi = 0.5 * layer.particles.spacing[0];
    position[last] = 1;
    for (auto n = layer.first[last]; n < layer.first[last + 1]; ++n) {
      const double r = xi * layer.weight[n][0] + 0.5 * xi * xi * layer.weight[n][1], d = layer.weight[n][0] + xi * layer.weight[n][1];
      position[layer.neighbour[n]] += r;
      position[last] -= r;
      slope[layer.neighbour[n]] += d;
      slope[last] -= d;
    }
  }
  static Vector<2> sum(const std::vector<double>& row, const std::vector<Vector<2>>& x) {
    Vector<2> total = Vector<2>::Zero();
    for (std::size_t j = 0; j < x.size(); ++j) total += row[j] * x[j];
    return total;
  }
};

/// Tip of an inextensible cantilever of length 1 under a transverse load k EI at its tip: theta'' = -k cos theta by shooting.
Vector<2> elastica(double k) {
  const auto shoot = [k](double slope) {
    std::array<double, 4> y{0, slope, 0, 0};  // theta, theta', x, y
    const auto rate = [k](const std::array<double, 4>& s) {
      return std::array<double, 4>{s[1], -k * std::cos(s[0]), std::cos(s[0]), std::sin(s[0])};
    };
    constexpr int steps = 2000;
    constexpr double h = 1.0 / steps;
    const auto plus = [](std::array<double, 4> s, double f, const std::array<double, 4>& r) {
      for (int n = 0; n < 4; ++n) s[n] += f * r[n];
      return s;
    };
    for (int n = 0; n < steps; ++n) {
      const auto a = rate(y), b = rate(plus(y, h / 2, a)), c = rate(plus(y, h / 2, b)), d = rate(plus(y, h, c));
      for (int m = 0; m < 4; ++m) y[m] += h / 6 * (a[m] + 2 * b[m] + 2 * c[m] + d[m]);
    }
    return y;
  };
  double low = 0, high = 2 * std::sqrt(k) + k;
  for (int n = 0; n < 80; ++n) (shoot(0.5 * (low + high))[1] > 0 ? high : low) = 0.5 * (low + high);
  const auto y = shoot(low);
  return {y[2], y[3]};
}

TEST(Shell, ACantileverUnderATipLoadFollowsTheElastica) {
  constexpr double t = 1e-3, ei = 1e9 * t * t * t / 12;
  auto model = line(1, t, 20, shell_material(1e9, 0), Edge::clamp);
  const Tip tip(model.layer);
  double k = 0;
  model.load = [&](const auto&, auto& force) {
    for (std::size_t j = 0; j < force.size(); ++j) force[j][1] += tip.position[j] * k * ei;
  };
  for (const double target : {1.0, 2.0, 5.0, 10.0}) {
    const double from = k;
    for (int n = 1; n <= 10; ++n) {
      k = from + (target - from) * n / 10;
      int iterations = 0;
      while (model.newton(1e-7) > 1e-9 && ++iterations < 30) {}
      ASSERT_LT(iterations, 30) << k;
    }
    EXPECT_LT((Tip::sum(tip.position, model.x) - elastica(k)).cwiseAbs().maxCoeff(), 3e-3) << k;
  }
}

TEST(Shell, AnEndMomentRollsALineUpToACircle) {
  constexpr double t = 1e-3, ei = 1e9 * t * t * t / 12;
  auto model = line(1, t, 40, shell_material(1e9, 0), Edge::clamp);
  const Tip tip(model.layer);
  double moment = 0;
  model.load = [&](const auto& m, auto& force) {
    const Vector<2> a = Tip::sum(tip.slope, m.x), conjugate = moment / a.squaredNorm() * Vector<2>(-a[1], a[0]);
    for (std::size_t j = 0; j < force.size(); ++j) force[j] += tip.slope[j] * conjugate;
  };
  for (int n = 1; n <= 40; ++n) {
    moment = 2 * std::numbers::pi * ei * n / 40;
    int iterations = 0;
    while (model.newton(1e-7) > 1e-9 && ++iterations < 30) {}
    ASSERT_LT(iterations, 30) << n;
  }
  EXPECT_LT((Tip::sum(tip.position, model.x) - model.x[0]).norm(), 0.01);
}

/// Vertical deflection in the middle of the free edge over that of Scordelis and Lo.
double scordelis_lo(int count) {
  constexpr double radius = 25, length = 50, half_angle = 40 * std::numbers::pi / 180, t = 0.25, up = 0.5 * std::numbers::pi;
  MidSurface<3> surface = mid_surface<3>(tube_body(radius, length, t, up - half_angle, up + half_angle, 2 * half_angle * radius / count));
  surface.count = {count, count};
  surface.edges[0] = {Edge::hinge, Edge::hinge};
  ShellModel<3> model(make_shell_layer<3>("roof", shell_particles(surface), Material(shell_material(4.32e8, 0)), t));
  for (std::size_t i = 0; i < model.x.size(); ++i) model.is_fixed[3 * i] = false;
  model.is_fixed[3 * (count / 2) * (count + 2)] = true;
  model.load = [](const auto& m, auto& force) {
    for (std::size_t i = 0; i < force.size(); ++i) force[i][2] -= 1e-3 * 90 * m.layer.particles.area[i];
  };
  model.newton(1e-5);
  // The middle is between two particles when their number is even, and the edge half a spacing beyond the last.
  const auto sag = [&](int around) {
    double sum = 0;
    for (const int along : {(count + 1) / 2, (count + 2) / 2}) {
      const std::size_t i = around * (count + 2) + along;
      sum += 0.5e3 * (model.layer.particles.position[i] - model.x[i])[2];
    }
    return sum;
  };
  return (1.875 * sag(0) - 1.25 * sag(1) + 0.375 * sag(2)) / 0.3024;
}

TEST(Shell, TheRoofOfScordelisAndLoSagsAsItShould) { EXPECT_NEAR(scordelis_lo(20), 1.03, 0.01); }

TEST(Shell, AMaterialWithoutALawOfALayerAndALineOfTwoParticlesAreRefused) {
  EXPECT_THROW(line(1, 0.01, 8, shell_material(1e6, 0.3, "mooney_rivlin"), Edge::clamp), BadInput);
  EXPECT_THROW(line(1, 0.01, 2, shell_material(1e6, 0.3), Edge::free), BadInput);
}

}  // namespace
}  // namespace tern::structure::testing
