// Cost of a fluid step in a dam break on a rigid block: by part of the step, in particle-steps per second, and in units of
// one sparse matrix-vector product (CSR, double, one thread, the very matrix of the pressure equation, timed between the
// steps). Prints markdown tables; docs/SPEED.md quotes them.
//
//   bench-fluid_step [ROW...]      rows 2d-5k 2d-20k 2d-80k 2d-320k 3d-20k 3d-130k plate; all without arguments
//
// Row plate: iterations alone, with a thin plate between water of 0.2 m and of 0.1 m.
// Own runs from t = 0 lead to the violent states of the small rows. The large rows start from the column with 2 % disorder and
// settle for a few steps: their flow is young, and so is the irregularity of their matrix. (10 % is too much to begin with at
// a spacing of 1 mm: the first steps from rest run away.)

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include <malloc.h>
#include <omp.h>

#include <fmt/format.h>

#include "base/timing.hpp"
#include "fixtures/fluid_scenes.hpp"

namespace {

using namespace tern;
using fluid::testing::dam_break_on_block;
using fluid::testing::Iterations;

struct Row {
  const char* name;
  int dimension;
  double spacing;
  double until;  ///< own run to this time [s]; 0: jitter and `settling` steps
  int settling, measured;
};

constexpr Row rows[] = {
    {"2d-5k", 2, 0.2 / 50, 0.45, 0, 100}, {"2d-20k", 2, 0.2 / 100, 0.30, 0, 40}, {"2d-80k", 2, 0.2 / 200, 0, 40, 20},
    {"2d-320k", 2, 0.2 / 400, 0, 10, 6},  {"3d-20k", 3, 0.2 / 22, 0.10, 0, 20},  {"3d-130k", 3, 0.2 / 40, 0, 10, 6},
};

/// The pressure matrix as compressed rows in double precision.
struct CompressedRows {
  std::vector<int> start, column;
  std::vector<double> value;

  void copy(const fluid::EdgeMatrix& matrix) {
    start.assign(1, 0);
    column.clear();
    value.clear();
    for (int i = 0; i < matrix.rows(); ++i) {
      const std::size_t diagonal = value.size();
      column.push_back(i);
      value.push_back(matrix.constant()[i]);
      matrix.for_edges(i, [&](int j, float edge) {
        column.push_back(j);
        value.push_back(-edge);
        value[diagonal] += edge;
      });
      start.push_back(static_cast<int>(value.size()));
    }
  }

  void multiply(const std::vector<double>& x, std::vector<double>& y) const {
    for (std::size_t i = 0; i + 1 < start.size(); ++i) {
      double sum = 0;
      for (int k = start[i]; k < start[i + 1]; ++k) sum += value[k] * x[column[k]];
      y[i] = sum;
    }
  }
};

double resident_bytes() {
  std::ifstream status("/proc/self/statm");
  double total = 0, resident = 0;
  status >> total >> resident;
  return resident * 4096;
}

/// Lower quartile: other users of the machine disturb many steps, and never make one faster.
double undisturbed(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 4, values.end());
  return values[values.size() / 4];
}

struct Costs {
  std::vector<double> neighbours, boundary, assembly, solve, correction, step, product;
};

template <int D>
void measure_steps(fluid::Fluid<D>& fluid, int steps, bool products, Costs& costs, Iterations& iterations) {
  CompressedRows matrix;
  for (int k = 0; k < steps; ++k) {
    const fluid::StepTiming before = fluid.timing();
    const Stopwatch watch;
    fluid::testing::step(fluid, fluid.propose_step().seconds);
    costs.step.push_back(watch.seconds());
    const fluid::StepTiming after = fluid.timing();
    costs.neighbours.push_back(after.neighbours - before.neighbours);
    costs.boundary.push_back(after.boundary - before.boundary);
    costs.assembly.push_back(after.assembly - before.assembly);
    costs.solve.push_back(after.pressure_solve - before.pressure_solve);
    costs.correction.push_back(after.correction - before.correction);
    iterations.add(fluid.last_solve().iterations);
    if (!products) continue;
    matrix.copy(fluid.pressure_matrix());
    std::vector<double> x(fluid.pressure_source()), y(x.size());
    matrix.multiply(x, y);
    for (int repeat = 0; repeat < 5; ++repeat) {
      const Stopwatch one;
      matrix.multiply(x, y);
      costs.product.push_back(one.seconds());
    }
  }
}

struct Tables {
  std::string speed, parts;
};

template <int D>
void run(const Row& row, Tables& tables) {
  malloc_trim(0);
  const double bytes_before = resident_bytes();
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  fluid::Fluid<D> fluid(dam_break_on_block(D, row.spacing));
  Iterations own, measured;
  if (row.until > 0) {
    own = fluid::testing::count_iterations(fluid, row.until);
  } else {
    std::mt19937 random(20240119);
    fluid::testing::jitter(fluid, 0.02, random);
    for (int k = 0; k < row.settling; ++k) {
      fluid::testing::step(fluid, fluid.propose_step().seconds);
      own.add(fluid.last_solve().iterations);
    }
  }
  const double n = static_cast<double>(fluid.state().size());
  const double bytes = (resident_bytes() - bytes_before) / n;

  Costs one, many;
  measure_steps(fluid, row.measured, true, one, measured);
  omp_set_num_threads(threads);
  measure_steps(fluid, row.measured, false, many, measured);

  const double unit = undisturbed(one.product), step = undisturbed(one.step), parallel = undisturbed(many.step);
  double rest = 0;
  for (const auto* values : {&one.neighbours, &one.boundary, &one.assembly, &one.correction}) rest += undisturbed(*values);
  tables.speed += fmt::format(
      "| {} | {:.0f} | {} | {:.2f} / {} | {:.1f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", row.name, n,
      row.until > 0 ? fmt::format("own run to {:.2f} s, {} steps", row.until, own.count) : fmt::format("2 % disorder, {} steps", own.count),
      (own.sum + measured.sum) / (own.count + measured.count), std::max(own.most, measured.most), 1 / step, n / step * 1e-6,
      n / parallel * 1e-6, step / parallel, bytes * 1e-3);
  const auto part = [&](const std::vector<double>& values) {
    return fmt::format(" {:.1f} ({:.0f} %) |", undisturbed(values) / unit, 100 * undisturbed(values) / step);
  };
  tables.parts += fmt::format("| {} | {:.3f} |", row.name, 1e3 * unit) + part(one.neighbours) + part(one.boundary) + part(one.assembly) +
                  part(one.correction) + fmt::format(" **{:.1f}** | **{:.1f}** |\n", rest / unit, undisturbed(one.solve) / unit);
}

/// Iterations with a plate of one, two and four spacings between two waters.
template <int D>
std::string plate_row(const char* name, double spacing, double top, double bend) {
  using namespace fluid::testing;
  std::string row;
  std::size_t particles = 0;
  for (int thickness : {1, 2, 4}) {
    fluid::Fluid<D> fluid(parted_tank(D, spacing, thickness * spacing, top, bend));
    particles = fluid.state().size();
    const Iterations iterations = count_iterations_from_disorder(fluid);
    row += fmt::format(" {:.1f} / {} |", iterations.mean(), iterations.most);
  }
  return fmt::format("| {} | {} |", name, particles) + row + "\n";
}

std::string plate_table() {
  std::string table = "| plate | particles | 1 dx thick | 2 dx | 4 dx |\n|---|---|---|---|---|\n";
  for (int layers : {58, 116}) {
    table += plate_row<2>("parts the tank", 0.2 / layers, 0.5, 0);
    table += plate_row<2>("the same, bent by a fifth of the water", 0.2 / layers, 0.5, 0.04);
    table += plate_row<2>("ends at half the depth", 0.2 / layers, 0.1, 0);
  }
  table += plate_row<3>("parts the tank, 3D", 0.2 / 20, 0.5, 0);
  table += plate_row<3>("ends at half the depth, 3D", 0.2 / 20, 0.1, 0);
  return table;
}

}  // namespace

int main(int argc, char** argv) {
  Tables tables;
  const auto wanted = [&](const std::string& row) { return argc == 1 || std::count(argv + 1, argv + argc, row) > 0; };
  for (const Row& row : rows) {
    if (!wanted(row.name)) continue;
    row.dimension == 2 ? run<2>(row, tables) : run<3>(row, tables);
    std::fprintf(stderr, "%s done\n", row.name);
  }
  std::string processor = "unknown processor";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) processor = line.substr(line.find(':') + 2);
  fmt::print("{}, {} threads, g++ {}\n\n", processor, omp_get_max_threads(), __VERSION__);
  fmt::print(
      "| row | particles | state | iterations, mean / most | steps/s, 1 thread | 10^6 particle-steps/s, 1 thread | "
      "{} threads | ratio | kB per particle |\n|---|---|---|---|---|---|---|---|---|\n{}\n",
      omp_get_max_threads(), tables.speed);
  fmt::print(
      "| row | product [ms] | neighbours | boundary and operators | assembly | correction | all but the solve | pressure "
      "solve |\n|---|---|---|---|---|---|---|---|\n{}",
      tables.parts);
  if (wanted("plate")) fmt::print("\n{}", plate_table());
}
