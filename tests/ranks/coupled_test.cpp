// A fluid in many processes that is coupled to a structure, against the same fluid in one. Each process has the structure and the coupler
// to itself: what the first rank says of the fluid is told to all, so that they do the same.
//
// Seen red: with particles of other ranks that see no faces (crashes); without the sums over all ranks of what moves the lumps, of
// their bound, and of what is transferred to a point; with a load that every rank adds; with forces that begin at the first particle on
// every rank; with images of the particles of the first rank; without the neighbours that other ranks see beside the structure; with
// differences of the finest grid that do not go to the owners of its nodes, or pushes of the own particles alone (iterations); with
// enclosed regions of each rank alone, means of them, and with regions that only those ranks tie which see a body (crashes).

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "coupler/window.hpp"
#include "fixtures/coupled_scenes.hpp"
#include "fluid/boundary/interface_of_ranks.hpp"
#include "fluid/fluid.hpp"
#include "structure/coupled_structure.hpp"

namespace tern::coupler::testing {
namespace {

/// The fluid of all ranks as the coupler of each of them sees it.
template <int D>
struct OfAllRanks {
  fluid::Fluid<D>& fluid;
  Ranks ranks;

  void begin_window(Ticks begin, Ticks duration) { fluid.begin_window(begin, duration); }
  auto extent() const { return fluid.extent(); }
  void pass_window() { fluid.pass_window(); }
  InterfaceParticles<D> see_surface(const Surface<D>& surface) {
    InterfaceParticles<D> all = fluid.see_surface(surface);
    ranks.tell(all.id), ranks.tell(all.position), ranks.tell(all.velocity), ranks.tell(all.mass), ranks.tell(all.volume);
    ranks.tell(all.divergence), ranks.tell(all.image_of), ranks.tell(all.image_position), ranks.tell(all.covered);
    fluid.prepare_pressure();
    return all;
  }
  InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& condition) {
    InterfacePressure<D> all = fluid.solve_pressure(condition);
    ranks.tell(all.pressure), ranks.tell(all.velocity);
    return all;
  }
  void end_window(const InterfaceForce<D>& force) { fluid.end_window(force); }
};

template <int D>
struct Sides {
  Sides(const Case& c, const Ranks& with)
      : ranks(with), fluid(c, with), structure(c), coupled(structure, c.coupling.algorithm), coupler(c, structure.surface_properties()) {}

  void go_on_from(const Sides& other) {
    now = other.now;
    fluid.set_whole_state(other.fluid.state());
    coupled.set_state(other.coupled.state());
    coupler.set_state(other.coupler.state());
  }
  double proposal() const { return coupler.propose(fluid.propose_step().seconds, "").seconds; }
  void run(double duration) {
    OfAllRanks<D> shared{fluid, ranks};
    run_window<D>(shared, coupled, coupler, now, to_ticks(duration));
    now += to_ticks(duration);
  }
  /// The state of all ranks in the order of the labels, on the first one.
  fluid::State<D> whole_state() const {
    const fluid::State<D> all = fluid.whole_state();
    fluid::State<D> sorted = all;
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return all.id[a] < all.id[b]; });
    for (std::size_t k = 0; k < order.size(); ++k) {
      sorted.id[k] = all.id[order[k]], sorted.pressure[k] = all.pressure[order[k]];
      sorted.position[k] = all.position[order[k]], sorted.velocity[k] = all.velocity[order[k]];
      sorted.particle_class[k] = all.particle_class[order[k]];
    }
    return sorted;
  }

  Ranks ranks;
  fluid::Fluid<D> fluid;
  structure::Structure<D> structure;
  structure::CoupledStructure<D> coupled;
  Coupler<D> coupler;
  Ticks now = 0;
};

/// Root of the sum of squares of the difference over that of `a`.
template <class V>
double difference(const std::vector<V>& a, const std::vector<V>& b) {
  double squared = 0, norm = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    if constexpr (std::is_same_v<V, double>)
      squared += (a[k] - b[k]) * (a[k] - b[k]), norm += a[k] * a[k];
    else
      squared += (a[k] - b[k]).squaredNorm(), norm += a[k].squaredNorm();
  }
  return std::sqrt(squared / norm);
}

template <int D>
void expect_the_window_of_one_rank(Case c, int windows) {
  const int usual = [&] {
    Sides<D> one(c, {}), many(c, Ranks::all());
    for (int n = 0; n < windows; ++n) one.run(one.proposal());
    many.go_on_from(one);
    const double duration = one.proposal();
    one.run(duration), many.run(duration);
    EXPECT_EQ(many.coupler.iterations(), one.coupler.iterations());
    EXPECT_NEAR(many.fluid.last_solve().iterations, one.fluid.last_solve().iterations, 1) << "in all solves of the window together";
    return one.fluid.last_solve().iterations;
  }();
  EXPECT_GT(usual, 0);
  c.fluid->numerics.pressure_tolerance = 1e-12;
  Sides<D> one(c, {}), many(c, Ranks::all());
  for (int n = 0; n < windows; ++n) one.run(one.proposal());
  many.go_on_from(one);
  const double duration = one.proposal();
  EXPECT_NEAR(many.proposal(), duration, 1e-12 * duration);
  one.run(duration), many.run(duration);
  ASSERT_GT(one.coupler.audit().particles, 0);
  EXPECT_EQ(many.coupler.audit().particles, one.coupler.audit().particles);
  EXPECT_EQ(many.coupler.audit().pairs, one.coupler.audit().pairs);
  EXPECT_LT(difference(one.coupler.surface_load().force, many.coupler.surface_load().force), 1e-9);
  EXPECT_NEAR(many.fluid.energies().kinetic, one.fluid.energies().kinetic, 1e-9 * one.fluid.energies().kinetic);
  ASSERT_EQ(many.fluid.extent().has_value(), one.fluid.extent().has_value());
  if (one.fluid.extent()) {
    EXPECT_LT((many.fluid.extent()->low - one.fluid.extent()->low).norm(), 1e-9);
    EXPECT_LT((many.fluid.extent()->high - one.fluid.extent()->high).norm(), 1e-9);
  }
  const fluid::State<D> a = one.whole_state(), b = many.whole_state();
  if (!Ranks::all().first()) return;
  ASSERT_EQ(a.id, b.id);
  EXPECT_TRUE(a.particle_class == b.particle_class);
  EXPECT_LT(difference(a.pressure, b.pressure), 1e-9);
  double velocity = 0;
  for (std::size_t k = 0; k < a.size(); ++k) velocity = std::max(velocity, (a.velocity[k] - b.velocity[k]).norm());
  EXPECT_LT(velocity, 1e-10 * a.reference_speed);
  EXPECT_NEAR(a.enclosed.volume_error, b.enclosed.volume_error, 1e-12);
  EXPECT_NEAR(a.enclosed.largest_flux, b.enclosed.largest_flux, 1e-9 * std::abs(a.enclosed.largest_flux));
}

TEST(CoupledWindow, OfAFloorIsThatOfOneRank) { expect_the_window_of_one_rank<2>(case_of({}), 20); }

TEST(CoupledWindow, OfAPlateUnderWaterIsThatOfOneRank) {
  expect_the_window_of_one_rank<2>(case_of({.density_ratio = 1, .layers = 4, .young_modulus = 1e6, .wet_faces = 2}), 20);
}

TEST(CoupledWindow, OfAThinLightPlateIsThatOfOneRank) {
  expect_the_window_of_one_rank<2>(case_of({.density_ratio = 0.1, .layers = 2, .young_modulus = 1e6, .wet_faces = 2}), 20);
}

TEST(CoupledWindow, ThatIsRepeatedIsThatOfOneRank) {
  expect_the_window_of_one_rank<2>(
      case_of({.density_ratio = 1, .layers = 4, .young_modulus = 1e6, .wet_faces = 2, .coupling = Coupling::repeated}), 10);
}

TEST(CoupledWindow, OfEnclosedWaterIsThatOfOneRank) {
  expect_the_window_of_one_rank<2>(case_of({.density_ratio = 1, .layers = 4, .young_modulus = 1e6, .wet_faces = 1, .sealed = true}), 20);
}

TEST(CoupledWindow, ThatIsStaggeredIsThatOfOneRank) {
  CoupledScene scene{.density_ratio = 10, .layers = 4, .young_modulus = 1e7, .wet_faces = 1};
  scene.coupling = Coupling::explicit_staggering;
  expect_the_window_of_one_rank<2>(case_of(scene), 20);
}

TEST(CoupledWindow, IsThatOfOneRankIn3D) {
  Case c = case_of({.density_ratio = 1, .layers = 4, .young_modulus = 1e6, .wet_faces = 2});
  c.dimension = 3;
  for (FluidBody& body : c.fluid->bodies) body.shape.max[2] = 0.08;
  c.walls[0].shape.max[2] = 0.08;
  c.structure->bodies[0].shape.min[2] = 0.02;  // beside which the waters meet
  c.structure->bodies[0].shape.max[2] = 0.06;
  expect_the_window_of_one_rank<3>(c, 10);
}

TEST(CoupledWindow, HasTheSameBitsInEveryRun) {
  const Case c = case_of({.density_ratio = 0.5, .layers = 2, .young_modulus = 1e6, .wet_faces = 2});
  std::vector<Vector<2>> before;
  for (int run = 0; run < 2; ++run) {
    Sides<2> sides(c, Ranks::all());
    for (int n = 0; n < 20; ++n) sides.run(sides.proposal());
    const auto& force = sides.coupler.surface_load().force;
    if (run == 1) {
      ASSERT_EQ(force.size(), before.size());
      EXPECT_EQ(0, std::memcmp(force.data(), before.data(), force.size() * sizeof(Vector<2>)));
    }
    before = force;
  }
}

}  // namespace
}  // namespace tern::coupler::testing
