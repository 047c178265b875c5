#pragma once
// Face patches of rigid walls and elastic bodies, and what a fluid particle sees of them.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

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
  std::vector<std::vector<std::int64_t>> filled;  ///< by thread, per face
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
    for (int c = 0; c < D; ++c) {
      coordinate_[c].resize(faces.size() + near_lanes);
      for (std::size_t m = 0; m < faces.size(); ++m)
        coordinate_[c][m] = static_cast<float>(faces.position[contents_.order[m]][c] - min_[c]);
    }
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

  /// Appends to `seen` the faces that x sees.
  void see(const Faces<D>& faces, const Vector<D>& x, std::vector<int>& seen) const {
    if (faces.size() == 0) return;
    for (int c = 0; c < D; ++c)
      if (x[c] < min_[c] || x[c] > max_[c]) return;
    const auto first = seen.size();
    std::array<float, D> from;
    for (int c = 0; c < D; ++c) from[c] = static_cast<float>(x[c] - min_[c]);
    bool cuts = false;
    std::array<int, candidates + near_lanes> near;
    grid_.for_rows_around(x, [&](int low, int high) {
      for (int begin = contents_.start[low], end = contents_.start[high + 1]; begin < end; begin += candidates) {
        const int found = keep_near<D>(coordinate_, begin, std::min(begin + candidates, end), -1, from, {}, limit2_, 0, near.data());
        for (int m = 0; m < found; ++m) {
          const int k = contents_.order[near[m]];
          const Vector<D> d = faces.position[k] - x;
          if (d.squaredNorm() >= support_ * support_ || d.dot(faces.normal[k]) >= 0) continue;
          seen.push_back(k);
          cuts = cuts || faces.two_sided[k];
        }
      }
    });
    if (cuts) remove_hidden(faces, x, seen, first);
  }

 private:
  static constexpr int candidates = 256;  ///< tested at a time

  void remove_hidden(const Faces<D>& faces, const Vector<D>& x, std::vector<int>& seen, std::size_t first) const {
    // A hidden patch may not be dropped before all have been asked: it may be the one that hides another. Until then it is
    // marked by its complement.
    // Each is held against each, and few hide one: a first look at all of them, patch_separates without branch and division and a
    // shade less strict, so that its rounding decides nothing, leaves those to the exact question.
    using Lanes = std::array<double, candidates>;
    std::array<Lanes, D> position, normal, from;
    Lanes front, depth, reach2;
    std::array<int, candidates> cutter;
    for (auto next = first; next < seen.size();) {
      int cutters = 0;
      for (; next < seen.size() && cutters < candidates; ++next) {
        const int k = seen[next] < 0 ? ~seen[next] : seen[next];
        if (!faces.two_sided[k]) continue;
        const Vector<D> d = x - faces.position[k];
        for (int c = 0; c < D; ++c) {
          position[c][cutters] = faces.position[k][c];
          normal[c][cutters] = faces.normal[k][c];
          from[c][cutters] = d[c];
        }
        front[cutters] = d.dot(faces.normal[k]);
        // A patch hidden by another of the same surface lies clearly behind it: a tenth of a patch tells it from a neighbour.
        depth[cutters] = 0.1 * (D == 2 ? faces.area[k] : std::sqrt(faces.area[k]));
        reach2[cutters] = 1.001 * patch_reach2<D>(faces.area[k]);
        cutter[cutters++] = k;
      }
      for (auto m = first; m < seen.size(); ++m) {
        const int k = seen[m];
        if (k < 0) continue;
        const Vector<D>& place = faces.position[k];
        std::int64_t perhaps = 0;  // as wide as the numbers
        for (int o = 0; o < cutters; ++o) {
          double behind = 0, offset2 = 0;
          for (int c = 0; c < D; ++c) behind += (place[c] - position[c][o]) * normal[c][o];
          for (int c = 0; c < D; ++c) {
            const double offset = (place[c] - position[c][o]) * front[o] - from[c][o] * behind;  // times the height between the ends
            offset2 += offset * offset;
          }
          const double height = front[o] - behind;
          perhaps += (behind < -0.999 * depth[o]) & (offset2 < reach2[o] * height * height);
        }
        for (int o = 0; perhaps > 0 && o < cutters; ++o)
          // What hides a patch stands in front of it: neighbours on a convex surface lie behind each other and hide nothing.
          if ((faces.position[cutter[o]] - place).dot(faces.normal[k]) > 0 && patch_separates(faces, cutter[o], x, place, depth[o])) {
            seen[m] = ~k;
            break;
          }
      }
    }
    seen.erase(std::remove_if(seen.begin() + static_cast<std::ptrdiff_t>(first), seen.end(), [](int k) { return k < 0; }), seen.end());
  }

  CellGrid<D> grid_;
  CellContents contents_;
  Vector<D> min_ = Vector<D>::Zero(), max_ = Vector<D>::Zero();
  double support_ = 0;
  std::array<std::vector<float>, D> coordinate_;  ///< of the patches in the order of the cells, from min_, by axis
  float limit2_ = 0;
};

}  // namespace tern
