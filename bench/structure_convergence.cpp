// Convergence of the structure at three spacings, against the references of docs/VERIFICATION.md:
//   first frequency of the plate of dry_plate and of the slender plate of gray_cantilever, from the lowest eigenvalue of the
//   tangent at rest over the mass (inverse iteration), and of plates of other thickness and Poisson's ratio, ten across;
//   first peak of bending_column_2d, and the distance of its path from that of the finite elements over the first second.
// Prints the tables of docs/STRUCTURE.md:  build/release/bench/bench-structure_convergence

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "structure/implicit/tangent.hpp"
#include "structure/structure.hpp"
#include "structure/time_step.hpp"

namespace {

using namespace tern;

Shape box(std::array<double, 3> min, std::array<double, 3> max) {
  Shape shape;
  shape.min = min;
  shape.max = max;
  return shape;
}

Case scene(const StructureBody& body) {
  Case c;
  c.dimension = 2;
  c.structure.emplace();
  c.structure->bodies = {body};
  return c;
}

/// A plate clamped at x < 0.
StructureBody plate(double length, double thickness, int across, double density, double young_modulus, double poisson_ratio) {
  StructureBody b;
  b.name = "plate";
  b.spacing = thickness / across;
  b.shape = box({-2 * b.spacing, 0, 0}, {length, thickness, 0});
  b.clamps = {box({-1, -1, 0}, {0, 1, 0})};
  b.density = density;
  b.young_modulus = young_modulus;
  b.poisson_ratio = poisson_ratio;
  return b;
}

/// Lowest frequency [Hz].
double first_frequency(const StructureBody& body) {
  const auto reference = structure::build_reference<2>(*scene(body).structure);
  auto work = structure::workspace_for(reference);
  structure::Tangent<2> tangent(reference);
  tangent.assemble(reference, work, 0);
  tangent.factorise();
  const double mass = reference.mass[tangent.free_rows()[0]];
  Eigen::VectorXd v = Eigen::VectorXd::Ones(tangent.unknowns());
  double square = 0;
  for (int n = 0; n < 50; ++n) {
    const Eigen::VectorXd next = tangent.solve(mass * v);
    square = v.dot(v) / v.dot(next);
    v = next.normalized();
  }
  return std::sqrt(square) / (2 * std::numbers::pi);
}

struct Path {
  double peak = 0, distance = 0;
};

/// Of the top of the bending column: first peak, and root of the mean square distance from `expected` over it.
Path column(int across, const std::vector<double>& expected) {
  StructureBody b;
  b.name = "column";
  b.spacing = 1.0 / across;
  b.shape = box({-0.5, -2 * b.spacing, 0}, {0.5, 6, 0});
  b.clamps = {box({-1, -1, 0}, {1, 0, 0})};
  b.density = 1100;
  b.young_modulus = 1.7e7;
  b.poisson_ratio = 0.45;
  b.velocity[0] = Expression("10*y/6");
  structure::Structure<2> structure(scene(b));
  const auto top = structure.material_point("column", {0, 6, 0});
  Path path;
  double squares = 0, before = 0, at = 0;
  for (std::size_t n = 1; n < expected.size(); ++n) {
    const Ticks end = to_ticks(0.01 * static_cast<double>(n));
    structure.trial(structure.time(), end - structure.time());
    const double u = structure.displacement(top)[0];
    // The peak of the parabola through the last three values.
    if (path.peak == 0 && u < at) path.peak = at + (u - before) * (u - before) / (8 * (2 * at - u - before));
    before = at;
    at = u;
    squares += (u - expected[n]) * (u - expected[n]);
  }
  path.distance = std::sqrt(squares / static_cast<double>(expected.size())) / path.peak;
  return path;
}

/// First `count` values of a column of a CSV file with comments.
std::vector<double> read_column(const std::string& file, std::size_t column, std::size_t count) {
  std::ifstream stream(file);
  std::vector<double> values;
  for (std::string line; values.size() < count && std::getline(stream, line);) {
    if (line.empty() || !std::isdigit(static_cast<unsigned char>(line[0]))) continue;
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t n = 0; n <= column; ++n) std::getline(cells, cell, ',');
    values.push_back(std::stod(cell));
  }
  return values;
}

void print_row(const std::string& what, int across, double value, double reference, double last_error) {
  const double error = std::abs(value / reference - 1);
  fmt::print("| {} | {} | {:.5g} | {:.2f} % | {} |\n", what, across, value, 100 * (value / reference - 1),
             last_error > 0 ? fmt::format("{:.2f}", std::log2(last_error / error)) : "");
}

}  // namespace

int main(int argc, char** argv) {
  const std::string root = argc > 1 ? argv[1] : ".";
  fmt::print("| quantity | across | value | error | order |\n|---|---|---|---|---|\n");
  double last = 0;
  for (const int across : {4, 8, 16}) {
    const double f = first_frequency(plate(0.09, 0.004, across, 1161.54, 3.5e6, 0.45));
    print_row("plate of dry_plate, f1 [Hz], reference 4.950", across, f, 4.950, last);
    last = std::abs(f / 4.950 - 1);
  }
  last = 0;
  for (const int across : {5, 10, 20}) {
    const double period = 1 / first_frequency(plate(0.2, 0.02, across, 1000, 2e6, 0.3975));
    print_row("plate of gray_cantilever, small amplitude, period [s], reference 0.25492", across, period, 0.25492, last);
    last = std::abs(period / 0.25492 - 1);
  }
  // Landau and Lifshitz' plate, ten across; length 0.2 m, E = 2 MPa, 1000 kg/m^3.
  struct Swing {
    double ratio, poisson_ratio, period;
  };
  for (const auto& [ratio, poisson_ratio, period] : {Swing{0.05, 0.3975, 0.50722},
                                                     {0.10, 0.22, 0.27177},
                                                     {0.10, 0.30, 0.26545},
                                                     {0.10, 0.3975, 0.25492},
                                                     {0.10, 0.40, 0.25401},
                                                     {0.20, 0.3975, 0.13022}})
    print_row(fmt::format("plate of 0.2 m, H/L = {:.2f}, nu = {}, f1 [Hz], reference {:.4f}", ratio, poisson_ratio, 1 / period), 10,
              first_frequency(plate(0.2, 0.2 * ratio, 10, 1000, 2e6, poisson_ratio)), 1 / period, 0);
  const auto expected = read_column(root + "/cases/bending_column_2d/reference/fe_bending_column_2d_planestrain_r8.csv", 1, 101);
  if (expected.size() < 101) {
    fmt::print("The reference of bending_column_2d is not below {}; give the folder of the repository.\n", root);
    return 2;
  }
  last = 0;
  double last_distance = 0;
  for (const int across : {5, 10, 20}) {
    const Path path = column(across, expected);
    print_row("bending_column_2d, first peak [m], reference 2.724", across, path.peak, 2.724, last);
    last = std::abs(path.peak / 2.724 - 1);
    fmt::print("| bending_column_2d, rms distance over the first second / peak | {} | {:.4f} | | {} |\n", across, path.distance,
               last_distance > 0 ? fmt::format("{:.2f}", std::log2(last_distance / path.distance)) : "");
    last_distance = path.distance;
  }
  return 0;
}
