// The state is complete: a structure that is given the state of another at a window's end goes on with the same bits.

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <optional>
#include <set>

#include "base/error.hpp"
#include "fixtures/structure_scenes.hpp"
#include "structure/coupled_structure.hpp"

namespace tern::structure::testing {
namespace {

// The bits of a field, whatever it is made of.

template <class T>
requires std::is_arithmetic_v<T>
void append(std::string& bits, const T& value) { bits.append(reinterpret_cast<const char*>(&value), sizeof value); }
void append(std::string& bits, const Lanes& value) { bits.append(reinterpret_cast<const char*>(&value), sizeof value); }
template <class Derived>
void append(std::string& bits, const Eigen::DenseBase<Derived>& values) {
  for (const double value : values.derived().reshaped()) append(bits, value);
}
void append(std::string& bits, const QuasiNewtonUpdate& update) {
  append(bits, update.moved);
  append(bits, update.change);
  append(bits, update.product);
}
void append(std::string& bits, const ImplicitCounts& counts) {
  for (const long count : {counts.steps, counts.failed, counts.evaluations, counts.factors}) append(bits, count);
}
void append(std::string& bits, const Evaluations& e) {
  for (const long count : {e.elastic_force, e.riemann_diffusion, e.loads, e.moving_clamps, e.windows_at_rest}) append(bits, count);
}
template <class T>
void append(std::string& bits, const std::vector<T>& values) {
  for (const T& value : values) append(bits, value);
}
template <class T, std::size_t n>
void append(std::string& bits, const std::array<T, n>& values) {
  for (const T& value : values) append(bits, value);
}
template <int D>
void append(std::string& bits, const Surface<D>& surface) {
  append(bits, surface.position);
  append(bits, surface.velocity);
  append(bits, surface.normal);
  append(bits, surface.area);
}

template <class State>
std::map<std::string, std::string> bits_of(const State& state) {
  std::map<std::string, std::string> bits;
  State::for_each_field([&](const char* name, const auto& value) { append(bits[name], value); }, state);
  return bits;
}

/// Names of the fields in which the states differ, one space after each.
template <class State>
std::string differences(const State& a, const State& b) {
  std::string names;
  const auto bits_a = bits_of(a), bits_b = bits_of(b);
  for (const auto& [name, bits] : bits_a)
    if (bits != bits_b.at(name)) names += name + " ";
  return names;
}

/// A strip that stands on a clamp, with diffusion, mass damping, weight, and a push at its tip in the first millisecond.
template <int D>
Case strip(Integrator integrator) {
  StructureBody b = body("strip", {0, 0, 0}, {0.003, 0.02, 0.003}, 0.001);
  b.clamps = {box({-1, -1, -1}, {1, 0.002, 1})};
  b.mass_damping = 5;
  Case c = scene(D, {b});
  c.gravity[1] = Expression(-9.81);
  c.structure->numerics.integrator = integrator;
  LoadCase load;
  load.kind = LoadCase::Kind::traction;
  load.body = "strip";
  load.region = box({-1, 0.016, -1}, {0.0005, 1, 1});
  load.value[0] = Expression("t < 1e-3 ? 400 : 0");
  c.structure->loads.push_back(load);
  return c;
}

/// The same, its clamp shaken.
Case shaken(Integrator integrator) {
  Case c = strip<2>(integrator);
  c.structure->bodies[0].clamps.clear();
  ClampCase clamp;
  clamp.name = "foot";
  clamp.body = "strip";
  clamp.region = box({-1, -1, -1}, {1, 0.002, 1});
  clamp.motion.emplace();
  clamp.motion->displacement[0] = Expression("1e-4*sin(2000*t)");
  c.structure->clamps.push_back(clamp);
  c.structure->bodies[0].clamps.push_back(clamp.region);
  return c;
}

/// The shaken strip in water, its clamp turned to and fro.
Case turned_under_water() {
  Case c = shaken(Integrator::explicit_steps);
  c.structure->clamps[0].motion->rotation = Expression("0.01*sin(2000*t)");
  WallCase tank;
  tank.name = "tank";
  tank.container = true;
  tank.shape = box({-0.1, -0.01, 0}, {0.1, 0.1, 0});
  c.walls = {tank};
  c.fluid.emplace().spacing = 0.002;
  return c;
}

/// A plate whose tip is shot off: so restless that its implicit steps pause.
Case struck() {
  Case c = plate();
  c.structure->numerics.integrator = Integrator::automatic;
  c.structure->bodies[0].velocity[0] = Expression("y > 0.08 ? 40 : 0");
  return c;
}

/// The shaken strip as a shell, its clamp turned to and fro.
Case turned(Integrator integrator = Integrator::explicit_steps) {
  Case c = shaken(integrator);
  c.structure->bodies[0].is_shell = true;
  c.structure->bodies[0].spacing = 0.003;
  c.structure->clamps[0].motion->rotation = Expression("0.01*sin(2000*t)");
  return c;
}

/// Nothing holds or loads it after the push: whether it has been touched is a matter of its state alone.
Case free_strip() {
  Case c = strip<2>(Integrator::explicit_steps);
  c.structure->bodies[0].clamps.clear();
  c.structure->bodies[0].mass_damping = 0;
  c.gravity[1] = Expression(0.0);
  return c;
}

/// One window as the coupling makes it: a trial, an iteration, and the load that counts.
template <int D>
void window(Structure<D>& structure, Ticks duration, int n) {
  structure.trial(structure.time(), duration);
  for (const double part : {0.5, 1.0}) {
    SurfaceLoad<D> load = structure.load();
    for (std::size_t k = 0; k < load.force.size(); ++k)
      load.force[k].setConstant(n % 4 == 3 ? 0 : part * 1e-4 * std::sin(n + 0.1 * double(k)));
    structure.advance(load);
  }
}

struct Windows {
  double window_s;
  int before, after;  // windows up to the state that is copied, and from there
};

/// Fields in which a run that was continued by another structure differs from one that was not; `left_out` was not copied.
template <int D>
std::string differences_after_continuation(const Case& c, const Windows& run, const std::string& left_out = "") {
  const Ticks duration = to_ticks(run.window_s);
  Structure<D> whole(c), continued(c);
  for (int n = 0; n < run.before; ++n) window(whole, duration, n);
  const CompleteState<D> given = whole.state();
  CompleteState<D> state = continued.state();
  CompleteState<D>::for_each_field(
      [&](const char* name, const auto& source, auto& target) {
        if (name != left_out) target = source;
      },
      given, state);
  try {
    continued.set_state(state);
    if (continued.surface_velocity() != whole.surface_velocity()) return "velocity of the surface";
    const std::string& name = c.structure->bodies[0].name;
    if (continued.reaction(name, "", {}).force != whole.reaction(name, "", {}).force) return "reaction";
    for (int n = run.before; n < run.before + run.after; ++n) {
      window(whole, duration, n);
      window(continued, duration, n);
    }
  } catch (const Error& error) {
    return error.what();
  }
  return differences(whole.state(), continued.state());
}

constexpr Windows forty_sub_steps{1e-4, 12, 12};

TEST(Continuation, OfAStructureHasTheSameBitsWithEveryIntegrator) {
  for (const Integrator integrator : {Integrator::explicit_steps, Integrator::implicit_steps, Integrator::automatic}) {
    EXPECT_EQ(differences_after_continuation<2>(strip<2>(integrator), forty_sub_steps), "") << static_cast<int>(integrator);
    EXPECT_EQ(differences_after_continuation<3>(strip<3>(integrator), {1e-4, 4, 3}), "") << static_cast<int>(integrator);
    EXPECT_EQ(differences_after_continuation<2>(shaken(integrator), forty_sub_steps), "") << static_cast<int>(integrator);
  }
  EXPECT_EQ(differences_after_continuation<2>(free_strip(), forty_sub_steps), "");
  EXPECT_EQ(differences_after_continuation<2>(turned(), forty_sub_steps), "");
  EXPECT_EQ(differences_after_continuation<2>(turned(Integrator::implicit_steps), forty_sub_steps), "");
  EXPECT_EQ(differences_after_continuation<2>(turned_under_water(), forty_sub_steps), "");
}

TEST(Continuation, OfAStructureHasTheSameBitsForEveryMaterial) {
  for (const std::string& material : material_keys())
    for (const bool plane_stress : {false, true})
      for (const Integrator integrator : {Integrator::explicit_steps, Integrator::implicit_steps}) {
        Case c = strip<2>(integrator);
        c.structure->bodies[0].material = material;
        c.structure->bodies[0].plane_stress = plane_stress;
        EXPECT_EQ(differences_after_continuation<2>(c, {1e-4, 5, 5}), "") << material;
      }
}

/// Windows of which only one in fifty is worth an implicit step, and that one comes after the copy.
Windows rare_implicit_windows(const Case& c) {
  const Structure<2> structure(c);
  return {15 * structure.largest_sub_step(), 46, 6};
}

TEST(Continuation, ChoosesTheIntegratorAsTheUndividedRun) {
  const Case c = strip<2>(Integrator::automatic);
  EXPECT_EQ(differences_after_continuation<2>(c, rare_implicit_windows(c)), "");
}

// What shows that each field of the list is needed: without it the run goes on differently in one of the scenes at least.
TEST(Continuation, NeedsEveryFieldOfTheState) {
  const Case rare = strip<2>(Integrator::automatic);
  const std::vector<std::pair<Case, Windows>> scenes = {{strip<2>(Integrator::explicit_steps), {1e-4, 3, 2}},
                                                        {strip<2>(Integrator::implicit_steps), {1e-4, 12, 3}},
                                                        {shaken(Integrator::implicit_steps), {1e-4, 3, 2}},
                                                        // More iterations than a new factor needs.
                                                        {shaken(Integrator::implicit_steps), {5e-4, 6, 2}},
                                                        {shaken(Integrator::implicit_steps), {1e-3, 11, 2}},
                                                        {free_strip(), {1e-3, 3, 1}},
                                                        {turned(), {1e-4, 3, 2}},
                                                        {turned_under_water(), {1e-4, 3, 2}},
                                                        {rare, rare_implicit_windows(rare)},
                                                        {rare, {rare_implicit_windows(rare).window_s, 50, 2}},
                                                        {struck(), {2.5e-4, 8, 2}}};
  std::set<std::string> names;
  const CompleteState<2> any = Structure<2>(rare).state();
  CompleteState<2>::for_each_field([&](const char* name, const auto&) { names.insert(name); }, any);
  EXPECT_GE(names.size(), 20u);
  for (const std::string& name : names) {
    bool needed = false;
    for (const auto& [c, run] : scenes) needed = needed || !differences_after_continuation<2>(c, run, name).empty();
    EXPECT_TRUE(needed) << name;
  }
}

TEST(Continuation, RefusesTheStateOfAnotherScene) {
  Structure<2> one(strip<2>(Integrator::implicit_steps)), other(plate());
  EXPECT_THROW(other.set_state(one.state()), BadInput);
}

// A load that is tried leaves no trace, with the explicit coupling as well, which tries none by itself. Seen to fail: without the begin
// of the window in respond(), where such a trial ended the process.
TEST(Continuation, LoadsMayBeTriedWithEitherCoupling) {
  for (const CouplingAlgorithm algorithm : {CouplingAlgorithm::automatic, CouplingAlgorithm::explicit_staggering}) {
    Structure<2> a(strip<2>(Integrator::explicit_steps)), b(strip<2>(Integrator::explicit_steps));
    CoupledStructure<2> plain(a, algorithm), tried(b, algorithm);
    const Ticks duration = to_ticks(2e-4);
    for (int n = 0; n < 5; ++n) {
      for (CoupledStructure<2>* coupled : {&plain, &tried}) coupled->predict_surface(n * duration, duration);
      const SurfaceLoad<2> load{std::vector<Vector<2>>(a.surface().position.size(), Vector<2>(1e-3, 0))};
      const SurfaceLoad<2> other{std::vector<Vector<2>>(a.surface().position.size(), Vector<2>(0, 5e-3))};
      tried.respond(other);
      EXPECT_EQ(tried.respond(load).size(), load.force.size());
      plain.apply(load), tried.apply(load);
    }
    EXPECT_EQ(a.surface().position, b.surface().position);
  }
}

TEST(Continuation, OfACoupledStructureHasTheSameBits) {
  for (const CouplingAlgorithm algorithm : {CouplingAlgorithm::explicit_staggering, CouplingAlgorithm::automatic}) {
    const Case c = strip<2>(Integrator::automatic);
    Structure<2> a(c), b(c);
    CoupledStructure<2> whole(a, algorithm), continued(b, algorithm);
    const auto advance = [&](CoupledStructure<2>& coupled, int n) {
      const Ticks duration = to_ticks(1e-4);
      const Surface<2> surface = coupled.predict_surface(n * duration, duration);
      SurfaceLoad<2> load;
      for (std::size_t k = 0; k < surface.position.size(); ++k)
        load.force.push_back(surface.area[k] * (10 + std::sin(n) - surface.velocity[k][0]) * surface.normal[k]);
      if (algorithm == CouplingAlgorithm::automatic) coupled.respond(load);
      for (auto& force : load.force) force *= 0.9;
      coupled.apply(load);
    };
    for (int n = 0; n < 8; ++n) advance(whole, n);
    continued.set_state(whole.state());
    for (int n = 8; n < 16; ++n) {
      advance(whole, n);
      advance(continued, n);
    }
    EXPECT_EQ(differences(whole.state(), continued.state()), "") << static_cast<int>(algorithm);
  }
}

}  // namespace
}  // namespace tern::structure::testing
