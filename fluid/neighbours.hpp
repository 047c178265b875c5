#pragma once
// Pairs of fluid particles, found once per step at the predicted positions, and the sums over them that depend on
// positions alone. Rows are full (each pair appears in both), so every particle gathers its own sums.

#include <array>
#include <cstdint>
#include <vector>

#include "base/uninitialised.hpp"
#include "fluid/period.hpp"
#include "fluid/reference.hpp"
#include "fluid/workspace.hpp"
#include "sph/cell_grid.hpp"

namespace tern::fluid {

template <int D>
struct Neighbours {
  // Row i: entries begin[i] .. begin[i] + count[i] - 1. The next row begins at the next multiple of four; the entries before
  // it are those of the particle itself with weight 0. Weights are in single precision, for their number; moment and kernel
  // gradient are sums of the rounded ones, in double precision, so that what is exact or antisymmetric stays so.
  std::vector<int> begin, count;
  UninitialisedVector<int> column;    ///< j
  UninitialisedVector<float> weight;  ///< V_j |w'_ij| / (r_ij M_xx): V_j grad w_ij = weight (r_j - r_i) [1/m^2]

  // Sums over fluid neighbours.
  std::vector<double> number_density;             ///< w(0) V + sum V w [-]
  std::vector<Matrix<D>> moment;                  ///< M = sum V grad w (r_j - r_i)^T [-]
  std::vector<Vector<D>> kernel_gradient;         ///< sum V grad w [1/m]
  std::vector<Vector<D>> concentration_gradient;  ///< sum V (1 + 0.2 (w/w(dx))^4) grad w [1/m]

  std::size_t rows() const { return begin.size(); }

  std::vector<int> beside_body;  ///< particles that see a two-sided face or have lost a pair to one

  // Scratch of the search and of the cutting, kept so that a step allocates nothing.
  /// What a particle sees of two-sided faces: the normal of one of them, how far the others deviate from it, and its
  /// smallest height above their planes.
  struct Sight {
    Vector<D> normal;
    double height, spread;
  };
  struct Cutting {
    std::vector<Sight> sight;
    std::vector<int> affected;  ///< particles whose rows are looked at
    std::vector<int> listed;    ///< per particle: 0 if not affected, else 1 + the number of its sight, or more
  };
  std::array<std::vector<float>, D> coordinate;                ///< by axis
  std::vector<std::array<std::vector<double>, D>> row_offset;  ///< by thread
  Cutting cutting;
};

/// Calls add(sum, k) for the entries k of row i with the two sums in turns, so that one need not wait for the other. The last
/// entry may be one that fills up the row.
template <int D, class Sum, class Add>
void for_row_in_turns(const Neighbours<D>& neighbours, std::ptrdiff_t i, Sum& even, Sum& odd, Add&& add) {
  const int last = neighbours.begin[i] + neighbours.count[i];
  for (int k = neighbours.begin[i]; k < last; k += 2) {
    add(even, k);
    add(odd, k + 1);
  }
}

/// Finds pairs and sums for the particles of `cells` at `position`, which must be sorted by it and lie within the period. Behind them are
/// the ghosts of `cells`, which have no rows. A pair across the end of the period has the column of the real particle and the weight of the
/// nearest image.
template <int D>
void find_neighbours(const Constants<D>& constants, const Period<D>& period, const CellOrder<D>& cells,
                     const std::vector<Vector<D>>& position, Neighbours<D>& neighbours);

/// Sums row i anew over its first n entries, which `column` holds already. `offset`: scratch.
template <int D>
void complete_row(const Constants<D>& constants, const Period<D>& period, const std::vector<Vector<D>>& position, int i, int n,
                  std::array<std::vector<double>, D>& offset, Neighbours<D>& neighbours);

}  // namespace tern::fluid
