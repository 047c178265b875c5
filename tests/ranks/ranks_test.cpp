// A fluid in many processes against the same fluid in one. Started by mpirun with 1, 2, 3, 4 and 8 processes, each of which also computes
// the whole fluid by itself.
//
// Seen red: with ghosts that keep the velocity they begin with, and without the patches that other ranks fill (OneWindow); with marks
// that do not go to the owners (Marks); with pairs counted from a corner of each rank (ManyWindows.OfAWave); with enclosed regions of each
// rank alone, and with what is pushed into them known to the owners of the particles alone (OneWindow.IsThatOfOneRankInEnclosures); with
// ghosts within half the support (spray, and water through the part of one rank), with cuts that stay for ever (that water).
// With rows, or with residuals, of divided grids that do not go to the owners of their nodes (OneWindow.IsThatOfOneRankOnDividedGrids; the
// ranks then disagree and MPI ends them); with pressures that conjugate gradients leave as they were on ghosts (OneWindow.IsThatOfOneRank);
// with patches that only ranks within half a spacing add up (OneWindow.IsThatOfOneRank).

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <numeric>

#include "base/error.hpp"
#include "fixtures/fluid_scenes.hpp"
#include "fluid/fluid.hpp"

namespace tern::fluid {
namespace {

using namespace testing;

/// Places of the particles in the order of their labels.
template <int D>
std::vector<std::size_t> by_label(const State<D>& state) {
  std::vector<std::size_t> order(state.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return state.id[a] < state.id[b]; });
  return order;
}

struct Difference {
  double position = 0, velocity = 0, pressure = 0;  ///< largest [m], [m/s]; relative, 2-norm
  std::size_t classes = 0, particles = 0;
};

template <int D>
Difference compare(const State<D>& one, const State<D>& many) {
  Difference difference;
  if (one.size() != many.size()) {
    difference.particles = std::max(one.size(), many.size()) - std::min(one.size(), many.size());
    return difference;
  }
  const auto a = by_label(one), b = by_label(many);
  double squared = 0, norm = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const std::size_t i = a[k], j = b[k];
    difference.particles += one.id[i] != many.id[j];
    difference.position = std::max(difference.position, (one.position[i] - many.position[j]).norm());
    difference.velocity = std::max(difference.velocity, (one.velocity[i] - many.velocity[j]).norm());
    squared += std::pow(one.pressure[i] - many.pressure[j], 2);
    norm += one.pressure[i] * one.pressure[i];
    difference.classes += !(one.particle_class[i] == many.particle_class[j]);
  }
  difference.pressure = std::sqrt(squared / norm);
  return difference;
}

/// A fluid of one process after so many windows, in disorder.
template <int D>
State<D> disordered(const Case& scene, int windows) {
  Fluid<D> fluid(scene);
  std::mt19937 random(7);
  jitter(fluid, 0.02, random);
  for (int k = 0; k < windows; ++k) step(fluid, fluid.propose_step().seconds);
  return fluid.state();
}

/// One rank and all of them after one window from one state.
template <int D>
struct Window {
  Fluid<D> one, many;

  Window(const Case& scene, const State<D>& start) : one(scene), many(scene, Ranks::all()) {
    one.set_state(start);
    many.set_whole_state(start);
    const double duration = one.propose_step().seconds;
    EXPECT_NEAR(many.propose_step().seconds, duration, 1e-12 * duration);
    step(one, duration);
    step(many, duration);
  }
};

/// All ranks take no more than two iterations more than one. At the tolerance of the case, where a run needs them.
template <int D>
void expect_as_many_iterations(const Case& scene, const State<D>& start) {
  const Window<D> window(scene, start);
  EXPECT_LE(window.many.last_solve().iterations, window.one.last_solve().iterations + 2);
}

template <int D>
void expect_the_same_window(const Case& scene, const State<D>& start) {
  const Window<D> window(scene, start);
  const Fluid<D>&one = window.one, &many = window.many;
  EXPECT_NEAR(many.energies().kinetic, one.energies().kinetic, 1e-9 * one.energies().kinetic);
  EXPECT_NEAR(many.volume_drift().share, one.volume_drift().share, 1e-12);
  EXPECT_NEAR(many.volume_drift().inside, one.volume_drift().inside, 1e-12);
  EXPECT_EQ(many.spray_particles(), one.spray_particles());
  const EnclosedAccount &of_one = one.sealed(), &of_many = many.sealed();
  EXPECT_EQ(of_one.any, of_many.any);
  EXPECT_NEAR(of_one.volume_error, of_many.volume_error, 1e-9 * std::abs(of_one.volume_error));
  EXPECT_NEAR(of_one.largest_flux, of_many.largest_flux, 1e-9 * std::abs(of_one.largest_flux));
  EXPECT_EQ(of_one.pushed.size(), of_many.pushed.size());
  double pushed_apart = 0;
  for (std::size_t label = 0; label < std::min(of_one.pushed.size(), of_many.pushed.size()); ++label)
    pushed_apart = std::max(pushed_apart, std::abs(of_one.pushed[label] - of_many.pushed[label]));
  EXPECT_LE(pushed_apart, 1e-9 * std::abs(of_one.volume_error));
  EXPECT_EQ(many.state().wall_speed, one.state().wall_speed);
  EXPECT_EQ(many.state().wall_acceleration, one.state().wall_acceleration);
  const State<D> whole = many.whole_state();
  if (!Ranks::all().first()) return;
  const Difference difference = compare(one.state(), whole);
  EXPECT_EQ(difference.particles, 0u);
  EXPECT_EQ(difference.classes, 0u);
  EXPECT_LT(difference.pressure, 1e-9);
  EXPECT_LT(difference.velocity, 1e-10 * start.reference_speed);
  EXPECT_LT(difference.position, 1e-10 * scene.fluid->spacing);
}

template <int D>
void expect_the_window_of_one_rank(Case scene, int after = 30) {
  const State<D> start = disordered<D>(scene, after);
  expect_as_many_iterations<D>(scene, start);
  scene.fluid->numerics.pressure_tolerance = 1e-15;
  expect_the_same_window<D>(scene, start);
}

TEST(OneWindow, IsThatOfOneRank) { expect_the_window_of_one_rank<2>(dam_break(20, 40)); }

TEST(OneWindow, IsThatOfOneRankAroundABlock) { expect_the_window_of_one_rank<2>(dam_break_on_block(2, 0.2 / 20)); }

// At the tolerance of a case the pressures of several ranks differ from those of one by far less than either from the solution. Seen to
// fail: with what is filled of a patch of a wall by the own particles alone.
TEST(OneWindow, DiffersFromThatOfOneRankByLessThanTheSolveLeaves) {
  Case scene = dam_break(40, 80);
  scene.fluid->numerics.pressure_tolerance = 1e-6;
  const State<2> start = disordered<2>(scene, 30);
  const Window<2> window(scene, start);
  scene.fluid->numerics.pressure_tolerance = 1e-15;
  Fluid<2> solution(scene);
  solution.set_state(start);
  step(solution, window.one.propose_step().seconds);
  const State<2> whole = window.many.whole_state();
  if (!Ranks::all().first()) return;
  const double left = compare(solution.state(), window.one.state()).pressure, apart = compare(window.one.state(), whole).pressure;
  std::printf("[ pressure: %.1e from the solution, %.1e from that of %d ranks ]\n", left, apart, Ranks::all().count());
  EXPECT_LT(apart, 1e-5);
  EXPECT_LT(left, 1e-3);
}

// On a lattice the distance of many pairs is the support.
TEST(OneWindow, IsThatOfOneRankFromALattice) {
  for (Case scene : {dam_break(20, 40), dam_break_on_block(2, 0.2 / 20)}) {
    expect_as_many_iterations<2>(scene, Fluid<2>(scene).state());
    scene.fluid->numerics.pressure_tolerance = 1e-15;
    expect_the_same_window<2>(scene, Fluid<2>(scene).state());
  }
  Case scene = dam_break_on_block(3, 0.2 / 10);
  scene.fluid->numerics.pressure_tolerance = 1e-15;
  expect_the_same_window<3>(scene, Fluid<3>(scene).state());
}

TEST(OneWindow, IsThatOfOneRankIn3D) { expect_the_window_of_one_rank<3>(dam_break_on_block(3, 0.2 / 10)); }

TEST(OneWindow, IsThatOfOneRankWithViscosity) {
  Case scene = dam_break(20, 40);
  scene.fluid->viscosity = 0.5;
  expect_the_window_of_one_rank<2>(scene);
}

// Each rank has the patches near its part, and looks how fast a share of all of them moves. Seen to fail: with the largest speed and
// acceleration of the own share for those of all (another window); with what is filled of a patch of the own part alone.
TEST(OneWindow, IsThatOfOneRankInATankThatRolls) {
  const auto rolling = [](WallCase wall) {
    wall.motion.emplace().rotation = Expression("0.2*sin(4*t)");
    wall.motion->pivot = {0.5, -0.2, 0};
    wall.motion->displacement[1] = Expression("0.01*sin(9*t)");
    return wall;
  };
  Case scene = testing::scene(2, 0.02, {box({0, 0, 0}, {1, 0.3, 0})},
                              {rolling(tank({0, 0, 0}, {1, 1, 0})), rolling(obstacle({0.4, 0, 0}, {0.6, 0.1, 0}))});
  expect_the_window_of_one_rank<2>(scene);
  const Fluid<2> many(scene, Ranks::all());
  EXPECT_EQ(many.boundary().walls.whole(), Ranks::all().alone());
}

TEST(OneWindow, IsThatOfOneRankInATankThatRollsIn3D) {
  Case scene = testing::scene(3, 0.05, {box({0, 0, 0}, {1, 0.3, 0.5})}, {tank({0, 0, 0}, {1, 1, 0.5})});
  scene.walls[0].motion.emplace().rotation = Expression("0.2*sin(4*t)");
  scene.walls[0].motion->axis = {0.6, 0, 0.8};
  expect_the_window_of_one_rank<3>(scene);
}

TEST(OneWindow, IsThatOfOneRankBeyondTheEndOfThePeriod) {
  Case scene = testing::scene(2, 1.0 / 32, {box({0, 0, 0}, {1, 0.5, 0})}, {tank({0, 0, 0}, {1, 1, 0})});
  make_periodic(scene, {0, -1, 0}, {1, 2, 1}, "x");
  scene.fluid->bodies[0].velocity = {Expression("0.7 + 0.2*sin(2*pi*x)"), Expression("0.2*cos(2*pi*x)*y"), Expression()};
  expect_the_window_of_one_rank<2>(scene);
}

// Of fluids with so many particles that ranks divide coarser grids than the first.
constexpr int few_windows = 2;  // before the one that is compared

TEST(OneWindow, IsThatOfOneRankOnDividedGrids) { expect_the_window_of_one_rank<2>(dam_break(80, 160), few_windows); }

TEST(OneWindow, IsThatOfOneRankOnDividedGridsIn3D) { expect_the_window_of_one_rank<3>(dam_break_on_block(3, 0.2 / 18), few_windows); }

TEST(OneWindow, IsThatOfOneRankOnDividedGridsThatCloseOnThemselves) {
  Case scene = testing::scene(2, 1.0 / 120, {box({0, 0, 0}, {1, 0.5, 0})}, {tank({0, 0, 0}, {1, 1, 0})});
  make_periodic(scene, {0, -1, 0}, {1, 2, 1}, "x");
  scene.fluid->bodies[0].velocity = {Expression("0.7 + 0.2*sin(2*pi*x)"), Expression("0.2*cos(2*pi*x)*y"), Expression()};
  expect_the_window_of_one_rank<2>(scene, few_windows);
}

// Water on both sides of a wall of one spacing, with and without a way round its end. Several ranks differ from one by less than either
// from the solution. Seen to fail: with grids that are not parted (7e-3 apart), without what other ranks add to rows with further columns,
// with the places that may have two sides in the own view alone.
template <int D>
void expect_the_grids_of_one_rank(Case scene) {
  const State<D> start = disordered<D>(scene, few_windows);
  const Window<D> window(scene, start);
  EXPECT_NEAR(window.many.last_solve().iterations, window.one.last_solve().iterations, 1);
  scene.fluid->numerics.pressure_tolerance = 1e-15;
  Fluid<D> solution(scene);
  solution.set_state(start);
  step(solution, window.one.propose_step().seconds);
  const State<D> whole = window.many.whole_state();
  if (!Ranks::all().first()) return;
  const double left = compare(solution.state(), window.one.state()).pressure, apart = compare(window.one.state(), whole).pressure;
  std::printf("[ pressure: %.1e from the solution, %.1e from that of %d ranks ]\n", left, apart, Ranks::all().count());
  EXPECT_LT(apart, 0.2 * left);
}

TEST(OneWindow, OnBothSidesOfAThinWallIsSolvedAsByOneRank) {
  for (const int fineness : {16, 32})
    for (const double top : {0.4, 0.1})
      for (const double bend : {0.0, 0.05}) expect_the_grids_of_one_rank<2>(parted_tank(2, 0.2 / fineness, 0.2 / fineness, top, bend));
}

TEST(OneWindow, OnBothSidesOfAThinWallIsSolvedAsByOneRankIn3D) {
  for (const double top : {0.4, 0.1}) expect_the_grids_of_one_rank<3>(parted_tank(3, 0.2 / 16, 0.2 / 16, top));
}

TEST(Ranks, SpeakNoMoreThanTheyNeedInAWindow) {
  const Case scene = dam_break_on_block(3, 0.2 / 10);
  Fluid<3> fluid(scene, Ranks::all());
  for (int k = 0; k < 5; ++k) step(fluid, fluid.propose_step().seconds);
  std::map<std::string, double> said;
  fluid.for_each_traffic([&](const char* name, double in_a_window) { said[name] = in_a_window; });
  EXPECT_LE(said["particle_exchanges"], 30);
  EXPECT_LE(said["collectives"], 100);
  EXPECT_EQ(said["particle_exchanges"] > 0, Ranks::all().count() > 1);
}

TEST(Ranks, AddUpAndChooseAtOnce) {
  const Ranks ranks = Ranks::all();
  const double own = ranks.own(), last = ranks.count() - 1;
  double sums[] = {1, own}, most[] = {own, -own, 3};
  ranks.sum_and_most(sums, most);
  EXPECT_EQ(sums[0], last + 1);
  EXPECT_EQ(sums[1], last * (last + 1) / 2);
  EXPECT_EQ(most[0], last);
  EXPECT_EQ(most[1], 0);
  EXPECT_EQ(most[2], 3);
  double low[] = {own, 2 - own}, high[] = {own, 2 - own};
  ranks.extremes(low, high);
  EXPECT_EQ(low[0], 0);
  EXPECT_EQ(low[1], 2 - last);
  EXPECT_EQ(high[0], last);
  EXPECT_EQ(high[1], 2);
}

TEST(Ranks, GatherSeveralArraysAtOnce) {
  const Ranks ranks = Ranks::all();
  std::vector<int> numbers(static_cast<std::size_t>(ranks.own()), ranks.own());
  std::vector<double> places{0.5 * ranks.own()};
  ranks.gather_on_all(numbers, places);
  std::vector<int> expected_numbers;
  std::vector<double> expected_places;
  for (int r = 0; r < ranks.count(); ++r) {
    expected_numbers.insert(expected_numbers.end(), static_cast<std::size_t>(r), r);
    expected_places.push_back(0.5 * r);
  }
  EXPECT_EQ(numbers, expected_numbers);
  EXPECT_EQ(places, expected_places);
}

/// Sum over the neighbours of a number made of their labels: as good as the set of labels.
template <int D>
std::map<std::uint32_t, std::uint64_t> neighbours_by_label(const Fluid<D>& fluid, const Ranks& ranks) {
  std::vector<std::uint32_t> label = fluid.state().id;
  label.resize(fluid.prediction().position.size());
  fluid.domain().particles().update(label);
  std::vector<std::uint64_t> sums;
  const Neighbours<D>& neighbours = fluid.neighbours();
  for (std::size_t i = 0; i < neighbours.rows(); ++i) {
    std::uint64_t sum = 0;
    neighbours.for_each(static_cast<std::ptrdiff_t>(i), [&](int j, float) { sum += (label[j] + std::uint64_t{1}) * 0x9e3779b97f4a7c15u; });
    sums.push_back(sum);
  }
  const auto all_labels = ranks.gather(fluid.state().id);
  const auto all_sums = ranks.gather(sums);
  std::map<std::uint32_t, std::uint64_t> result;
  for (std::size_t k = 0; k < all_labels.size(); ++k) result[all_labels[k]] = all_sums[k];
  return result;
}

TEST(Neighbours, AreThoseOfOneRank) {
  const Case scene = dam_break_on_block(3, 0.2 / 10);
  const State<3> start = disordered<3>(scene, 3);
  Fluid<3> one(scene), many(scene, Ranks::all());
  one.set_state(start);
  many.set_whole_state(start);
  for (Fluid<3>* fluid : {&one, &many}) {
    fluid->begin_window(start.time, to_ticks(1e-4));
    fluid->see_surface({});
  }
  const auto of_one = neighbours_by_label(one, Ranks{}), of_many = neighbours_by_label(many, Ranks::all());
  if (!Ranks::all().first()) return;
  EXPECT_EQ(of_one, of_many);
}

// What a rank marks of the particles of others: they get it, and all copies of them.
TEST(Marks, OnGhostsGoToTheirOwners) {
  const Case scene = dam_break(20, 40);
  Fluid<2> fluid(scene, Ranks::all());
  fluid.begin_window(0, to_ticks(1e-4));
  const std::size_t own = fluid.state().size(), all = fluid.prediction().position.size();
  std::vector<ParticleClass> marks(all);
  for (std::size_t i = own; i < all; ++i) marks[i].set(ParticleClass::beside_spray, true);
  fluid.domain().exchange_marks(marks);
  const auto marked = [](ParticleClass mark) { return mark.has(ParticleClass::beside_spray); };
  const auto given = std::count_if(marks.begin(), marks.begin() + static_cast<std::ptrdiff_t>(own), marked);
  EXPECT_EQ(std::count_if(marks.begin() + static_cast<std::ptrdiff_t>(own), marks.end(), marked), static_cast<std::ptrdiff_t>(all - own));
  EXPECT_EQ(given > 0, Ranks::all().count() > 1);
  EXPECT_LT(given, static_cast<std::ptrdiff_t>(own));
}

/// Largest distance of particles after each of so many windows from those of one rank, which begins at `start`; in spacings.
template <int D>
std::vector<double> distances(const Case& scene, const State<D>& start, const Ranks& ranks, int windows) {
  Fluid<D> one(scene), many(scene, ranks);
  one.set_state(start);
  many.set_whole_state(start);
  std::vector<double> distance;
  for (int k = 0; k < windows; ++k) {
    const double duration = one.propose_step().seconds;
    step(one, duration);
    step(many, duration);
    const State<D> whole = many.whole_state();
    distance.push_back(ranks.first() ? compare(one.state(), whole).position / scene.fluid->spacing : 0);
  }
  return distance;
}

TEST(ManyWindows, OfAWaveStayWithThoseOfOneRank) {
  Case scene = testing::scene(2, 0.025, {water_with_wave(1, 0.05)}, {tank({0, 0, 0}, {1, 1, 0})});
  scene.fluid->numerics.pressure_tolerance = 1e-15;
  const State<2> start = disordered<2>(scene, 10);
  const auto distance = distances(scene, start, Ranks::all(), 20);
  EXPECT_LT(distance.back(), 1e-7);
}

// How far patches of the walls are filled begins at 0 in every window, also where other ranks alone fill them.
// Seen to fail: with what other ranks have filled kept for the next window (0.0025 spacings, 4 ranks).
TEST(ManyWindows, InATankIn3DStayWithThoseOfOneRank) {
  Case scene = dam_break_on_block(3, 0.2 / 10);
  scene.fluid->numerics.pressure_tolerance = 1e-15;
  const auto distance = distances(scene, disordered<3>(scene, 10), Ranks::all(), 4);
  EXPECT_LT(distance.back(), 1e-7);
}

TEST(ManyWindows, HaveTheSameBitsInEveryRun) {
  const Case scene = dam_break_on_block(2, 0.2 / 20);
  State<2> before;
  for (int run = 0; run < 2; ++run) {
    Fluid<2> fluid(scene, Ranks::all());
    for (int k = 0; k < 50; ++k) step(fluid, fluid.propose_step().seconds);
    const State<2> whole = fluid.whole_state();
    if (run == 1) {
      ASSERT_EQ(whole.size(), before.size());
      EXPECT_EQ(whole.id, before.id);
      EXPECT_EQ(0, std::memcmp(whole.position.data(), before.position.data(), whole.size() * sizeof(Vector<2>)));
      EXPECT_EQ(0, std::memcmp(whole.pressure.data(), before.pressure.data(), whole.size() * sizeof(double)));
    }
    before = whole;
  }
}

/// A block without weight that flies to the right, with the pressure of a spin.
Case flying_block() {
  Case scene = testing::scene(2, 0.01, {box({0, 0, 0}, {0.2, 0.2, 0})}, {}, 0);
  scene.fluid->bodies[0].velocity = {Expression("4 + 2*(0.1-y)"), Expression("2*(x-0.1)"), Expression()};
  return scene;
}

// The block passes from part to part: each rank is for a while the only one that has something, until space is cut anew.
TEST(ManyWindows, OfAllWaterThroughThePartOfOneRank) {
  Case scene = flying_block();
  scene.fluid->numerics.pressure_tolerance = 1e-15;  // so that what differs is rounding
  const State<2> start = disordered<2>(scene, 0);
  Fluid<2> one(scene), many(scene, Ranks::all());
  one.set_state(start);
  many.set_whole_state(start);
  double fullest = 0, evenest_after = 1e300;
  for (int k = 0; k < 30; ++k) {
    step(one, 2e-3);
    step(many, 2e-3);
    fullest = std::max(fullest, many.domain().imbalance());
    if (fullest > 1.5) evenest_after = std::min(evenest_after, many.domain().imbalance());
  }
  if (Ranks::all().count() > 1) {
    EXPECT_GT(fullest, 1.5);
    EXPECT_LT(evenest_after, 1.15);
  }
  EXPECT_EQ(many.particles(), 400u);
  EXPECT_NEAR(many.energies().kinetic, one.energies().kinetic, 1e-9 * one.energies().kinetic);
  EXPECT_NEAR(many.momentum()[0], one.momentum()[0], 1e-9 * one.momentum()[0]);
}

// Drops far outside what the cuts were made from, in all directions, one of them a thousand spacings away.
TEST(OneWindow, IsThatOfOneRankWithSprayFlungFar) {
  const Case scene = dam_break(20, 40);
  State<2> start = disordered<2>(scene, 30);
  const auto order = by_label(start);
  const std::array<Vector<2>, 4> places = {{{0.7, 8}, {0.3, 10}, {0.05, 3}, {0.75, 2}}};
  for (std::size_t k = 0; k < places.size(); ++k) {
    start.position[order[97 * k + 3]] = places[k];
    start.velocity[order[97 * k + 3]] = {0.5, -1};
  }
  expect_as_many_iterations<2>(scene, start);
  Case exact = scene;
  exact.fluid->numerics.pressure_tolerance = 1e-15;
  expect_the_same_window<2>(exact, start);
}

/// Largest number of patches of walls that a rank has, over all there are.
template <int D>
double largest_share_of_patches(const Fluid<D>& fluid) {
  const double held = static_cast<double>(fluid.boundary().walls.faces().size());
  return Ranks::all().most(held) / static_cast<double>(fluid.walls().faces().size());
}

// A tank in 2D that is 40 times as long as deep, and one in 3D. Seen red: with all patches on every rank.
TEST(Walls, AreFewerOnEachOfMoreRanks) {
  const int ranks = Ranks::all().count();
  {
    const Case scene = testing::scene(2, 0.025, {box({0, 0, 0}, {8, 0.2, 0})}, {tank({0, 0, 0}, {8, 1, 0})});
    Fluid<2> fluid(scene, Ranks::all());
    for (int k = 0; k < 3; ++k) step(fluid, fluid.propose_step().seconds);
    // The part of the bottom with what is held beyond it, and the sides as high as the water.
    EXPECT_LT(largest_share_of_patches(fluid), ranks == 1 ? 1.1 : 0.15 + 0.8 / ranks);
  }
  Fluid<3> fluid(dam_break_on_block(3, 0.2 / 18), Ranks::all());
  for (int k = 0; k < 3; ++k) step(fluid, fluid.propose_step().seconds);
  const std::map<int, double> most = {{1, 1.0}, {2, 0.4}, {3, 0.4}, {4, 0.35}, {8, 0.3}};
  EXPECT_LE(largest_share_of_patches(fluid), most.at(ranks));
}

TEST(Partition, GivesAllRanksAsMuchWhenTheFluidHasMoved) {
  const Case scene = dam_break(40, 40);
  Fluid<2> fluid(scene, Ranks::all());
  auto first = fluid.state().id;
  while (fluid.state().time < to_ticks(0.12)) step(fluid, fluid.propose_step().seconds);
  const auto count = static_cast<double>(fluid.state().size());
  EXPECT_LT(Ranks::all().most(count) * Ranks::all().count() / Ranks::all().sum(count), 1.3);
  EXPECT_EQ(fluid.particles(), 1600u);
  auto now = fluid.state().id;
  for (auto* labels : {&first, &now}) std::sort(labels->begin(), labels->end());
  EXPECT_EQ(Ranks::all().any(now != first), Ranks::all().count() > 1);
}

TEST(Ranks, MayOwnNothing) {
  Case scene = testing::scene(2, 0.05, {box({0.05, 0.3, 0}, {0.15, 0.4, 0})}, {tank({0, 0, 0}, {0.8, 1, 0})});
  Fluid<2> fluid(scene, Ranks::all());
  for (int k = 0; k < 5; ++k) step(fluid, 1e-3);
  EXPECT_EQ(fluid.particles(), 4u);
}

TEST(Ranks, FailTogetherWithTheSentenceOfOne) {
  const Case scene = dam_break(10, 20);
  Fluid<2> fluid(scene, Ranks::all());
  State<2> state = fluid.state();
  if (Ranks::all().own() == Ranks::all().count() - 1 && state.size() > 0) state.velocity[0][0] = 1e6;
  fluid.set_state(state);
  std::string sentence;
  try {
    step(fluid, 1e-6);
  } catch (const NumericalFailure& failure) {
    sentence = failure.what();
  }
  EXPECT_NE(sentence.find("The speed of fluid particle"), std::string::npos) << sentence;
  EXPECT_EQ(Ranks::all().first_word(sentence), sentence);
}

// Two waters without a surface, of which a wall pushes the upper one: each is a region of its own, whatever the ranks have of them.
TEST(OneWindow, IsThatOfOneRankInEnclosures) {
  WallCase piston = obstacle({0.8, 0.42, 0}, {0.9, 0.9, 0});
  piston.motion.emplace().displacement = {Expression("-0.1*t"), Expression(), Expression()};
  Case scene = testing::scene(
      2, 0.02, {box({0, 0, 0}, {0.8, 0.4, 0}), box({0, 0.44, 0}, {0.8, 0.8, 0})},
      {tank({0, 0, 0}, {0.9, 0.8, 0}, {}), obstacle({-0.1, 0.4, 0}, {1, 0.44, 0}), obstacle({0.8, -0.1, 0}, {1, 0.42, 0}), piston});
  scene.fluid->bodies[0].velocity = {Expression("0.2*sin(5*y)"), Expression(), Expression()};
  expect_the_window_of_one_rank<2>(scene);
}

}  // namespace
}  // namespace tern::fluid

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (!tern::ranks_were_started()) return RUN_ALL_TESTS();
  const tern::RanksAtWork at_work;
  if (!tern::Ranks::all().first())
    delete ::testing::UnitTest::GetInstance()->listeners().Release(
        ::testing::UnitTest::GetInstance()->listeners().default_result_printer());
  const bool failed = RUN_ALL_TESTS() != 0;
  return tern::Ranks::all().any(failed) ? 1 : 0;
}
