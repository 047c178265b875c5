#include "scene/loose_particles.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace tern {
namespace {

constexpr int reach = 2;            ///< in cells: a body sees a little farther (structure.numerics.smoothing_length_ratio 1.1)
constexpr int longest_corner = 4;   ///< in cells, of what a corner loses
constexpr double most_cells = 1e9;  ///< of the box around a body, a byte each; a run needs several times as much

/// First and last cell of a lattice in each direction.
template <int D>
std::pair<std::array<long, D>, std::array<long, D>> ends_of(const LatticePoints<D>& points) {
  std::array<long, D> low, high;
  low.fill(std::numeric_limits<long>::max()), high.fill(std::numeric_limits<long>::min());
  for (const auto& run : points.runs())
    for (int d = 0; d < D; ++d) {
      low[d] = std::min(low[d], run.index[d]);
      high[d] = std::max(high[d], run.index[d] + (d == 0 ? run.count - 1 : 0));
    }
  return {low, high};
}

/// Cells in the box around the points, with its margin.
template <int D>
double box_of_cells(const LatticePoints<D>& points) {
  const auto [low, high] = ends_of(points);
  double cells = 1;
  for (int d = 0; d < D; ++d) cells *= static_cast<double>(high[d]) - static_cast<double>(low[d]) + 1 + 2 * reach;
  return cells;
}

/// The cells of a lattice as numbers of a box, with a margin of `reach` cells on all sides.
template <int D>
class Cells {
 public:
  explicit Cells(const LatticePoints<D>& points) {
    const auto [low, high] = ends_of(points);
    std::size_t size = 1;
    for (int d = 0; d < D; ++d) {
      stride_[d] = static_cast<std::ptrdiff_t>(size);
      size *= static_cast<std::size_t>(high[d] - low[d] + 1 + 2 * reach);
    }
    taken.assign(size, 0);
    cell_of.reserve(points.size());
    for (const auto& run : points.runs()) {
      std::ptrdiff_t cell = 0;
      for (int d = 0; d < D; ++d) cell += stride_[d] * (run.index[d] - low[d] + reach);
      for (long i = 0; i < run.count; ++i) cell_of.push_back(cell + i);
    }
    for (const std::ptrdiff_t cell : cell_of) taken[cell] = 1;
    std::array<int, 3> o{};
    for (o[0] = -reach; o[0] <= reach; ++o[0])
      for (o[1] = -reach; o[1] <= reach; ++o[1])
        for (o[2] = D == 3 ? -reach : 0; o[2] <= (D == 3 ? reach : 0); ++o[2]) {
          const int squared = o[0] * o[0] + o[1] * o[1] + o[2] * o[2];
          if (squared == 0 || squared > reach * reach) continue;
          std::ptrdiff_t offset = 0;
          Vector<D> way;
          for (int d = 0; d < D; ++d) offset += stride_[d] * o[d], way[d] = o[d];
          around_.emplace_back(offset, way);
          if (squared == 1) beside.push_back(offset);
        }
  }

  /// Whether the taken cells within `reach` of it lie in no line or plane with it.
  bool spans(std::ptrdiff_t cell) const {
    if (std::all_of(beside.begin(), beside.end(), [&](std::ptrdiff_t offset) { return taken[cell + offset]; })) return true;
    Matrix<D> moments = Matrix<D>::Zero();
    for (const auto& [offset, way] : around_)
      if (taken[cell + offset]) moments += way * way.transpose();
    return moments.determinant() > 0.5;  // a whole number, as its entries are
  }

  std::vector<char> taken;              ///< by cell
  std::vector<std::ptrdiff_t> cell_of;  ///< by point
  std::vector<std::ptrdiff_t> beside;   ///< offsets to the next cells

 private:
  std::array<std::ptrdiff_t, D> stride_{};
  std::vector<std::pair<std::ptrdiff_t, Vector<D>>> around_;
};

/// Marks what hangs together with the cell among those that are taken; both by cell.
void mark_connected(std::ptrdiff_t cell, const std::vector<char>& taken, const std::vector<std::ptrdiff_t>& beside,
                    std::vector<char>& marked) {
  std::vector<std::ptrdiff_t> open{cell};
  marked[cell] = 1;
  while (!open.empty()) {
    const std::ptrdiff_t from = open.back();
    open.pop_back();
    for (const std::ptrdiff_t offset : beside)
      if (taken[from + offset] && !marked[from + offset]) marked[from + offset] = 1, open.push_back(from + offset);
  }
}

/// Number of parts that hang together across the faces of cells.
template <int D>
int parts(const Cells<D>& cells) {
  std::vector<char> marked(cells.taken.size(), 0);
  int count = 0;
  for (const std::ptrdiff_t cell : cells.cell_of)
    if (cells.taken[cell] && !marked[cell]) ++count, mark_connected(cell, cells.taken, cells.beside, marked);
  return count;
}

/// Whether all of these cells are no more than `longest_corner` cells from the others, step by step across faces.
template <int D>
bool near_the_rest(const Cells<D>& cells, const std::vector<std::ptrdiff_t>& loose) {
  std::vector<char> is_far(cells.taken.size(), 0);
  for (const std::ptrdiff_t cell : loose) is_far[cell] = 1;
  std::vector<std::ptrdiff_t> far = loose;
  for (int n = 0; n < longest_corner && !far.empty(); ++n) {
    std::vector<std::ptrdiff_t> left, reached;
    for (const std::ptrdiff_t cell : far) {
      const bool near = std::any_of(cells.beside.begin(), cells.beside.end(),
                                    [&](std::ptrdiff_t offset) { return cells.taken[cell + offset] && !is_far[cell + offset]; });
      (near ? reached : left).push_back(cell);
    }
    for (const std::ptrdiff_t cell : reached) is_far[cell] = 0;
    far = std::move(left);
  }
  return far.empty();
}

}  // namespace

template <int D>
LatticePoints<D> without_loose_particles(const LatticePoints<D>& points) {
  if (points.empty() || box_of_cells(points) > most_cells) return points;
  Cells<D> cells(points);
  std::vector<std::ptrdiff_t> loose;
  for (const std::ptrdiff_t cell : cells.cell_of)
    if (!cells.spans(cell)) loose.push_back(cell);
  if (loose.empty() || !near_the_rest(cells, loose)) return points;
  const int whole = parts(cells);
  for (const std::ptrdiff_t cell : loose) cells.taken[cell] = 0;
  if (parts(cells) != whole) return points;
  std::vector<char> left_out;
  for (const std::ptrdiff_t cell : cells.cell_of) left_out.push_back(!cells.taken[cell]);
  return points.without(left_out);
}

template LatticePoints<2> without_loose_particles<2>(const LatticePoints<2>&);
template LatticePoints<3> without_loose_particles<3>(const LatticePoints<3>&);

}  // namespace tern
