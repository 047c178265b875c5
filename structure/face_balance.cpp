#include "structure/face_balance.hpp"

#include <map>

#include "scene/geometry.hpp"
#include "structure/least_squares.hpp"

namespace tern::structure {
namespace {

constexpr int clamped_layers = 3;  ///< b_j is largest in the first two
constexpr int line_length = 6;     ///< what second differences around these reach, and one
constexpr double restraint = 0.1;  ///< weight of c beside b/dx^(D-1)
constexpr double flush = 1e-3;     ///< difference in spacings and directions

using Differences = std::array<double, 3>;
constexpr Differences evenly = {1, -2, 1}, from_face = {4.0 / 3, -2, 2.0 / 3};

/// One c.
template <int D>
struct Correction {
  Cell<D> particle;              ///< i
  std::array<Cell<D>, 3> nodes;  ///< q and the next two
  Differences y;
  Vector<D> direction;  ///< e
};

/// b_j/dx^(D-1) of all cells.
template <int D>
std::vector<Vector<D>> push_of_uniform_stress(const Fit<D>& fit) {
  std::vector<Vector<D>> push(fit.lattice.row.size(), Vector<D>::Zero());
  const double scale = std::pow(fit.spacing, D + 1);
  for (const auto& cell : fit.cells) {
    if (fit.lattice.content_of(cell) != free_particle) continue;
    const auto own = fit.lattice.index(cell);
    const auto& derivatives = fit.neighbourhoods[fit.lattice.pattern[own]].derivatives;
    for (std::size_t o = 0; o < fit.offsets.size(); ++o) {
      const auto other = fit.lattice.index(shifted<D>(cell, fit.offsets[o]));
      if (other < 0 || fit.lattice.content[other] == hidden) continue;
      const Vector<D> gradient = scale * derivatives[o].gradient;
      push[other] += gradient;
      push[own] -= gradient;
    }
  }
  return push;
}

/// Takes from the push what a face of the cell, `offset` from its particle [dx], bears. `area`: A N/dx^(D-1).
template <int D>
void subtract_load(const Fit<D>& fit, const Cell<D>& cell, const Vector<D>& offset, const Vector<D>& area, std::vector<Vector<D>>& push) {
  const auto own = fit.lattice.index(cell);
  const auto& derivatives = fit.neighbourhoods[fit.lattice.pattern[own]].derivatives;
  const double scale = std::pow(fit.spacing, D + 1);
  push[own] -= area;
  for (std::size_t o = 0; o < fit.offsets.size(); ++o) {
    const auto other = fit.lattice.index(shifted<D>(cell, fit.offsets[o]));
    if (other < 0 || fit.lattice.content[other] == hidden) continue;
    const double weight = scale * derivatives[o].gradient.dot(offset);
    push[other] -= weight * area;
    push[own] += weight * area;
  }
}

/// Gives the particles neighbourhoods of their own, with the corrections.
template <int D>
void correct(const Fit<D>& fit, const std::vector<Correction<D>>& corrections, const Eigen::VectorXd& c) {
  std::vector<bool> is_its_own(fit.lattice.row.size(), false);
  for (std::size_t u = 0; u < corrections.size(); ++u) {
    const auto& [particle, nodes, y, direction] = corrections[u];
    const auto own = fit.lattice.index(particle);
    if (!is_its_own[own]) {
      is_its_own[own] = true;
      fit.neighbourhoods.push_back(fit.neighbourhoods[fit.lattice.pattern[own]]);
      fit.lattice.pattern[own] = static_cast<std::uint32_t>(fit.neighbourhoods.size() - 1);
    }
    // Rounded, so that equal ones share their sums.
    const double rounded = std::ldexp(std::round(std::ldexp(c[static_cast<Eigen::Index>(u)], 30)), -30);
    auto& derivatives = fit.neighbourhoods[fit.lattice.pattern[own]].derivatives;
    for (int m = 0; m < 3; ++m) {
      Cell<D> offset;
      for (int a = 0; a < D; ++a) offset[a] = nodes[m][a] - particle[a];
      const auto o = std::find(fit.offsets.begin(), fit.offsets.end(), offset);
      if (o == fit.offsets.end()) continue;  // itself
      derivatives[o - fit.offsets.begin()].gradient += rounded * y[m] / std::pow(fit.spacing, D + 1) * direction;
    }
  }
}

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

/// Furthest cell straight ahead among the offsets.
template <int D>
int reach_of(const std::vector<Cell<D>>& offsets) {
  int reach = 0;
  for (const auto& offset : offsets) reach = std::max(reach, std::count(offset.begin(), offset.end(), 0) == D - 1 ? offset[0] : 0);
  return reach;
}

/// A patch of the surface.
template <int D>
struct Foot {
  Cell<D> cell{};                        ///< of the particle behind it
  Vector<D> offset = Vector<D>::Zero();  ///< from that [dx]
  Vector<D> area = Vector<D>::Zero();    ///< A N/dx^(D-1)
  bool is_flush = true;                  ///< the lattice lies along it, half a spacing behind
};

template <int D>
std::vector<Foot<D>> feet_of(const Fit<D>& fit, const Shape& shape, const std::vector<Shape>& clamps, const Vector<D>& first) {
  const auto surface = sample_surface<D>(shape, fit.spacing);
  std::vector<Foot<D>> feet;
  for (std::size_t k = 0; k < surface.area.size(); ++k) {
    const Vector<D>& x = surface.position[k];
    if (std::any_of(clamps.begin(), clamps.end(), [&](const Shape& clamp) { return contains<D>(clamp, x); })) continue;
    const Vector<D> along = fit.lattice.axes.transpose() * (x - first) / fit.spacing,
                    normal = fit.lattice.axes.transpose() * surface.normal[k];
    Foot<D> foot;
    double least = std::numeric_limits<double>::max();
    Cell<D> cell;
    const auto visit = [&](auto&& self, int a) -> void {
      if (a < D) {
        const int middle = fit.cells.front()[a] + static_cast<int>(std::lround(along[a]));
        for (cell[a] = middle - 1; cell[a] <= middle + 1; ++cell[a]) self(self, a + 1);
        return;
      }
      if (fit.lattice.content_of(cell) != free_particle) return;
      Vector<D> offset = along;
      for (int b = 0; b < D; ++b) offset[b] -= cell[b] - fit.cells.front()[b];
      if (offset.squaredNorm() >= least) return;
      least = offset.squaredNorm();
      foot.cell = cell;
      foot.offset = fit.lattice.axes * offset;
      foot.is_flush = normal.cwiseAbs().maxCoeff() > 1 - flush * flush && std::abs(offset.dot(normal) - 0.5) < flush;
    };
    visit(visit, 0);
    if (least == std::numeric_limits<double>::max()) continue;  // in a clamp all around
    foot.area = surface.area[k] / std::pow(fit.spacing, D - 1) * surface.normal[k];
    feet.push_back(foot);
  }
  return feet;
}

/// Lines of three free particles along the axes that begin, end or have their middle at the one in the cell.
template <int D>
std::vector<std::array<Cell<D>, 3>> lines_through(const Cell<D>& cell, const Lattice<D>& lattice) {
  std::vector<std::array<Cell<D>, 3>> lines;
  for (int a = 0; a < D; ++a)
    for (int from = -2; from <= 0; ++from) {
      std::array<Cell<D>, 3> line = {cell, cell, cell};
      bool is_free = true;
      for (int m = 0; m < 3; ++m) {
        line[m][a] += from + m;
        is_free = is_free && lattice.content_of(line[m]) == free_particle;
      }
      if (is_free) lines.push_back(line);
    }
  return lines;
}

}  // namespace

template <int D>
void balance_clamps(const Fit<D>& fit) {
  const std::vector<Line<D>> lines = lines_before_clamps<D>(fit.cells, fit.lattice);
  if (lines.empty()) return;
  std::vector<Vector<D>> push = push_of_uniform_stress<D>(fit);
  for (const auto& cell : fit.cells) {
    if (fit.lattice.content_of(cell) != free_particle) continue;
    for (int a = 0; a < D; ++a)
      for (const int sign : {-1, 1}) {
        Cell<D> beside = cell;
        beside[a] += sign;
        const Vector<D> normal = sign * fit.lattice.axes.col(a);
        if (const auto n = fit.lattice.index(beside); n < 0 || fit.lattice.row[n] == no_row)
          subtract_load<D>(fit, cell, 0.5 * normal, normal, push);
      }
  }
  std::vector<Correction<D>> corrections;
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> right;
  const int reach = reach_of<D>(fit.offsets);
  for (const Line<D>& line : lines) {
    const int equation = static_cast<int>(right.size());  // of the first free particle
    for (int n = 0; n < line.count; ++n) right.push_back(-push[fit.lattice.index(line.at(n))].dot(line.normal));
    for (int layer = 0; layer < std::min(clamped_layers, line.count); ++layer)
      for (int first = std::max(-1, layer - reach); first + 2 <= std::min(line.count - 1, layer + reach); ++first) {
        const Differences& y = first < 0 ? from_face : evenly;
        for (int m = 0; m < 3; ++m)
          if (first + m >= 0) entries.emplace_back(equation + first + m, static_cast<int>(corrections.size()), y[m]);
        corrections.push_back({line.at(layer), {line.at(first), line.at(first + 1), line.at(first + 2)}, y, line.normal});
      }
  }
  if (!corrections.empty()) correct<D>(fit, corrections, least_squares(entries, right, corrections.size(), 1e-12));
}

template <int D>
void balance_askew_faces(const Fit<D>& fit, const Shape& shape, const std::vector<Shape>& clamps, const Vector<D>& first) {
  const std::vector<Foot<D>> feet = feet_of<D>(fit, shape, clamps, first);
  if (std::all_of(feet.begin(), feet.end(), [](const Foot<D>& foot) { return foot.is_flush; })) return;
  std::vector<Vector<D>> push = push_of_uniform_stress<D>(fit);
  std::map<std::ptrdiff_t, Matrix<D>> borne;  // by particle: I - sum over its feet of A N x offset
  std::map<std::ptrdiff_t, Cell<D>> behind;   // askew faces, and beside those
  for (const Foot<D>& foot : feet) {
    subtract_load<D>(fit, foot.cell, foot.offset, foot.area, push);
    borne.try_emplace(fit.lattice.index(foot.cell), Matrix<D>::Identity()).first->second -= foot.area * foot.offset.transpose();
    if (foot.is_flush) continue;
    behind[fit.lattice.index(foot.cell)] = foot.cell;
    for (int a = 0; a < D; ++a)
      for (const int sign : {-1, 1}) {
        Cell<D> beside = foot.cell;
        beside[a] += sign;
        if (fit.lattice.content_of(beside) == free_particle) behind[fit.lattice.index(beside)] = beside;
      }
  }
  std::vector<Correction<D>> corrections;
  std::vector<Eigen::Triplet<double>> entries;
  std::map<std::ptrdiff_t, int> equation;  // of a cell, the first of D
  std::vector<double> right;
  for (const auto& [index, cell] : behind) {
    const auto found = borne.find(index);
    const Matrix<D> share = found == borne.end() ? Matrix<D>(Matrix<D>::Identity()) : found->second;
    for (const auto& nodes : lines_through<D>(cell, fit.lattice))
      for (int e = 0; e < D; ++e) {
        for (int m = 0; m < 3; ++m) {
          const auto node = fit.lattice.index(nodes[m]);
          const auto [entry, is_new] = equation.try_emplace(node, static_cast<int>(right.size()));
          for (int a = 0; a < D; ++a) {
            if (is_new) right.push_back(-push[node][a]);
            entries.emplace_back(entry->second + a, static_cast<int>(corrections.size()), evenly[m] * share(a, e));
          }
        }
        corrections.push_back({cell, nodes, evenly, Vector<D>::Unit(e)});
      }
  }
  for (std::size_t c = 0; c < corrections.size(); ++c) {
    entries.emplace_back(static_cast<int>(right.size()), static_cast<int>(c), restraint);
    right.push_back(0);
  }
  if (!corrections.empty()) correct<D>(fit, corrections, least_squares(entries, right, corrections.size(), 1e-6));
}

#define TERN_INSTANTIATE(D)                       \
  template void balance_clamps<D>(const Fit<D>&); \
  template void balance_askew_faces<D>(const Fit<D>&, const Shape&, const std::vector<Shape>&, const Vector<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::structure
