#include "structure/clamp_balance.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/Sparse>

namespace tern::structure {
namespace {

constexpr int corrected_layers = 3;  ///< b_j is largest in the first two
constexpr int line_length = 6;       ///< what second differences around these reach, and one

/// The particles before a face of a clamp.
template <int D>
struct Line {
  Cell<D> face;
  Cell<D> step{};            ///< outwards
  Vector<D> normal;          ///< the same, in space
  int count = 0;             ///< of free particles, line_length at most
  Cell<D> at(int n) const {  ///< -1: on the face
    Cell<D> cell = face;
    for (int a = 0; a < D; ++a) cell[a] += (n + 1) * step[a];
    return cell;
  }
};

template <int D>
std::vector<Line<D>> lines_before_clamps(const std::vector<Cell<D>>& cells, const Lattice<D>& lattice) {
  std::vector<Line<D>> lines;
  for (const auto& cell : cells) {
    const Vector<D> shift = shift_of<D>(lattice.content_of(cell));
    if (shift.cwiseAbs().sum() != 0.5) continue;
    Line<D> line;
    line.face = cell;
    for (int a = 0; a < D; ++a) line.step[a] = (shift[a] > 0) - (shift[a] < 0);
    line.normal = 2 * (lattice.axes * shift);
    while (line.count < line_length && lattice.content_of(line.at(line.count)) == free_particle) ++line.count;
    if (line.count > 0) lines.push_back(line);
  }
  return lines;
}

/// b_j/dx^(D-1) of all cells, less what the free faces of the lattice bear of a stress.
template <int D>
std::vector<Vector<D>> push_of_uniform_stress(const std::vector<Cell<D>>& cells, const std::vector<Cell<D>>& offsets, double spacing,
                                              const Lattice<D>& lattice, const std::vector<Neighbourhood<D>>& neighbourhoods) {
  std::vector<Vector<D>> push(lattice.row.size(), Vector<D>::Zero());
  for (const auto& cell : cells) {
    if (lattice.content_of(cell) != free_particle) continue;
    const auto own = lattice.index(cell);
    const auto& derivatives = neighbourhoods[lattice.pattern[own]].derivatives;
    std::vector<Vector<D>> free_faces;
    for (int a = 0; a < D; ++a)
      for (const int sign : {-1, 1}) {
        Cell<D> beside = cell;
        beside[a] += sign;
        if (const auto n = lattice.index(beside); n < 0 || lattice.row[n] == no_row) free_faces.push_back(sign * lattice.axes.col(a));
      }
    for (const auto& normal : free_faces) push[own] -= normal;
    for (std::size_t o = 0; o < offsets.size(); ++o) {
      const auto other = lattice.index(shifted<D>(cell, offsets[o]));
      if (other < 0 || lattice.content[other] == hidden) continue;
      const Vector<D> gradient = std::pow(spacing, D + 1) * derivatives[o].gradient;  // V_j g_ij dx
      Vector<D> moved = gradient;
      for (const auto& normal : free_faces) moved -= 0.5 * gradient.dot(normal) * normal;
      push[other] += moved;
      push[own] -= moved;
    }
  }
  return push;
}

std::array<double, 3> second_difference(int first) { return first < 0 ? std::array{4.0 / 3, -2.0, 2.0 / 3} : std::array{1.0, -2.0, 1.0}; }

/// Furthest cell straight ahead among the offsets.
template <int D>
int reach_of(const std::vector<Cell<D>>& offsets) {
  int reach = 0;
  for (const auto& offset : offsets) reach = std::max(reach, std::count(offset.begin(), offset.end(), 0) == D - 1 ? offset[0] : 0);
  return reach;
}

}  // namespace

template <int D>
void balance_clamps(const std::vector<Cell<D>>& cells, const std::vector<Cell<D>>& offsets, double spacing, Lattice<D>& lattice,
                    std::vector<Neighbourhood<D>>& neighbourhoods) {
  const std::vector<Line<D>> lines = lines_before_clamps<D>(cells, lattice);
  if (lines.empty()) return;
  const std::vector<Vector<D>> push = push_of_uniform_stress<D>(cells, offsets, spacing, lattice, neighbourhoods);
  struct Unknown {
    std::size_t line;
    int layer, first;  // i, and q
  };
  std::vector<Unknown> unknowns;
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> right;
  const int reach = reach_of<D>(offsets);
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const Line<D>& line = lines[l];
    const int equation = static_cast<int>(right.size());  // of the first free particle
    for (int n = 0; n < line.count; ++n) right.push_back(-push[lattice.index(line.at(n))].dot(line.normal));
    for (int layer = 0; layer < std::min(corrected_layers, line.count); ++layer)
      for (int first = std::max(-1, layer - reach); first + 2 <= std::min(line.count - 1, layer + reach); ++first) {
        const auto y = second_difference(first);
        for (int m = 0; m < 3; ++m)
          if (first + m >= 0) entries.emplace_back(equation + first + m, static_cast<int>(unknowns.size()), y[m]);
        unknowns.push_back({l, layer, first});
      }
  }
  if (unknowns.empty()) return;
  Eigen::SparseMatrix<double> matrix(static_cast<Eigen::Index>(right.size()), static_cast<Eigen::Index>(unknowns.size()));
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::LeastSquaresConjugateGradient<Eigen::SparseMatrix<double>> solver(matrix);
  solver.setTolerance(1e-12);
  const Eigen::VectorXd solution = solver.solve(Eigen::Map<const Eigen::VectorXd>(right.data(), matrix.rows()));
  std::vector<bool> is_its_own(lattice.row.size(), false);
  for (std::size_t u = 0; u < unknowns.size(); ++u) {
    const auto& [l, layer, first] = unknowns[u];
    const Line<D>& line = lines[l];
    const auto own = lattice.index(line.at(layer));
    if (!is_its_own[own]) {
      is_its_own[own] = true;
      neighbourhoods.push_back(neighbourhoods[lattice.pattern[own]]);
      lattice.pattern[own] = static_cast<std::uint32_t>(neighbourhoods.size() - 1);
    }
    auto& derivatives = neighbourhoods[lattice.pattern[own]].derivatives;
    const double c = std::ldexp(std::round(std::ldexp(solution[static_cast<Eigen::Index>(u)], 30)), -30);  // equal layers share their sums
    for (int m = 0; m < 3; ++m) {
      Cell<D> offset;
      for (int a = 0; a < D; ++a) offset[a] = (first + m - layer) * line.step[a];
      const auto o = std::find(offsets.begin(), offsets.end(), offset);
      if (o == offsets.end()) continue;  // itself
      derivatives[o - offsets.begin()].gradient += c * second_difference(first)[m] / std::pow(spacing, D + 1) * line.normal;
    }
  }
}

template void balance_clamps<2>(const std::vector<Cell<2>>&, const std::vector<Cell<2>>&, double, Lattice<2>&,
                                std::vector<Neighbourhood<2>>&);
template void balance_clamps<3>(const std::vector<Cell<3>>&, const std::vector<Cell<3>>&, double, Lattice<3>&,
                                std::vector<Neighbourhood<3>>&);

}  // namespace tern::structure
