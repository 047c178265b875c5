#pragma once
// The order of the particles: rows along x, a spacing wide across, and within a row by x. What a particle sees of a row then lies side by
// side, and sums over pairs read it four at a time (lanes.hpp). Cells cut the rows into pieces, by which they are found.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "sph/cell_grid.hpp"

namespace tern::fluid {

/// Of a row, in spacings: of what sums over pairs read together, most are neighbours.
constexpr double row_width(int dimension) { return dimension == 2 ? 1.5 : 2; }

template <int D>
class RowGrid {
 public:
  /// Cells of this length along x and this width across that cover the box [min, max]. Throws NumericalFailure when that takes more than
  /// a hundred million of them: something has been flung far off.
  void reset(const Vector<D>& min, const Vector<D>& max, double length, double width) {
    origin_ = min;
    double cells = 1;
    extent_ = 0;
    for (int c = 0; c < D; ++c) {
      width_[c] = c == 0 ? length : width;
      inverse_width_[c] = 1 / width_[c];
      cells *= 1 + (max[c] - min[c]) * inverse_width_[c];
      extent_ = std::max(extent_, max[c] - min[c]);
    }
    if (!(cells <= 1e8))
      throw NumericalFailure(
          fmt::format("Particles lie up to {:.4g} m apart, too far for rows of {:.4g} m: some have been flung off. The motion has become "
                      "unstable; look "
                      "at the last frames, or try a smaller fluid.numerics.courant.",
                      (max - min).norm(), width));
    count_ = 1;
    for (int c = 0; c < D; ++c) {
      size_[c] = std::max(1, static_cast<int>(std::floor((max[c] - min[c]) * inverse_width_[c])) + 1);
      count_ *= size_[c];
    }
  }

  int count() const { return count_; }
  const Vector<D>& origin() const { return origin_; }
  double extent() const { return extent_; }  ///< largest side of the box

  /// Number of the cell of a point; of the nearest cell for one outside.
  int index(const Vector<D>& x) const {
    int index = 0;
    for (int c = D - 1; c >= 0; --c) index = index * size_[c] + std::clamp(place(x, c), 0, size_[c] - 1);
    return index;
  }

  /// Calls visit(first_cell, last_cell) for a part of each row of cells that holds all its points nearer to x than `reach`.
  template <class Visit>
  [[gnu::always_inline]] inline void for_rows_around(const Vector<D>& x, double reach, Visit&& visit) const {
    std::array<int, D> low, high;
    for (int c = 0; c < D; ++c) {
      const double at = x[c] - origin_[c];
      low[c] = std::max(static_cast<int>(std::floor((at - reach) * inverse_width_[c])), 0);
      high[c] = std::min(static_cast<int>(std::floor((at + reach) * inverse_width_[c])), size_[c] - 1);
    }
    if (low[0] > high[0]) return;
    for (int k = D == 3 ? low[D - 1] : 0; k <= (D == 3 ? high[D - 1] : 0); ++k)
      for (int j = low[1]; j <= high[1]; ++j) {
        if (D == 3 && away2(x, 1, j) + away2(x, 2, k) >= reach * reach) continue;
        const int row = (D == 3 ? k * size_[1] + j : j) * size_[0];
        visit(row + low[0], row + high[0]);
      }
  }

 private:
  int place(const Vector<D>& x, int c) const { return static_cast<int>(std::floor((x[c] - origin_[c]) * inverse_width_[c])); }

  /// Square of the distance from x to the cells of this place on axis c, along it.
  double away2(const Vector<D>& x, int c, int place) const {
    const double at = x[c] - origin_[c], away = std::max({0.0, place * width_[c] - at, at - (place + 1) * width_[c]});
    return away * away;
  }

  Vector<D> origin_ = Vector<D>::Zero();
  std::array<double, D> width_{}, inverse_width_{};
  std::array<int, D> size_{};
  double extent_ = 0;
  int count_ = 1;
};

/// Fills `contents` with the order of points in the rows of this grid. before(a, b): the order of points a and b with the same x.
template <int D, class Before>
void fill_rows(const RowGrid<D>& grid, const std::vector<Vector<D>>& position, Before&& before, CellContents& contents) {
  contents.template fill<D>(grid, position);
  const auto in_row = [&](int a, int b) {
    const double x = position[a][0], y = position[b][0];
    return x < y || (x == y && before(a, b));
  };
  parallel_for(grid.count(), static_cast<std::ptrdiff_t>(position.size()), [&](int cell) {
    const auto first = contents.order.begin() + contents.start[cell], last = contents.order.begin() + contents.start[cell + 1];
    if (last - first > 1) std::sort(first, last, in_row);
  });
}

}  // namespace tern::fluid
