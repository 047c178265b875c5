// CPU time of the coupler alone in one window, in 3D, by part and by the number of surface points. Prints the table of docs/SCALE.md:
//   OMP_NUM_THREADS=1 build/release/bench/bench-coupler_points [points ...]
//
// A square plate with points on both faces, water on both sides, particles 1.6 times as far apart as points. The particles are in
// disorder, their pressures are of slow waves, and the plate answers with its mass. Of 20 windows after the first 5 the mean.

#include <array>
#include <cstdlib>
#include <ctime>

#include <fmt/format.h>

#include "fixtures/interface_scenes.hpp"

namespace {

using namespace tern;
using namespace tern::coupler::testing;

constexpr double point_spacing = 0.005, spacing = 0.008, section_mass = 20, duration = 2e-4;

double seconds_by(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// `bent`: a plate in waves, of a radius of 0.6 m at the crests.
void measure(int wanted, bool bent) {
  const double half = 0.5 * point_spacing * std::round(std::sqrt(wanted / 2.0));
  Surface<3> surface = flat_plate<3>(half, 0.004, point_spacing);
  const auto rise = [bent](const Vector<3>& x) { return bent ? -0.025 * std::cos(8 * x[0]) : 0; };
  for (std::size_t k = 0; bent && k < surface.position.size(); ++k) {
    Vector<3>& x = surface.position[k];
    surface.normal[k] = surface.normal[k][1] * Vector<3>(-0.2 * std::sin(8 * x[0]), 1, 0).normalized();
    x[1] += rise(x);
  }
  InterfaceParticles<3> particles = fluid_layers<3>(half, 3, spacing, true, 0.004);
  particles.divergence.clear();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> disorder(-0.05 * spacing, 0.05 * spacing);
  for (auto& x : particles.position) x += Vector<3>(disorder(random), rise(x) + disorder(random), disorder(random));
  const std::size_t points = surface.position.size();
  coupler::Coupler<3> coupler(scene(3, spacing), properties(points, section_mass));

  enum Part { pairs, first, next, accepts, last, parts };
  std::array<double, parts> spent{};
  coupler::InterfacePairs<3> again(1.5 * spacing, spacing);
  SurfaceLoad<3> assumed;
  assumed.force.assign(points, Vector<3>::Zero());
  double wall = 0;
  long repeated = 0;
  constexpr int windows = 25, left_out = 5;
  for (int window = 0; window < windows; ++window) {
    if (window == left_out) spent = {}, wall = 0, repeated = 0;
    const auto timed = [&](Part part, auto&& work) {
      const double begin = seconds_by(CLOCK_PROCESS_CPUTIME_ID), wall_begin = seconds_by(CLOCK_MONOTONIC);
      work();
      spent[part] += seconds_by(CLOCK_PROCESS_CPUTIME_ID) - begin;
      if (part != pairs) wall += seconds_by(CLOCK_MONOTONIC) - wall_begin;
    };
    const double t = window * duration;
    const auto pressure =
        pressure_field<3>(particles, [&](const Vector<3>& x) { return 1000 * std::sin(3 * x[0] + 20 * t) + 2000 * x[1]; });
    const auto answer = [&](const SurfaceLoad<3>& load) {
      std::vector<Vector<3>> velocity = surface.velocity;
      for (std::size_t k = 0; k < points; ++k)
        velocity[k] += duration / (section_mass * surface.area[k]) * (load.force[k] - assumed.force[k]);
      return velocity;
    };
    timed(pairs, [&] { again.find(particles, surface); });
    timed(first, [&] { coupler.first_exchange(t, duration, surface, particles); });
    const SurfaceLoad<3>* load = nullptr;
    while (timed(next, [&] { load = coupler.next_load(pressure); }), load != nullptr) {
      std::vector<Vector<3>> velocity = answer(*load);
      bool done = false;
      timed(accepts, [&] { done = coupler.accepts(velocity); });
      if (done) break;
      if (const SurfaceLoad<3>* better = coupler.accelerated_load()) velocity = answer(*better);
      ++repeated;
      timed(first, [&] { coupler.repeat_exchange(std::move(velocity)); });
    }
    timed(last, [&] { coupler.last_exchange(pressure); });
    assumed = coupler.surface_load();
  }
  for (double& part : spent) part *= 1e3 / (windows - left_out);
  fmt::print("| {}{} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n", points, bent ? ", bent" : "",
             particles.id.size(), again.all_pairs().size(), spent[pairs], spent[first] - spent[pairs], spent[next], spent[accepts],
             spent[last], spent[first] + spent[next] + spent[accepts] + spent[last], 1e3 / (windows - left_out) * wall);
  if (repeated > 0) fmt::print("{} windows were repeated\n", repeated);
}

}  // namespace

int main(int argc, char** argv) {
  fmt::print(
      "| points | particles | pairs | who sees whom [ms] | condition | pressure | learning | balance, account | whole window [ms] | its "
      "wall "
      "time |\n|---|---|---|---|---|---|---|---|---|---|\n");
  std::vector<int> numbers;
  for (int k = 1; k < argc; ++k) numbers.push_back(std::atoi(argv[k]));
  if (numbers.empty()) numbers = {1000, 10000, 100000};
  for (const int points : numbers)
    for (const bool bent : {false, true}) measure(points, bent);
}
