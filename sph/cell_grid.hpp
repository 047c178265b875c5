#pragma once
// Uniform grid of cells as wide as the kernel support. Points are put in order of their cell by a stable counting sort:
// points of one cell keep their previous order, x runs fastest, so a row of adjacent cells is one contiguous range.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"

namespace tern {

template <int D>
class CellGrid {
 public:
  /// Cells of width `width` covering the box [min, max]; points outside belong to the nearest cell. Throws NumericalFailure
  /// when that takes more than a hundred million of them: something has been flung far off.
  void reset(const Vector<D>& min, const Vector<D>& max, double width) { reset(min, min, max, width); }
  /// The same cells as if they began at `origin`, which is nowhere above `min`.
  void reset(const Vector<D>& origin, const Vector<D>& min, const Vector<D>& max, double width) {
    origin_ = origin;
    inverse_width_ = 1 / width;
    double cells = 1;
    for (int c = 0; c < D; ++c) cells *= 1 + (max[c] - min[c]) * inverse_width_;
    if (!(cells <= 1e8))
      throw NumericalFailure(fmt::format(
          "Particles or surface points lie up to {:.4g} m apart, too far for cells of {:.4g} m: some have been flung off. The motion "
          "has become unstable; look at the last frames, or try a smaller fluid.numerics.courant.",
          (max - min).norm(), width));
    count_ = 1;
    for (int c = 0; c < D; ++c) {
      first_[c] = static_cast<int>(std::floor((min[c] - origin[c]) * inverse_width_));
      size_[c] = std::max(1, static_cast<int>(std::floor((max[c] - origin[c]) * inverse_width_)) - first_[c] + 1);
      count_ *= size_[c];
    }
  }

  int count() const { return count_; }
  const Vector<D>& origin() const { return origin_; }
  /// Largest side of the box of all cells.
  double extent() const { return *std::max_element(size_.begin(), size_.end()) / inverse_width_; }

  std::array<int, D> coordinates(const Vector<D>& x) const {
    std::array<int, D> cell;
    for (int c = 0; c < D; ++c)
      cell[c] = std::clamp(static_cast<int>(std::floor((x[c] - origin_[c]) * inverse_width_)) - first_[c], 0, size_[c] - 1);
    return cell;
  }

  int index(const Vector<D>& x) const {
    const auto cell = coordinates(x);
    int index = cell[D - 1];
    for (int c = D - 2; c >= 0; --c) index = index * size_[c] + cell[c];
    return index;
  }

  /// Calls visit(first_cell, last_cell) for each row of cells around x: all cells within so many widths of it, x running.
  template <int widths = 1, class Visit>
  void for_rows_around(const Vector<D>& x, Visit&& visit) const {
    const auto cell = coordinates(x);
    const auto first = [&](int c) { return std::max(cell[c] - widths, 0); };
    const auto last = [&](int c) { return std::min(cell[c] + widths, size_[c] - 1); };
    const int low = first(0), high = last(0);
    for (int k = D == 3 ? first(D - 1) : 0; k <= (D == 3 ? last(D - 1) : 0); ++k)
      for (int j = first(1); j <= last(1); ++j) {
        const int row = (D == 3 ? k * size_[1] + j : j) * size_[0];
        visit(row + low, row + high);
      }
  }

 private:
  Vector<D> origin_ = Vector<D>::Zero();
  double inverse_width_ = 1;
  std::array<int, D> size_{}, first_{};
  int count_ = 1;
};

/// Which points lie in which cell: points order[start[c]] .. order[start[c + 1] - 1] lie in cell c, in ascending order.
struct CellContents {
  std::vector<int> start, order, cell;

  /// `grid` numbers the cells: CellGrid, or another with the same functions.
  template <int D, class Grid>
  void fill(const Grid& grid, std::span<const Vector<D>> points) {
    const int n = static_cast<int>(points.size());
    start.assign(grid.count() + 1, 0);
    order.resize(n);
    cell.resize(n);
    parallel_for(n, [&](int i) { cell[i] = grid.index(points[i]); });
    for (int i = 0; i < n; ++i) ++start[cell[i] + 1];
    for (int c = 0; c < grid.count(); ++c) start[c + 1] += start[c];
    for (int i = 0; i < n; ++i) order[start[cell[i]]++] = i;
    for (int c = grid.count(); c > 0; --c) start[c] = start[c - 1];
    start[0] = 0;
  }
};

}  // namespace tern
