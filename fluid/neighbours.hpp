#pragma once
// Pairs of fluid particles, found once per step at the predicted positions, and the sums over them that depend on
// positions alone. Rows are full (each pair appears in both), so every particle gathers its own sums.

#include <array>
#include <cstdint>
#include <vector>

#include "fluid/state.hpp"
#include "particles/faces.hpp"

namespace tern::fluid {

template <int D>
struct Neighbours {
  // Row i: entries begin[i] .. begin[i] + count[i] - 1.
  std::vector<int> begin, count;
  std::vector<int> column;     ///< j
  std::vector<double> weight;  ///< V_j |w'_ij| / (r_ij M_xx): V_j grad w_ij = weight (r_j - r_i) [1/m^2]

  // Sums over fluid neighbours.
  std::vector<double> number_density;              ///< w(0) V + sum V w [-]
  std::vector<Matrix<D>> moment;                   ///< M = sum V grad w (r_j - r_i)^T [-]
  std::vector<Vector<D>> kernel_gradient;          ///< sum V grad w [1/m]
  std::vector<Vector<D>> concentration_gradient;   ///< sum V (1 + 0.2 (w/w(dx))^4) grad w [1/m]

  std::array<std::vector<double>, D> coordinate;   ///< positions by axis, for the search

  std::size_t pairs() const;
};

/// Finds pairs and sums for all particles at `position`, which must be sorted by `contents` of `grid`.
template <int D>
void find_neighbours(const Constants<D>& constants, const CellGrid<D>& grid, const CellContents& contents,
                     const std::vector<Vector<D>>& position, Neighbours<D>& neighbours);

/// Takes out pairs whose connecting line passes through a two-sided face that either particle sees, and sums those rows
/// anew. `rows` lists the faces seen by each particle. The fluid on one side of a plate does not see the fluid on the other.
template <int D>
void cut_pairs_through_faces(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& faces,
                             const FaceRows& rows, Neighbours<D>& neighbours);

}  // namespace tern::fluid
