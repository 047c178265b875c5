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

/// Flat patches; all arrays of one length, but for those that may be empty. Normals point into the fluid.
template <int D>
struct Faces {
  std::vector<Vector<D>> position, normal;
  std::vector<double> area;                 ///< [m^(D-1)]
  std::vector<std::uint8_t> two_sided;      ///< fluid may stand behind it: it cuts lines of sight
  std::vector<Vector<D>> velocity;          ///< [m/s]; empty: all are at rest
  std::vector<double> normal_acceleration;  ///< of the face along its normal [m/s^2]; empty: 0 everywhere
  std::vector<int> original;                ///< patch of which this is an image in a periodic space, or the patch itself; empty: no images

  std::size_t size() const { return position.size(); }
  Vector<D> velocity_of(std::size_t k) const { return velocity.empty() ? Vector<D>(Vector<D>::Zero()) : velocity[k]; }
  double acceleration_of(std::size_t k) const { return normal_acceleration.empty() ? 0 : normal_acceleration[k]; }
  int original_of(std::size_t k) const { return original.empty() ? static_cast<int>(k) : original[k]; }
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
/// farther behind than this [m]. `reach2`: how far beside its centre it may pass, squared [m^2].
template <int D>
bool patch_separates(const Faces<D>& faces, int k, const Vector<D>& a, const Vector<D>& b, double depth, double reach2) {
  const Vector<D>& n = faces.normal[k];
  const double behind = (b - faces.position[k]).dot(n);
  if (behind >= -depth) return false;
  const double front = (a - faces.position[k]).dot(n);
  if (front <= 0) return false;
  const Vector<D> offset = a + (b - a) * (front / (front - behind)) - faces.position[k];
  return offset.squaredNorm() < reach2;
}

template <int D>
bool patch_separates(const Faces<D>& faces, int k, const Vector<D>& a, const Vector<D>& b, double depth = 0) {
  return patch_separates(faces, k, a, b, depth, patch_reach2<D>(faces.area[k]));
}

/// A cell list over faces that finds what a particle sees: patches that face it within the support and that no two-sided
/// patch hides.
template <int D>
class FaceFinder {
 public:
  double support() const { return support_; }

  /// `lowest`: where `faces` are some of others, the lowest coordinates of all, in whose order these are found then.
  void fill(const Faces<D>& faces, double support, const Vector<D>* lowest = nullptr) {
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
    grid_.reset(lowest == nullptr ? min : *lowest, min, max, support);
    contents_.template fill<D>(grid_, faces.position);
    limit2_ = near_limit2<D>(support, (max_ - min_).maxCoeff());
    near2_ = surely_near_limit2<D>(support, (max_ - min_).maxCoeff());
    // A product of a normal with a way is off by what the coordinates are off, and by as much of the support as digits of the normal are.
    slack_ = static_cast<float>(1e-6 * support + std::sqrt(double(D)) * 0x3p-24 * (max_ - min_).maxCoeff());
    set_groups(faces);
  }

  /// Calls visit(k) for all faces that may be within the support of x, in whatever direction they look.
  template <class Visit>
  void for_each_around(const Vector<D>& x, Visit&& visit) const {
    for_cells_around(x, [&](int low, int high) {
      for (int m = contents_.start[low]; m < contents_.start[high + 1]; ++m) visit(contents_.order[m]);
    });
  }

  /// Calls visit(k) for those of them that are within `reach` of x.
  template <class Visit>
  void for_each_near(const Vector<D>& x, double reach, Visit&& visit) const {
    const float limit2 = near_limit2<D>(reach, (max_ - min_).maxCoeff());
    std::array<float, D> from;
    for (int c = 0; c < D; ++c) from[c] = static_cast<float>(x[c] - min_[c]);
    for_cells_around(x, [&](int low, int high) {
      for (int m = first_group_[low] * near_lanes; m < first_group_[high + 1] * near_lanes; m += near_lanes)
        for (unsigned bits = near_bits<D>(coordinate_, m, from, {}, limit2); bits != 0; bits &= bits - 1)
          visit(patch_[m + std::countr_zero(bits)]);
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

  /// Calls visit(k) for all faces within the support of x that are turned away from it: by more than faces of one plane with x.
  template <class Visit>
  void for_each_turned_around(const Faces<D>& faces, const Vector<D>& x, Visit&& visit) const {
    const auto all = [](int) { return ~0U; };
    any_group_around(x, behind_, 1, static_cast<float>(least_turned * support_), all, [&](int group, const std::array<float, D>&) {
      for (unsigned bits = turned_bits(faces, group, x); bits != 0; bits &= bits - 1)
        visit(patch_[group * near_lanes + std::countr_zero(bits)]);
      return false;
    });
  }

  /// Whether holds(k) is true for any of them. It may be asked of those alone whose normal has a product above `least` with `direction`, a
  /// unit vector.
  template <class Holds>
  bool any_turned_around(const Faces<D>& faces, const Vector<D>& x, const Vector<D>& direction, double least, Holds&& holds) const {
    std::array<float, D> along;
    for (int c = 0; c < D; ++c) along[c] = static_cast<float>(direction[c]);
    const float above = static_cast<float>(least);
    const auto turned_so = [&](int first) { return direction_bits<D>(mean_normal_, lean_, first, along, above); };
    return any_group_around(x, behind_, 1, static_cast<float>(least_turned * support_), turned_so,
                            [&](int group, const std::array<float, D>&) {
                              for (unsigned bits = turned_bits(faces, group, x); bits != 0; bits &= bits - 1)
                                if (holds(patch_[group * near_lanes + std::countr_zero(bits)])) return true;
                              return false;
                            });
  }

  /// Of the others, those that stand in groups without any that is asked: bounds of how far they lie beyond x against `direction` [m], and
  /// by how much their normals differ from -`direction` [-].
  struct Beyond {
    double least_depth, spread;
  };
  Beyond turned_beyond(const Vector<D>& x, const Vector<D>& direction, double least) const {
    std::array<float, D> along;
    for (int c = 0; c < D; ++c) along[c] = static_cast<float>(direction[c]);
    const float above = static_cast<float>(least);
    const auto turned_else = [&](int first) { return ~direction_bits<D>(mean_normal_, lean_, first, along, above); };
    std::array<float, near_lanes> depths, differences2;
    depths.fill(far_off);
    differences2.fill(0);
    any_group_around(x, behind_, 1, static_cast<float>(least_turned * support_), turned_else, [&](int group, const std::array<float, D>&) {
      const std::array<float, D> from = from_middle(group, x);
      const std::uint32_t bits = turned_patches(group, from).may;
#pragma omp simd
      for (std::uint32_t lane = 0; lane < near_lanes; ++lane) {
        const std::size_t m = static_cast<std::size_t>(group) * near_lanes + lane;
        float depth = 0, difference2 = 0;
        for (int c = 0; c < D; ++c) {
          depth -= (offset_[c][m] - from[c]) * along[c];
          difference2 += (normal_[c][m] + along[c]) * (normal_[c][m] + along[c]);
        }
        const bool is = bits >> lane & 1;
        depths[lane] = std::min(depths[lane], is ? depth : far_off);
        differences2[lane] = std::max(differences2[lane], is ? difference2 : 0);
      }
      return false;
    });
    return {double(*std::min_element(depths.begin(), depths.end())) - 1e-6 * support_,
            (1 + 1e-6) * std::sqrt(double(*std::max_element(differences2.begin(), differences2.end()))) + 1e-6};
  }

  /// Whether any face surely faces x: by more than single precision leaves open, so none that lies in one plane with x.
  bool any_facing(const Vector<D>& x) const {
    const auto all = [](int) { return ~0U; };
    return any_group_around(x, before_, -1, static_cast<float>(1e-6 * support_), all,
                            [&](int group, const std::array<float, D>& from) { return facing_bits(group, from).sure != 0; });
  }

  /// Appends to `seen` the faces that x sees. Returns a bound: the most by which the normals of two of them differ [-].
  double see(const Faces<D>& faces, const Vector<D>& x, std::vector<int>& seen) const;

 private:
  static constexpr int candidates = 256;        ///< tested at a time
  static constexpr float far_off = 1e18F;       ///< in place of a coordinate of a patch that there is none of [m]
  static constexpr double least_turned = 1e-6;  ///< height behind a face from which it is turned away, over the support

  PatchBits facing_bits(int group, const std::array<float, D>& from) const {
    return patch_bits<D>(coordinate_, normal_, group * near_lanes, from, near2_, limit2_, -1, 0, slack_);
  }
  /// x from the middle of a group. Coordinates counted from there have the digits that tell what is turned from what is in one plane with
  /// x: single precision is off by less than 6e-7 of the support.
  std::array<float, D> from_middle(int group, const Vector<D>& x) const {
    std::array<float, D> from;
    for (int c = 0; c < D; ++c) from[c] = static_cast<float>(x[c] - min_[c] - middle_[c][group]);
    return from;
  }
  PatchBits turned_patches(int group, const std::array<float, D>& from) const {
    const float least = static_cast<float>(least_turned * support_), slack = static_cast<float>(6e-7 * support_);
    return patch_bits<D>(offset_, normal_, group * near_lanes, from, near2_, limit2_, 1, least, slack);
  }
  unsigned turned_bits(const Faces<D>& faces, int group, const Vector<D>& x) const {
    const PatchBits turned = turned_patches(group, from_middle(group, x));
    unsigned bits = turned.may;
    for (unsigned open = bits & ~turned.sure; open != 0; open &= open - 1) {
      const int k = patch_[group * near_lanes + std::countr_zero(open)];
      const Vector<D> d = faces.position[k] - x;
      if (d.squaredNorm() >= support_ * support_ || d.dot(faces.normal[k]) <= least_turned * support_) bits &= ~(open & -open);
    }
    return bits;
  }

  /// Calls visit(first cell, last cell) for the rows of cells that have all patches within the support of x.
  template <class Visit>
  void for_cells_around(const Vector<D>& x, Visit&& visit) const {
    if (contents_.order.empty()) return;
    for (int c = 0; c < D; ++c)
      if (x[c] < min_[c] || x[c] > max_[c]) return;
    grid_.for_rows_around(x, visit);
  }

  /// Calls visit(groups, how many of them, x from the corner of the box) for the groups, at most `candidates`, that may have a patch within
  /// the support of x whose product, `side` times its normal and the way to it, is above `least`. `more`: before_ of `side` -1, behind_ of
  /// 1; chosen(first): bits of those of `near_lanes` groups that are asked for.
  template <class Chosen, class Visit>
  void for_groups_around(const Vector<D>& x, const std::vector<float>& more, float side, float least, Chosen&& chosen,
                         Visit&& visit) const {
    std::array<int, candidates + near_lanes> groups;
    std::array<float, D> at{}, rest{};
    for (int c = 0; c < D; ++c) {
      at[c] = static_cast<float>(x[c] - min_[c]);
      rest[c] = static_cast<float>(x[c] - min_[c] - at[c]);
    }
    int found = 0;
    for_cells_around(x, [&](int low, int high) {
      for (int first = first_group_[low], end = first_group_[high + 1]; first < end; first += near_lanes) {
        const unsigned bits = group_bits<D>(middle_, mean_normal_, first, at, rest, reach2_, more, side, least) & chosen(first);
        found = append_places(bits_before(bits, first, end), first, found, groups.data());
        if (found <= candidates - near_lanes) continue;
        visit(groups.data(), found, at);
        found = 0;
      }
    });
    if (found > 0) visit(groups.data(), found, at);
  }
  /// Whether holds(group, x from the corner of the box) is true for any of them.
  template <class Chosen, class Holds>
  bool any_group_around(const Vector<D>& x, const std::vector<float>& more, float side, float least, Chosen&& chosen, Holds&& holds) const {
    bool held = false;
    for_groups_around(x, more, side, least, chosen, [&](const int* groups, int found, const std::array<float, D>& from) {
      for (int g = 0; g < found && !held; ++g) held = holds(groups[g], from);
    });
    return held;
  }

  void set_groups(const Faces<D>& faces);
  int group_end(const Faces<D>& faces, std::ptrdiff_t cell, int begin) const;
  void bound_group(const Faces<D>& faces, int group);
  void find_hideable(const Faces<D>& faces);
  std::uint8_t hideable_in(int group, const Vector<D>& place, float across, float least, float rounding) const;
  unsigned hidden_by_any(int group, int other, float across2, float rounding) const;

  CellGrid<D> grid_;
  CellContents contents_;
  Vector<D> min_ = Vector<D>::Zero(), max_ = Vector<D>::Zero();
  double support_ = 0;
  float near2_ = 0, limit2_ = 0, slack_ = 0;

  // Patches in the order of the cells, in groups of one cell. A group has `near_lanes` places; what it has no patch for lies far off.
  std::vector<int> first_group_;                  ///< per cell, then the number of them all
  std::vector<int> patch_;                        ///< by place; -1: none
  std::array<std::vector<float>, D> coordinate_;  ///< by place and axis, from min_ [m]
  std::array<std::vector<float>, D> offset_;      ///< the same, from the middle of the group [m]
  std::array<std::vector<float>, D> normal_;      ///< the same [-]
  std::vector<float> hides_from_;                 ///< by place: depth below the patch from which it may hide another [m]
  // By group; `near_lanes` more may be read.
  std::array<std::vector<float>, D> middle_, mean_normal_;  ///< of its patches: of the box around them, from min_ [m]; [-]
  std::vector<float> radius_;                               ///< of the ball about the middle that has them [m]
  std::vector<float> reach2_;                               ///< square of the distance of the middle from where on none is near [m^2]
  std::vector<float> lean_;                                 ///< by which their normals differ from the mean at most [-]
  std::vector<float> thickness_;                            ///< their distance from the plane of middle and normal, at most [m]
  std::vector<float> before_, behind_;  ///< by how much the products of near patches that face x, or are turned away, exceed the mean's [m]
  std::vector<std::uint8_t> hideable_;  ///< bits of patches that one with two sides may hide from some place
};

}  // namespace tern
