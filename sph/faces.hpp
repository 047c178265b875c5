#pragma once
// Face patches of rigid walls and elastic bodies, and what a fluid particle sees of them.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "sph/cell_grid.hpp"
#include "sph/near_points.hpp"

namespace tern {

/// Flat patches; all arrays of one length. Normals point into the fluid.
template <int D>
struct Faces {
  std::vector<Vector<D>> position, velocity, normal;
  std::vector<double> area;                 ///< [m^(D-1)]
  std::vector<double> normal_acceleration;  ///< of the face along its normal [m/s^2]
  std::vector<std::uint8_t> two_sided;      ///< fluid may stand behind it: it cuts lines of sight
  std::vector<int> original;                ///< patch of which this is an image in a periodic space, or the patch itself

  std::size_t size() const { return position.size(); }
};

/// Faces seen by each particle: entries begin[i] .. begin[i] + count[i] - 1 of `face` and `weight`.
struct FaceRows {
  std::vector<int> begin, count;
  std::vector<int> face;
  std::vector<double> weight;  ///< A_k w~(r_ik) [1/m], of the wet share: sum_hidden grad w = -sum_k weight n_k
  std::vector<double> wet;     ///< per face: share of its hidden side that mirrors fluid [0, 1]; empty = 1 everywhere
  std::vector<double> height;  ///< per particle: a bound, the least of its heights above the planes of the faces [m]
  /// Per particle: the plane wall that is all it sees, and the share of its sums that are functions of the height. Negative: there is
  /// none. Both are empty where there is none for any.
  std::vector<std::int16_t> plane;
  std::vector<double> plane_share;

  /// Whether these are all sums. The row of the particle has the patch at the foot of the perpendicular alone then, for all.
  bool before_plane(std::ptrdiff_t i) const { return !plane.empty() && plane[i] >= 0 && plane_share[i] == 1; }

  // Scratch, kept so that a step allocates nothing.
  std::vector<std::vector<int>> seen;             ///< by thread, what particles of all threads but the first see
  std::vector<std::vector<std::int64_t>> filled;  ///< by thread, per face; between windows those of the walls are 0
};

/// Square of half a patch, 10 % larger so that no ray slips between two patches of a bent surface [m^2].
template <int D>
double patch_reach2(double area) {
  return D == 2 ? 0.3025 * area * area : 0.605 * area;
}

/// True when the segment from a (in front of the patch) to b (behind it) passes through the patch. `depth`: b must be
/// farther behind than this [m].
template <int D>
bool patch_separates(const Faces<D>& faces, int k, const Vector<D>& a, const Vector<D>& b, double depth = 0) {
  const Vector<D>& n = faces.normal[k];
  const double behind = (b - faces.position[k]).dot(n);
  if (behind >= -depth) return false;
  const double front = (a - faces.position[k]).dot(n);
  if (front <= 0) return false;
  const Vector<D> offset = a + (b - a) * (front / (front - behind)) - faces.position[k];
  return offset.squaredNorm() < patch_reach2<D>(faces.area[k]);
}

/// A cell list over faces that finds what a particle sees: patches that face it within the support and that no two-sided
/// patch hides.
template <int D>
class FaceFinder {
 public:
  double support() const { return support_; }

  void fill(const Faces<D>& faces, double support) {
    support_ = support;
    contents_.order.clear();  // of the faces before
    if (faces.size() == 0) return;
    Vector<D> min = faces.position[0], max = faces.position[0];
    for (const auto& x : faces.position) {
      min = min.cwiseMin(x);
      max = max.cwiseMax(x);
    }
    min_ = min.array() - support;
    max_ = max.array() + support;
    grid_.reset(min, max, support);
    contents_.template fill<D>(grid_, faces.position);
    limit2_ = near_limit2<D>(support, (max_ - min_).maxCoeff());
    near2_ = surely_near_limit2<D>(support, (max_ - min_).maxCoeff());
    // A product of a normal with a way is off by what the coordinates are off, and by as much of the support as digits of the normal are.
    slack_ = static_cast<float>(1e-6 * support + std::sqrt(double(D)) * 0x3p-24 * (max_ - min_).maxCoeff());
    for (int c = 0; c < D; ++c) {
      coordinate_[c].resize(faces.size() + near_lanes);
      normal_[c].resize(faces.size() + near_lanes);
    }
    parallel_for(static_cast<std::ptrdiff_t>(faces.size()), [&](std::ptrdiff_t m) {
      const int k = contents_.order[m];
      for (int c = 0; c < D; ++c) {
        coordinate_[c][m] = static_cast<float>(faces.position[k][c] - min_[c]);
        normal_[c][m] = static_cast<float>(faces.normal[k][c]);
      }
    });
  }

  /// Calls visit(k) for all faces that may be within the support of x, in whatever direction they look.
  template <class Visit>
  void for_each_around(const Vector<D>& x, Visit&& visit) const {
    if (contents_.order.empty()) return;
    for (int c = 0; c < D; ++c)
      if (x[c] < min_[c] || x[c] > max_[c]) return;
    grid_.for_rows_around(x, [&](int low, int high) {
      for (int m = contents_.start[low]; m < contents_.start[high + 1]; ++m) visit(contents_.order[m]);
    });
  }

  /// Calls visit(k) for those of them that are within `reach` of x.
  template <class Visit>
  void for_each_near(const Vector<D>& x, double reach, Visit&& visit) const {
    const float limit2 = near_limit2<D>(reach, (max_ - min_).maxCoeff());
    std::array<int, candidates + near_lanes> near;
    for_ranges_around(x, [&](int begin, int end, const std::array<float, D>& from) {
      const int found = keep_near<D>(coordinate_, begin, end, -1, from, {}, limit2, 0, near.data());
      for (int m = 0; m < found; ++m) visit(contents_.order[near[m]]);
    });
  }

  /// Marks by cell: how many cells there are, the one of a place, and whether one of those within a support of x has a mark.
  int cells() const { return contents_.order.empty() ? 0 : grid_.count(); }
  int cell(const Vector<D>& x) const { return grid_.index(x); }
  bool any_marked_around(const Vector<D>& x, const std::vector<std::uint8_t>& marked) const {
    bool found = false;
    grid_.for_rows_around(x, [&](int low, int high) {
      for (int of_row = low; of_row <= high; ++of_row) found = found || marked[of_row];
    });
    return found;
  }

  /// Calls visit(k) for all faces within the support of x that may be turned away from it.
  template <class Visit>
  void for_each_turned_around(const Vector<D>& x, Visit&& visit) const {
    std::array<int, candidates + near_lanes> near;
    for_ranges_around(x, [&](int begin, int end, const std::array<float, D>& from) {
      int found = 0;
      for (int m = begin; m < end; m += near_lanes) found = append_places(bits_before(turned_bits(m, from), m, end), m, found, near.data());
      for (int m = 0; m < found; ++m) visit(contents_.order[near[m]]);
    });
  }

  /// Whether holds(k) is true for any of them whose normal has a product above `least` with `direction`, a unit vector.
  template <class Holds>
  bool any_turned_around(const Vector<D>& x, const Vector<D>& direction, double least, Holds&& holds) const {
    std::array<float, D> along;
    for (int c = 0; c < D; ++c) along[c] = static_cast<float>(direction[c]);
    bool found = false;
    for_ranges_around(x, [&](int begin, int end, const std::array<float, D>& from) {
      for (int m = begin; m < end && !found; m += near_lanes) {
        const unsigned turned = turned_bits(m, from);
        if (turned == 0) continue;
        unsigned bits = bits_before(turned & direction_bits<D>(normal_, m, along, static_cast<float>(least - 1e-6)), m, end);
        for (; bits != 0 && !found; bits &= bits - 1) found = holds(contents_.order[m + std::countr_zero(bits)]);
      }
    });
    return found;
  }

  /// Whether any face surely faces x: by more than single precision leaves open, so none that lies in one plane with x.
  bool any_facing(const Vector<D>& x) const {
    bool found = false;
    for_ranges_around(x, [&](int begin, int end, const std::array<float, D>& from) {
      for (int m = begin; m < end && !found; m += near_lanes)
        found = bits_before(patch_bits<D>(coordinate_, normal_, m, from, near2_, limit2_, -1, slack_).sure, m, end) != 0;
    });
    return found;
  }

  /// Appends to `seen` the faces that x sees.
  void see(const Faces<D>& faces, const Vector<D>& x, std::vector<int>& seen) const;

 private:
  static constexpr int candidates = 256;  ///< tested at a time

  unsigned turned_bits(int first, const std::array<float, D>& from) const {
    return patch_bits<D>(coordinate_, normal_, first, from, near2_, limit2_, 1, slack_).may;
  }

  /// Calls visit(begin, end, x from the corner of the box) for ranges of the patches in the order of the cells, of at most `candidates`,
  /// which have all that are within the support of x.
  template <class Visit>
  void for_ranges_around(const Vector<D>& x, Visit&& visit) const {
    if (contents_.order.empty()) return;
    for (int c = 0; c < D; ++c)
      if (x[c] < min_[c] || x[c] > max_[c]) return;
    std::array<float, D> from;
    for (int c = 0; c < D; ++c) from[c] = static_cast<float>(x[c] - min_[c]);
    grid_.for_rows_around(x, [&](int low, int high) {
      for (int begin = contents_.start[low], end = contents_.start[high + 1]; begin < end; begin += candidates)
        visit(begin, std::min(begin + candidates, end), from);
    });
  }

  bool any_may_hide(const Faces<D>& faces, const Vector<D>& x, const std::vector<int>& seen, std::size_t first) const;
  void remove_hidden(const Faces<D>& faces, const Vector<D>& x, std::vector<int>& seen, std::size_t first) const;

  CellGrid<D> grid_;
  CellContents contents_;
  Vector<D> min_ = Vector<D>::Zero(), max_ = Vector<D>::Zero();
  double support_ = 0;
  std::array<std::vector<float>, D> coordinate_;  ///< of the patches in the order of the cells, from min_, by axis
  std::array<std::vector<float>, D> normal_;      ///< the same
  float near2_ = 0, limit2_ = 0, slack_ = 0;
};

}  // namespace tern
