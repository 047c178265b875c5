// State is complete: fluid, structure and coupler that are given the states of others at a window's end, through files as a checkpoint
// does, go on with the same bits as those.

#include <gtest/gtest.h>

#include <cstring>

#include "base/step_control.hpp"
#include "coupler/window.hpp"
#include "fixtures/coupled_scenes.hpp"
#include "fixtures/scratch_directory.hpp"
#include "fluid/fluid.hpp"
#include "run/state_file.hpp"
#include "structure/coupled_structure.hpp"

namespace tern::coupler::testing {
namespace {

constexpr int before = 12, after = 12;  ///< windows

template <int D>
struct Sides {
  explicit Sides(const Case& c)
      : fluid(c), structure(c), coupled(structure, c.coupling.algorithm), coupler(c, structure.surface_properties()) {}

  /// The next windows, and what the observers see of them.
  void run(int windows) {
    for (int n = 0; n < windows; ++n) {
      const Ticks duration = control.next(coupler.propose(fluid.propose_step().seconds, "").seconds, now, to_ticks(1000));
      run_window<D>(fluid, coupled, coupler, now, duration);
      now += duration;
      const auto of_fluid = fluid.energies();
      const auto of_structure = structure.energies();
      coupler.watch(seconds(now), {of_fluid.kinetic + of_fluid.potential + of_structure.interface_work,
                                   of_fluid.kinetic + of_structure.kinetic + of_structure.strain});
    }
  }

  void go_on_from(const Sides& other) {
    const ScratchDirectory dir;
    {
      StateWriter file;
      file("now", other.now);
      file("control", other.control);
      file("fluid", other.fluid.state());
      file("structure", other.coupled.state());
      file("coupler", other.coupler.state());
      file.to_file(dir / "state.h5");
    }
    StateReader file(dir / "state.h5");
    fluid::State<D> of_fluid;
    structure::CoupledState<D> of_structure = coupled.state();
    State<D> of_coupler = coupler.state();
    file("now", now);
    file("control", control);
    file("fluid", of_fluid);
    file("structure", of_structure);
    file("coupler", of_coupler);
    fluid.set_state(std::move(of_fluid));
    coupled.set_state(of_structure);
    coupler.set_state(of_coupler);
  }

  fluid::Fluid<D> fluid;
  structure::Structure<D> structure;
  structure::CoupledStructure<D> coupled;
  Coupler<D> coupler;
  StepControl control;
  Ticks now = 0;
};

template <int D>
void expect_same_bits(const std::vector<Vector<D>>& a, const std::vector<Vector<D>>& b, const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (std::size_t k = 0; k < a.size(); ++k) ASSERT_EQ(std::memcmp(a[k].data(), b[k].data(), sizeof(double) * D), 0) << what << " " << k;
}

template <int D>
void expect_continuation(const Case& c, const char* name) {
  SCOPED_TRACE(name);
  Sides<D> whole(c), second(c);
  whole.run(before);
  second.go_on_from(whole);
  const auto answer = [](const Sides<D>& sides) { return sides.coupler.state().response.of_body(sides.coupler.setup(), 0); };
  const auto learnt = answer(whole), known = answer(second);  // what a report says that no window comes before
  ASSERT_EQ(learnt.has_value(), known.has_value());
  EXPECT_EQ(learnt ? learnt->mass_over_formula : 0, known ? known->mass_over_formula : 0);
  whole.run(after);
  second.run(after);
  EXPECT_EQ(whole.now, second.now) << "length of the windows";
  EXPECT_GT(whole.coupler.total_load(0).norm(), 0);
  expect_same_bits<D>(whole.fluid.state().position, second.fluid.state().position, "fluid position");
  expect_same_bits<D>(whole.fluid.state().velocity, second.fluid.state().velocity, "fluid velocity");
  const Surface<D> a = whole.structure.surface(), b = second.structure.surface();
  expect_same_bits<D>(a.position, b.position, "surface position");
  expect_same_bits<D>(a.velocity, b.velocity, "surface velocity");
  expect_same_bits<D>(whole.coupler.surface_load().force, second.coupler.surface_load().force, "surface load");
  EXPECT_EQ(whole.coupler.iterations(), second.coupler.iterations());
  const std::vector<double> sums = whole.coupler.state().totals.energies(0), second_sums = second.coupler.state().totals.energies(0);
  EXPECT_EQ(std::memcmp(sums.data(), second_sums.data(), sums.size() * sizeof(double)), 0) << "columns of energy.csv";
  EXPECT_EQ(whole.coupler.state().totals.windows, second.coupler.state().totals.windows);
  EXPECT_EQ(whole.coupler.state().observations.energy.made(), second.coupler.state().observations.energy.made());
}

Case plate(Coupling coupling, double density_ratio = 1) {
  Case c = case_of({density_ratio, 4, 1e6, 1, coupling});
  c.structure->numerics.integrator = Integrator::explicit_steps;
  return c;
}

// Seen to fail: without the load, the contacts, the changes of earlier windows, the areas at start, the learnt mass of the coupler's state.
TEST(Continuation, GivesTheSameBitsWithEveryCoupling) {
  expect_continuation<2>(plate(Coupling::explicit_staggering, 200), "explicit");
  expect_continuation<2>(plate(Coupling::one_pass), "one pass");
  expect_continuation<2>(plate(Coupling::automatic), "auto");
  expect_continuation<2>(plate(Coupling::repeated, 0.2), "repeated");
}

TEST(Continuation, GivesTheSameBitsWithEverySchemeAndFormOfVem) {
  for (const auto& [scheme, key, meaning] : interface_schemes) {
    Case c = plate(Coupling::one_pass);
    c.coupling.scheme = scheme;
    expect_continuation<2>(c, "scheme");
  }
  for (auto form : {VemForm::seed, VemForm::sum, VemForm::pairmax}) {
    Case c = plate(Coupling::one_pass);
    c.coupling.vem_coefficient = 1;
    c.coupling.vem_form = form;
    expect_continuation<2>(c, "vem");
  }
}

TEST(Continuation, GivesTheSameBitsWithEveryIntegratorOfTheStructure) {
  for (auto integrator : {Integrator::explicit_steps, Integrator::implicit_steps, Integrator::automatic})
    for (auto coupling : {Coupling::one_pass, Coupling::repeated}) {
      Case c = plate(coupling, 0.5);
      c.structure->numerics.integrator = integrator;
      expect_continuation<2>(c, "integrator");
    }
}

// Seen to fail: without the rates that have been followed of walls, without what has been learnt of an enclosed region, and without the
// change that its bodies answered with in the last window.
TEST(Continuation, GivesTheSameBitsWithMovingWallsAndInAnEnclosedOrSealedFluid) {
  Case moving = plate(Coupling::one_pass);
  moving.walls[0].motion.emplace();
  moving.walls[0].motion->displacement = {Expression("0.002*sin(20*t)"), Expression(0.0), Expression(0.0)};
  expect_continuation<2>(moving, "moving walls");
  expect_continuation<2>(case_of({0.1, 4, 1e7, 2, Coupling::automatic, 1, true}), "sealed");
  Case enclosed = case_of({1, 4, 1e6, 1, Coupling::automatic, 1, true});
  enclosed.gravity[1] = Expression("-9.81*(1 + 0.2*sin(40*t))");
  expect_continuation<2>(enclosed, "enclosed");
}

TEST(Continuation, GivesTheSameBitsInThreeDimensions) {
  constexpr double wide = 0.06, length = 0.1;
  Case c = scene(3, water_spacing);
  c.end_time = 1;
  c.gravity = constant(0.98, -9.81);
  c.coupling.riemann_limiter = 3;
  WallCase tank;
  tank.name = "tank";
  tank.container = true;
  tank.open = {"y_max", "y_min"};
  tank.shape = box({0, -0.1, 0}, {length, 0.2, wide});
  c.walls.push_back(tank);
  FluidBody water;
  water.velocity = constant(0);
  water.shape = box({0, 0, 0}, {length, 0.06, wide});
  c.fluid->bodies = {water};
  StructureBody& floor = c.structure->bodies[0];
  floor.shape = box({-0.02, -0.02, 0}, {length + 0.02, 0, wide});
  floor.spacing = 0.01;
  floor.young_modulus = 2e6;
  floor.poisson_ratio = 0.3;
  floor.velocity = constant(0);
  floor.clamps = {box({-1, -1, -1}, {0, 1, 2}), box({length, -1, -1}, {1, 1, 2})};
  expect_continuation<3>(c, "3D");
}

}  // namespace
}  // namespace tern::coupler::testing
