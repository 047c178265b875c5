#pragma once
// The lattice of a body while its reference is built: what its cells hold, and what their particles see.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/vector.hpp"
#include "structure/gradient_vectors.hpp"
#include "structure/unseen_fields.hpp"

namespace tern::structure {

template <int D>
using Cell = std::array<int, D>;

inline constexpr std::int32_t no_row = -1;

/// What a cell of the lattice holds. From `face` on: a particle on the face of a clamp, plus three to the power of the
/// axis times its shift along the axis (0, 1, 2 for -1/2, 0, 1/2 spacings).
using Content = std::uint16_t;
inline constexpr Content hidden = 0;  // nothing, or a particle inside a clamp
inline constexpr Content free_particle = 1;
inline constexpr Content face = 2;

/// The lattice of one body: where each cell went.
template <int D>
struct Lattice {
  std::array<int, D> size{};
  Matrix<D> axes;
  std::vector<std::int32_t> row;       ///< per cell, no_row where empty
  std::vector<Content> content;        ///< per cell
  std::vector<std::uint32_t> pattern;  ///< per cell: index of its Neighbourhood

  /// Lines run along the longest side.
  int line_direction() const { return static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin()); }

  Content content_of(const Cell<D>& cell) const {
    const auto n = index(cell);
    return n < 0 ? hidden : content[n];
  }

  /// -1 outside.
  std::ptrdiff_t index(const Cell<D>& cell) const {
    std::ptrdiff_t n = 0;
    for (int a = D - 1; a >= 0; --a) {
      if (cell[a] < 0 || cell[a] >= size[a]) return -1;
      n = n * size[a] + cell[a];
    }
    return n;
  }
};

template <int D>
Cell<D> shifted(Cell<D> cell, const Cell<D>& by) {
  for (int a = 0; a < D; ++a) cell[a] += by[a];
  return cell;
}

/// Cell offsets closer than `support` cells, the own cell excluded; the opposite of the n-th is the n-th from the end.
template <int D>
std::vector<Cell<D>> offsets_within(double support) {
  const int reach = static_cast<int>(std::ceil(support));
  std::vector<Cell<D>> offsets;
  Cell<D> o{};
  const auto visit = [&](auto&& self, int axis) -> void {
    if (axis == D) {
      double squared = 0;
      for (int a = 0; a < D; ++a) squared += o[a] * o[a];
      if (squared > 0 && std::sqrt(squared) < support - 1e-9) offsets.push_back(o);
      return;
    }
    for (o[axis] = -reach; o[axis] <= reach; ++o[axis]) self(self, axis + 1);
  };
  visit(visit, 0);
  return offsets;
}

/// Shift of a cell's particle from the middle of the cell along the axes of the lattice, in spacings.
template <int D>
Vector<D> shift_of(Content content) {
  Vector<D> shift = Vector<D>::Zero();
  if (content < face) return shift;
  for (int a = 0, code = content - face; a < D; ++a, code /= 3) shift[a] = 0.5 * (code % 3 - 1);
  return shift;
}

/// X_j - X_i for the particle of the cell at `offset` from `cell`.
template <int D>
Vector<D> offset_between(const Lattice<D>& lattice, const Cell<D>& cell, const Cell<D>& offset, double spacing) {
  Vector<D> x = shift_of<D>(lattice.content_of(shifted<D>(cell, offset))) - shift_of<D>(lattice.content_of(cell));
  for (int a = 0; a < D; ++a) x[a] += offset[a];
  return spacing * (lattice.axes * x);
}

template <int D>
struct Neighbourhood {
  std::vector<DerivativeVectors<D>> derivatives;  ///< one per offset, zero where there is no neighbour
  std::vector<UnseenField<D, double>> unseen;     ///< of a free particle
};

}  // namespace tern::structure
