// Pressure beside a surface that yields in lumps: a light plate of particles' thickness between two waters.

#include <gtest/gtest.h>

#include <numeric>

#include "fixtures/fluid_scenes.hpp"
#include "fluid/pressure/divergence.hpp"
#include "fluid/pressure/yielding_surface.hpp"

namespace tern::fluid::testing {
namespace {

constexpr double dx = 0.0125, thickness = dx, length = 0.5, dt = 1e-3;
constexpr double plate_mass = 8;  ///< [kg/m^2]: a layer of water particles has 12.5, the water beside the plate some 100

/// Left and right face of a plate that stands in the middle of the tank, two points a spacing.
Surface<2> plate() {
  Surface<2> surface;
  for (const double side : {-1.0, 1.0})
    for (double y = 0.25 * dx; y < length; y += 0.5 * dx) {
      surface.position.push_back({side * 0.5 * thickness, y});
      surface.velocity.push_back({0, 0});
      surface.normal.push_back({side, 0});
      surface.area.push_back(0.5 * dx);
    }
  return surface;
}

/// Water on both sides, of these depths, its pressure solved to this key.
Fluid<2> waters(double left, double right, double tolerance = 1e-6) {
  Case c = scene(2, dx, {box({-0.5, 0, 0}, {-0.5 * thickness, left, 0}), box({0.5 * thickness, 0, 0}, {0.5, right, 0})},
                 {tank({-0.5, 0, 0}, {0.5, 1, 0})});
  c.fluid->numerics.density_relaxation = 0;
  c.fluid->numerics.pressure_tolerance = tolerance;
  return Fluid<2>(c);
}

enum class Yields { not_at_all, by_points, by_points_of_whole_sections, by_sections };

/// The plate's points, each a lump of half a section or of a whole one, or lumps of whole sections: both faces at a height.
SurfaceResponse response(Yields yields, const Surface<2>& surface) {
  const std::size_t points = surface.position.size(), lumps = yields == Yields::by_sections ? points / 2 : points;
  if (yields == Yields::not_at_all) return {};
  SurfaceResponse made{std::vector<std::uint32_t>(points), std::vector<double>(points, 1), std::vector<double>(lumps)};
  for (std::size_t k = 0; k < points; ++k) {
    made.lump[k] = static_cast<std::uint32_t>(k % lumps);
    made.mass[k % lumps] += (yields == Yields::by_points_of_whole_sections ? 1 : 0.5) * plate_mass * surface.area[k];
  }
  return made;
}

/// Pressure after one solve at rest.
Fluid<2> solved(double left, double right, Yields yields) {
  Fluid<2> fluid = waters(left, right);
  const Surface<2> surface = plate();
  fluid.begin_window(0, to_ticks(dt));
  const auto particles = fluid.see_surface(surface);
  InterfaceCondition<2> load;
  load.force.assign(particles.id.size(), Vector<2>::Zero());
  load.reference_pressure.assign(surface.position.size(), 0);
  load.response = response(yields, surface);
  fluid.solve_pressure(load);
  return fluid;
}

double mean_pressure(const Fluid<2>& fluid, double side) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < fluid.state().size(); ++i)
    if (side * fluid.state().position[i][0] > 0) sum += fluid.state().pressure[i], ++count;
  return sum / count;
}

// Equal pressures on both faces do not move a plate whose faces answer together, however light it is: the water has the pressure that it
// has beside a plate which does not move. Faces that answer one by one give way.
// Seen to fail: with lumps of the points in place of the sections; with kappa in place of R in the equation.
TEST(YieldingSurface, IsNotMovedByEqualPressuresOnBothFaces) {
  const double rigid = mean_pressure(solved(length, length, Yields::not_at_all), 1);
  EXPECT_NEAR(rigid, 0.5 * density * gravity * length, 0.02 * density * gravity * length);
  for (const double side : {-1.0, 1.0}) {
    EXPECT_NEAR(mean_pressure(solved(length, length, Yields::by_sections), side), rigid, 1e-4 * rigid);
    EXPECT_LT(mean_pressure(solved(length, length, Yields::by_points), side), 0.9 * rigid);
  }
}

// Water on one side alone accelerates the plate with it. A lump of both faces then answers like points of one that have all of its mass.
// Seen to fail: with lumps of four times their mass in the solver.
TEST(YieldingSurface, AnswersByTheMassOfItsLumps) {
  const double right = 0.5 * dx, rigid = mean_pressure(solved(length, right, Yields::not_at_all), -1);
  const double sections = mean_pressure(solved(length, right, Yields::by_sections), -1);
  EXPECT_LT(sections, 0.8 * rigid);
  EXPECT_NEAR(mean_pressure(solved(length, right, Yields::by_points_of_whole_sections), -1), sections, 0.02 * rigid);
  std::printf("[ %.3f, by points %.3f of the pressure beside a wall ]\n", sections / rigid,
              mean_pressure(solved(length, right, Yields::by_points_of_whole_sections), -1) / rigid);
}

// Where both faces are wet the matrix' diagonal bound is far above what the plate does, and the preconditioner has to know.
// Seen to fail: 18 and 26 iterations with the bound alone in the operators of the grids.
TEST(YieldingSurface, TakesFewIterations) {
  for (const Yields yields : {Yields::not_at_all, Yields::by_points, Yields::by_sections})
    for (const double right : {0.5 * length, length}) {
      const SolveResult solve = solved(length, right, yields).last_solve();
      std::printf("[ %d, %.2f m on the right: %d iterations ]\n", static_cast<int>(yields), right, solve.iterations);
      EXPECT_TRUE(solve.converged);
      EXPECT_LE(solve.iterations, 10);
    }
}

// A point gives way to all pressures before it together, be it a lump alone or a part of one.
// Seen to fail: with kappa for the answer of a lump that is one point (1.6 of the answer).
TEST(YieldingSurface, GivesWayToWhatPushesItAltogether) {
  for (const Yields yields : {Yields::by_points, Yields::by_sections}) {
    const Fluid<2> fluid = solved(length, length, yields);
    std::vector<int> at_structure;
    for (std::size_t i = 0; i < fluid.state().size(); ++i)
      if (fluid.boundary().sees_structure(static_cast<std::ptrdiff_t>(i))) at_structure.push_back(static_cast<int>(i));
    Prediction<2> prediction;
    prediction.position = fluid.state().position;
    prediction.gravity.assign(fluid.state().size(), Vector<2>::Zero());
    YieldingSurface<2> surface;
    surface.assemble(fluid.constants(), {}, response(yields, plate()), fluid.boundary(), fluid.state().particle_class, prediction,
                     at_structure);
    std::vector<double> x(fluid.state().size(), 0), answer = x, expected = x;
    for (std::size_t m = 0; m < at_structure.size(); ++m) x[at_structure[m]] = std::sin(3.7 * static_cast<double>(m * m));
    surface.add_difference(at_structure, x, answer);
    for (std::size_t m = 0; m < at_structure.size(); ++m)
      answer[at_structure[m]] += surface.bound(static_cast<std::ptrdiff_t>(m)) * x[at_structure[m]];
    for (std::size_t a = 0; a < surface.lumps(); ++a) {
      Vector<2> push = Vector<2>::Zero();
      surface.for_rows(a, [&](int m, const Vector<2>& c) { push += c * x[at_structure[m]]; });
      surface.for_rows(a, [&](int m, const Vector<2>& c) { expected[at_structure[m]] += surface.scale(a) * c.dot(push); });
    }
    double error = 0, largest = 0;
    for (const int i : at_structure) {
      error = std::max(error, std::abs(answer[i] - expected[i]));
      largest = std::max(largest, std::abs(expected[i]));
    }
    EXPECT_GT(largest, 0);
    EXPECT_LT(error, 1e-12 * largest);
  }
}

// The particles before one face fill more of its half space than those before the other. A level of the pressure pushes lumps as its loads
// do, which cancel; of the motion the rows count what the particles fill.
// Seen to fail: with half of what makes the sums up in the force and half in the motion (0.02 of the push of one face).
TEST(YieldingSurface, IsPushedAsByLoadsAndCountedByWhatParticlesFill) {
  Fluid<2> fluid = waters(length, length);
  Surface<2> surface = plate();
  for (Vector<2>& x : surface.position)
    if (x[0] < 0) x[0] -= 0.2 * dx;  // towards the water
  fluid.begin_window(0, to_ticks(dt));
  fluid.see_surface(surface);
  const Boundary<2>& boundary = fluid.boundary();
  std::vector<int> at_structure;
  for (std::size_t i = 0; i < fluid.state().size(); ++i)
    if (boundary.sees_structure(static_cast<std::ptrdiff_t>(i))) at_structure.push_back(static_cast<int>(i));
  Prediction<2> prediction;
  prediction.position = fluid.state().position;
  prediction.gravity.assign(fluid.state().size(), Vector<2>::Zero());
  YieldingSurface<2> yielding;
  yielding.assemble(fluid.constants(), {}, response(Yields::by_sections, surface), boundary, fluid.state().particle_class, prediction,
                    at_structure);
  double uneven = 0, pushed = 0, one_face = 0;
  std::vector<double> filled(surface.position.size(), 0), x(fluid.state().size(), 0), counted = x, expected = x;
  for (std::size_t a = 0; a < yielding.lumps(); ++a) {
    if (surface.position[a][1] > length - 3 * dx) continue;  // less is wet at the end
    Vector<2> sum = Vector<2>::Zero();
    yielding.for_rows(a, [&](int, const Vector<2>& c) { sum += c; });
    pushed = std::max(pushed, sum.norm());
    one_face = std::max(one_face, surface.area[a]);
  }
  for (std::size_t m = 0; m < at_structure.size(); ++m) x[at_structure[m]] = std::sin(3.7 * static_cast<double>(m * m));
  const FaceRows& rows = boundary.surface_rows;
  const auto visit_faces = [&](int i, const auto& visit) {
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry)
      visit(rows.face[entry], 2 * fluid.constants().volume * rows.weight[entry]);
  };
  for (const int i : at_structure) visit_faces(i, [&](int k, double weight) { filled[k] += weight / surface.area[k]; });
  for (std::size_t k = 0; k < filled.size() / 2; ++k) uneven = std::max(uneven, std::abs(filled[k] - filled[k + filled.size() / 2]));
  std::vector<Vector<2>> motion(yielding.lumps(), Vector<2>::Zero());
  for (std::size_t a = 0; a < yielding.lumps(); ++a)
    yielding.for_rows(a, [&](int m, const Vector<2>& c) { motion[a] += yielding.scale(a) * x[at_structure[m]] * c; });
  for (const int i : at_structure)
    visit_faces(i, [&](int k, double weight) { expected[i] += weight * surface.normal[k].dot(motion[k % yielding.lumps()]); });
  yielding.subtract_motion(std::vector<double>(surface.position.size(), 0), boundary, at_structure, x, counted);
  double error = 0, largest = 0;
  for (const int i : at_structure) {
    error = std::max(error, std::abs(counted[i] - expected[i]));
    largest = std::max(largest, std::abs(expected[i]));
  }
  std::printf("[ filled apart by %.2f, push %.1e of that of one face, counted within %.1e ]\n", uneven, pushed / one_face, error / largest);
  EXPECT_GT(uneven, 0.02);
  EXPECT_LT(pushed, 1e-12 * one_face);
  EXPECT_LT(error, 1e-12 * largest);
}

/// A window with this force on each particle at the plate, `times` times.
Fluid<2> pushed(const Vector<2>& force, int times) {
  Fluid<2> fluid = waters(0.4, 0.4);
  const Surface<2> surface = plate();
  fluid.begin_window(0, to_ticks(dt));
  const auto particles = fluid.see_surface(surface);
  InterfaceCondition<2> load;
  load.force.assign(particles.id.size(), force);
  load.reference_pressure.assign(surface.position.size(), 0);
  load.repeats = times > 1;
  for (int n = 0; n < times; ++n) {
    fluid.solve_pressure(load);
    load.surface_velocity = surface.velocity;
  }
  return fluid;
}

/// Pressures at the plate in the second window, by coupling iteration: the plate stands, then it has these velocities in turn.
std::vector<std::vector<double>> answers_to(const std::vector<double>& speeds, double tolerance, double answer_tolerance) {
  Fluid<2> fluid = waters(0.4, 0.3, tolerance);
  const Surface<2> surface = plate();
  std::vector<std::vector<double>> answers;
  for (const bool repeats : {false, true}) {
    fluid.begin_window(fluid.state().time, to_ticks(dt));
    InterfaceCondition<2> load;
    load.force.assign(fluid.see_surface(surface).id.size(), Vector<2>::Zero());
    load.reference_pressure.assign(surface.position.size(), 0);
    load.response = response(Yields::by_sections, surface);
    load.repeats = repeats;
    load.answer_tolerance = answer_tolerance;
    InterfacePressure<2> pressure = fluid.solve_pressure(load);
    if (repeats) answers.push_back(pressure.pressure);
    for (std::size_t n = 0; repeats && n < speeds.size(); ++n) {
      load.surface_velocity.assign(surface.position.size(), Vector<2>(speeds[n], 0));
      answers.push_back(fluid.solve_pressure(load).pressure);
    }
    if (!repeats) fluid.end_window({std::vector<Vector<2>>(pressure.pressure.size(), Vector<2>::Zero())});
  }
  return answers;
}

/// The largest error of these answers, of what they have changed by so far in their window.
double largest_error(double answer_tolerance) {
  const std::vector<double> speeds = {0.3, 0.3001, -0.2, 0.0};
  const auto found = answers_to(speeds, 1e-6, answer_tolerance), exact = answers_to(speeds, 1e-13, 0);
  const auto apart = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(sum / static_cast<double>(a.size()));
  };
  double changed = apart(exact[0], std::vector<double>(exact[0].size(), 0)), largest = 0;
  for (std::size_t n = 0; n < found.size(); ++n) {
    if (n > 0) changed = n == 1 ? apart(exact[1], exact[0]) : std::max(changed, apart(exact[n], exact[n - 1]));
    const double error = apart(found[n], exact[n]);
    std::printf("[ iteration %zu: changed by %.3g Pa, error %.1e of it ]\n", n, changed, error / changed);
    largest = std::max(largest, error / changed);
  }
  return largest;
}

// What the fluid answers to a motion is that of the motion, whatever was tried before. Measured: 1.2e-5. Seen to fail: 1.8e-3 with a
// thousand times the tolerance, and a correction to a hundredth.
TEST(CouplingIteration, KnowsNothingOfWhatWasTriedBefore) { EXPECT_LT(largest_error(0), 1e-4); }

// But for the part of the change that the coupler says may be missed. Measured: 1.8e-3 (more than the bound above, so the solves do end
// sooner). Seen to fail: 1.3e-2 when asked for a tenth.
TEST(CouplingIteration, MissesNoMoreThanTheCouplerAllows) {
  const double missed = largest_error(0.01);
  EXPECT_GT(missed, 1e-4);
  EXPECT_LT(missed, 0.01);
}

// Forces change the divergence beside the plate, and only there it is computed anew. The change of the source is compared with the
// divergence of the change of velocity, computed of all particles. Seen to fail: with the rows of the particles at the plate alone (0.55 of
// the largest change).
TEST(ForcesAtTheStructure, ChangeTheSourceByTheirDivergence) {
  const Vector<2> force(3, 1);
  const Fluid<2> with = pushed(force, 1), without = pushed({0, 0}, 1);
  const std::size_t n = with.state().size();
  std::vector<Vector<2>> change(n, Vector<2>::Zero()), none = change;
  for (std::size_t i = 0; i < n; ++i)
    if (with.boundary().sees_structure(static_cast<std::ptrdiff_t>(i))) change[i] = dt / with.constants().mass * force;
  const auto divergence_of = [&](const std::vector<Vector<2>>& velocity) {
    ByAxis<2> packed;
    std::vector<double> divergence;
    compute_divergence<2>(with.period(), with.neighbours(), with.boundary(), with.correction(), with.state().particle_class, velocity,
                          nullptr, packed, divergence);
    return divergence;
  };
  const std::vector<double> after = divergence_of(change), before = divergence_of(none);
  double largest = 0, error = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!with.state().particle_class[i].pressure_unknown()) continue;
    const double expected = -with.constants().mass / dt * (after[i] - before[i]);
    const double found = with.pressure_source()[i] - without.pressure_source()[i];
    largest = std::max(largest, std::abs(expected));
    error = std::max(error, std::abs(found - expected));
  }
  std::printf("[ largest change %.3g, error %.1e of it ]\n", largest, error / largest);
  EXPECT_GT(largest, 0);
  EXPECT_LT(error, 1e-6 * largest);  // dt is rounded to whole ticks
}

// A window that is repeated beside the same surface has the source of the first time. Seen to fail: with the divergence that the first
// solve has left in place of that of u* (0.40).
TEST(ForcesAtTheStructure, MeetTheSameVelocityInARepeatedWindow) {
  const Fluid<2> once = pushed({3, 1}, 1), twice = pushed({3, 1}, 2);
  double change = 0, size = 0;
  for (std::size_t i = 0; i < once.state().size(); ++i) {
    change += std::pow(twice.pressure_source()[i] - once.pressure_source()[i], 2);
    size += std::pow(once.pressure_source()[i], 2);
  }
  std::printf("[ change of the source %.1e ]\n", std::sqrt(change / size));
  EXPECT_LT(std::sqrt(change / size), 1e-12);
}

}  // namespace
}  // namespace tern::fluid::testing
