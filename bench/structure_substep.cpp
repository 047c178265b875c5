// Cost of a structure sub-step per particle. Reported as "per_particle" (CPU time per particle and sub-step).
//   plate:  the plate of the dam break, 4 x 100 particles of 1 mm, 72 sub-steps per window, as in a coupled run
//   block:  a square body of n x n particles
//   solid:  the plate of cases/dam_break_plate_3d_solid, 49 x 24 particles of 2 mm, explicit sub-steps; argument: particles across
//   solid_window: the same plate, a window of 0.49 ms while it swings; argument 0 = explicit, 1 = implicit
// Argument of plate: 1 = with diffusion.
//   part:   the loops of a sub-step on that plate at rest: 0 derivatives, 1 those without the velocity's, 2 stress, 3 diffusion,
//           4 elastic force, 5 kick and drift
//   iteration, factor: what implicit steps of that plate are made of: elastic force and solve, tangent and its factor
//   solid_solve, solid_assembly, solid_factor: parts of them for a cube in 3D; argument: particles across. "each" is the CPU time per
//           non-zero of the factor or per multiplication
//   window: the plate of the dam break swinging 2 cm to and fro, windows of 0.25 ms (89 explicit sub-steps), CPU time per
//           window; argument 0 = explicit, 1 = implicit, 2 = auto

#include <benchmark/benchmark.h>

#include "structure/implicit/tangent.hpp"
#include "structure/structure.hpp"
#include "structure/time_step.hpp"

namespace {

using namespace tern;

Case scene(double width, double height, double spacing) {
  StructureBody body;
  body.name = "plate";
  body.shape.max = {width, height, 0};
  body.spacing = spacing;
  body.density = 1161.54;
  body.young_modulus = 3.5e6;
  body.poisson_ratio = 0.45;
  Shape clamp;
  clamp.min = {-1, -1, 0};
  clamp.max = {1, 0.1 * height, 0};
  body.clamps = {clamp};
  Case result;
  result.dimension = 2;
  result.structure.emplace();
  result.structure->bodies = {body};
  return result;
}

/// The plate of cases/dam_break_plate_3d_solid.
Case solid_plate(double across = 2) {
  Case result = scene(0, 0, 0.002);
  result.dimension = 3;
  StructureBody& body = result.structure->bodies[0];
  body.shape.min = {0.396, -0.008, 0.024};
  body.shape.max = {0.396 + 0.002 * across, 0.090, 0.072};
  body.clamps[0].min = {0.390, -0.020, 0.02};
  body.clamps[0].max = {0.42, 0, 0.08};
  return result;
}

template <int D = 2>
void run(benchmark::State& state, const Case& c) {
  structure::Structure<D> structure(c);
  SurfaceLoad<D> load = structure.load();
  for (auto& force : load.force) force[0] = 1e-3;
  const Ticks duration = to_ticks(72 * structure.largest_sub_step());
  double sub_steps = 0;
  for (auto _ : state) {
    structure.trial(structure.time(), duration);
    load.force[0][0] += 1e-6;
    structure.advance(load);
    sub_steps += 2 * structure.sub_steps();
  }
  state.counters["per_particle"] =
      benchmark::Counter(sub_steps * static_cast<double>(structure.particles()), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void plate(benchmark::State& state) {
  Case c = scene(0.004, 0.100, 0.001);
  if (state.range(0) == 0) c.structure->numerics.riemann_diffusion = 0;
  run(state, c);
}

/// The plate at rest with its tangent.
struct PlateAtRest {
  structure::Reference<2> reference = structure::build_reference<2>(*scene(0.004, 0.100, 0.001).structure);
  structure::State<2> state = structure::state_at_rest(reference, 0);
  structure::Workspace<2> work = structure::workspace_for(reference);
  structure::Tangent<2> tangent{reference};
  void factorise() {
    tangent.assemble(reference, work, 1e8);
    tangent.factorise();
  }
};

void iteration(benchmark::State& state) {
  PlateAtRest plate;
  plate.factorise();
  Eigen::VectorXd right = Eigen::VectorXd::Ones(plate.tangent.unknowns());
  for (auto _ : state) {
    structure::evaluate_elastic_force(plate.reference, plate.state, plate.work);
    right = plate.tangent.solve(right).normalized();
  }
}

void factor(benchmark::State& state) {
  PlateAtRest plate;
  for (auto _ : state) plate.factorise();
}

/// A cube at rest, of so many particles across, with its tangent.
struct CubeAtRest {
  explicit CubeAtRest(double across) : reference(structure::build_reference<3>(*cube(across).structure)) {
    tangent.assemble(reference, work, 1e8);
  }
  static Case cube(double across) {
    Case result = solid_plate();
    StructureBody& body = result.structure->bodies[0];
    body.shape.min = {0, 0, 0};
    body.shape.max = {0.002 * across, 0.002 * across, 0.002 * across};
    body.clamps[0].min = {-1, -1, -1};
    body.clamps[0].max = {1, 0.002, 1};
    return result;
  }
  structure::Reference<3> reference;
  structure::State<3> state = structure::state_at_rest(reference, 0);
  structure::Workspace<3> work = structure::workspace_for(reference);
  structure::Tangent<3> tangent{reference};
};

void count_each(benchmark::State& state, double number) {
  state.counters["each"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * number, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void solid_solve(benchmark::State& state) {
  CubeAtRest cube(static_cast<double>(state.range(0)));
  cube.tangent.factorise();
  Eigen::VectorXd right = Eigen::VectorXd::Ones(cube.tangent.unknowns());
  for (auto _ : state) right = cube.tangent.solve(right).normalized();
  count_each(state, cube.tangent.factor_size());
}

void solid_assembly(benchmark::State& state) {
  CubeAtRest cube(static_cast<double>(state.range(0)));
  for (auto _ : state) cube.tangent.assemble(cube.reference, cube.work, 1e8);
  count_each(state, cube.tangent.assembly_size());
}

void solid_factor(benchmark::State& state) {
  CubeAtRest cube(static_cast<double>(state.range(0)));
  for (auto _ : state) cube.tangent.factorise();
  count_each(state, cube.tangent.factor_work());
}

/// One of the loops a sub-step consists of, on the plate at rest.
void part(benchmark::State& state) {
  const auto reference = structure::build_reference<2>(*scene(0.004, 0.100, 0.001).structure);
  auto plate = structure::state_at_rest(reference, 0);
  auto work = structure::workspace_for(reference);
  for (auto _ : state) {
    switch (state.range(0)) {
      case 0: structure::deformation_gradient(reference, plate, work); break;
      case 1: structure::displacement_gradients(reference, plate, work); break;
      case 2: structure::first_piola_kirchhoff(reference, plate, 0, work); break;
      case 3: structure::diffusion_force(reference, plate, work); break;
      case 4: structure::elastic_force(reference, work, plate); break;
      default: structure::kick(reference, 1e-9, plate); structure::drift(reference, 1e-9, plate);
    }
  }
  state.counters["per_particle"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(reference.particle_row.size()),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void window(benchmark::State& state) {
  Case c = scene(0.004, 0.100, 0.001);
  c.structure->bodies[0].velocity[0] = Expression("1.2*((y-0.01)/0.09)^2");
  c.structure->numerics.integrator = state.range(0) == 0   ? Integrator::explicit_steps
                                     : state.range(0) == 1 ? Integrator::implicit_steps
                                                           : Integrator::automatic;
  structure::Structure<2> structure(c);
  for (auto _ : state) structure.trial(structure.time(), to_ticks(0.25e-3));
}

void solid(benchmark::State& state) { run<3>(state, solid_plate(static_cast<double>(state.range(0)))); }

void solid_window(benchmark::State& state) {
  Case c = solid_plate();
  c.structure->bodies[0].velocity[0] = Expression("1.2*(max(y,0)/0.09)^2");
  c.structure->numerics.integrator = state.range(0) == 0 ? Integrator::explicit_steps : Integrator::implicit_steps;
  structure::Structure<3> structure(c);
  for (auto _ : state) structure.trial(structure.time(), to_ticks(0.49e-3));
}

void block(benchmark::State& state) { run(state, scene(0.1, 0.1, 0.1 / static_cast<double>(state.range(0)))); }

}  // namespace

BENCHMARK(plate)->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);
BENCHMARK(part)->DenseRange(0, 5)->Unit(benchmark::kMicrosecond);
BENCHMARK(iteration)->Unit(benchmark::kMicrosecond);
BENCHMARK(factor)->Unit(benchmark::kMicrosecond);
BENCHMARK(window)->Arg(0)->Arg(1)->Arg(2)->Iterations(400)->Unit(benchmark::kMillisecond);
BENCHMARK(solid)->Arg(2)->Arg(3)->Arg(6)->Unit(benchmark::kMillisecond);
BENCHMARK(solid_window)->Arg(0)->Arg(1)->Iterations(20)->Unit(benchmark::kMillisecond);
BENCHMARK(solid_solve)->Arg(6)->Arg(10)->Arg(16)->Unit(benchmark::kMillisecond);
BENCHMARK(solid_assembly)->Arg(6)->Arg(10)->Arg(16)->Unit(benchmark::kMillisecond);
BENCHMARK(solid_factor)->Arg(6)->Arg(10)->Arg(16)->Unit(benchmark::kMillisecond);
BENCHMARK(block)->Arg(20)->Arg(60)->Unit(benchmark::kMillisecond);
