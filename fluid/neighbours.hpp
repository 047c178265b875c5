#pragma once
// Pairs of fluid particles, found once per step at the predicted positions, and the sums over them that depend on
// positions alone. Rows are full (each pair appears in both), so every particle gathers its own sums.

#include <array>
#include <cstdint>
#include <vector>

#include "base/uninitialised.hpp"
#include "fluid/lanes.hpp"
#include "fluid/period.hpp"
#include "fluid/reference.hpp"
#include "fluid/workspace.hpp"
#include "sph/cell_grid.hpp"

namespace tern::fluid {

/// Of one row while it is summed.
struct RowScratch {
  std::vector<int> lanes_of;    ///< of each group: which of its lanes belong to the row
  std::vector<float> ordering;  ///< of each entry: V (1 + 0.2 (w/w(dx))^4) |w'_ij| / (r_ij M_xx)

  /// Makes room for this many entries.
  void reserve(std::size_t entries) {
    const std::size_t groups = entries / lanes + 2;
    if (lanes_of.size() < groups) lanes_of.resize(groups), ordering.resize(groups * lanes);
  }
};

template <int D>
struct Neighbours {
  // Row i: entries begin[i] .. begin[i] + length[i] - 1, in groups of four: particles that follow each other. Those of a group that are no
  // neighbours, the particle itself among them, have the weight 0. Weights are in single precision, for their number; moment and kernel
  // gradient are sums of the rounded ones, in double precision, so that what is exact or antisymmetric stays so.
  std::vector<int> begin, length;
  std::vector<int> count;             ///< of neighbours
  UninitialisedVector<int> first;     ///< of entries 4 g .. 4 g + 3: j of the first
  UninitialisedVector<float> weight;  ///< V_j |w'_ij| / (r_ij M_xx): V_j grad w_ij = weight (r_j - r_i) [1/m^2]
  ByAxis<D> position;                 ///< r* [m]

  /// Particles with a row; ghosts have none.
  std::size_t rows() const { return begin.size(); }
  /// j of entry k.
  int column(int k) const { return first[k / lanes] + k % lanes; }

  /// Calls visit(j, weight) for the neighbours of i.
  template <class Visit>
  void for_each(std::ptrdiff_t i, Visit&& visit) const {
    for (int k = begin[i]; k < begin[i] + length[i]; ++k)
      if (weight[k] != 0) visit(column(k), weight[k]);
  }

  // Sums over fluid neighbours.
  std::vector<double> number_density;             ///< w(0) V + sum V w [-]
  std::vector<Matrix<D>> moment;                  ///< M = sum V grad w (r_j - r_i)^T [-]
  std::vector<Vector<D>> kernel_gradient;         ///< sum V grad w [1/m]
  std::vector<Vector<D>> concentration_gradient;  ///< sum V (1 + 0.2 (w/w(dx))^4) grad w [1/m]

  std::vector<int> beside_body;  ///< particles that see a two-sided face or have lost a pair to one

  // Scratch of the search and of the cutting, kept so that a step allocates nothing.
  /// Two-sided faces that a particle sees under nearly the same normal: that of one of them, how far the others deviate from it, the
  /// smallest height of the particle above their planes, and the corners of a box around them [m].
  struct Sight {
    Vector<D> normal;
    double height, spread;
    Vector<D> low, high;
  };
  struct Cutting {
    std::vector<Sight> sight;
    std::vector<int> sight_begin;  ///< of each particle that sees any in `sight`, and the end of the last
    std::vector<int> affected;     ///< particles whose rows are looked at
    std::vector<int> listed;       ///< per particle: 0 if not affected, else 1 + its number in `sight_begin`, or more
  };
  std::array<std::vector<float>, D> coordinate;  ///< by axis, from the corner of all particles
  std::vector<RowScratch> row_scratch;           ///< by thread
  Cutting cutting;
};

/// Calls add(j, weights) for the groups of row i: particles j .. j + 3 with these weights.
template <int D, class Add>
[[gnu::always_inline]] inline void for_groups(const Neighbours<D>& neighbours, std::ptrdiff_t i, Add&& add) {
  const int* first = neighbours.first.data() + neighbours.begin[i] / lanes;
  const float *weight = neighbours.weight.data() + neighbours.begin[i], *const end = weight + neighbours.length[i];
  for (; weight < end; weight += lanes, ++first) add(*first, load(weight));
}

/// Finds pairs and sums for the particles of `order` at `position`, which must be sorted by it and lie within the period. Behind them are
/// the ghosts of `order`, which have no rows of their own in the lists. A pair across the end of the period has the column of the real
/// particle and the weight of the nearest image. Less than four particles, with ghosts, have no neighbours: they are spray.
template <int D>
void find_neighbours(const Constants<D>& constants, const Period<D>& period, const RowOrder<D>& order,
                     const std::vector<Vector<D>>& position, Neighbours<D>& neighbours);

/// Sums row i anew, without the entries whose weight has been set to 0.
template <int D>
void complete_row(const Constants<D>& constants, const Period<D>& period, int i, RowScratch& scratch, Neighbours<D>& neighbours);

}  // namespace tern::fluid
