#pragma once
// Face patches of rigid walls and elastic bodies, and what a fluid particle sees of them.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "particles/cell_grid.hpp"
#include "particles/near_points.hpp"
#include "particles/vector.hpp"

namespace tern {

/// Flat patches; all arrays of one length. Normals point into the fluid.
template <int D>
struct Faces {
  std::vector<Vector<D>> position, velocity, normal;
  std::vector<double> area;                    ///< [m^(D-1)]
  std::vector<double> normal_acceleration;     ///< of the face along its normal [m/s^2]
  std::vector<std::uint8_t> two_sided;         ///< fluid may stand behind it: it cuts lines of sight
  std::vector<int> original;                   ///< patch of which this is an image in a periodic space, or the patch itself

  std::size_t size() const { return position.size(); }
};

/// Faces seen by each particle: entries begin[i] .. begin[i] + count[i] - 1 of `face` and `weight`.
struct FaceRows {
  std::vector<int> begin, count;
  std::vector<int> face;
  std::vector<double> weight;  ///< A_k w~(r_ik) [1/m], of the wet share: sum_hidden grad w = -sum_k weight n_k
  std::vector<double> wet;     ///< per face: share of its hidden side that mirrors fluid [0, 1]; empty = 1 everywhere
  std::vector<double> height;  ///< per particle: a bound, the least of its heights above the planes of the faces [m]

  // Scratch, kept so that a step allocates nothing.
  std::vector<std::vector<int>> seen;             ///< by thread, what particles of all threads but the first see
  std::vector<std::vector<std::int64_t>> filled;  ///< by thread, per face
};

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
  // Half a patch, 10 % larger so that no ray slips between two patches of a bent surface.
  const double reach2 = D == 2 ? 0.3025 * faces.area[k] * faces.area[k] : 0.605 * faces.area[k];
  return offset.squaredNorm() < reach2;
}

/// A cell list over faces that finds what a particle sees: patches that face it within the support and that no two-sided
/// patch hides.
template <int D>
class FaceFinder {
 public:
  void fill(const Faces<D>& faces, double support) {
    support_ = support;
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
    const auto patch = [&](std::size_t m) { return seen[m] < 0 ? ~seen[m] : seen[m]; };
    // A patch hidden by another of the same surface lies clearly behind it: a tenth of a patch tells it from a neighbour.
    const auto hidden = [&](int k) {
      for (std::size_t m = first; m < seen.size(); ++m) {
        const int other = patch(m);
        if (other == k || !faces.two_sided[other]) continue;
        // What hides a patch stands in front of it: neighbours on a convex surface lie behind each other and hide nothing.
        if ((faces.position[other] - faces.position[k]).dot(faces.normal[k]) <= 0) continue;
        const double size = D == 2 ? faces.area[other] : std::sqrt(faces.area[other]);
        if (patch_separates(faces, other, x, faces.position[k], 0.1 * size)) return true;
      }
      return false;
    };
    for (std::size_t m = first; m < seen.size(); ++m)
      if (hidden(seen[m])) seen[m] = ~seen[m];
    seen.erase(std::remove_if(seen.begin() + static_cast<std::ptrdiff_t>(first), seen.end(), [](int k) { return k < 0; }),
               seen.end());
  }

  CellGrid<D> grid_;
  CellContents contents_;
  Vector<D> min_ = Vector<D>::Zero(), max_ = Vector<D>::Zero();
  double support_ = 0;
  std::array<std::vector<float>, D> coordinate_;  ///< of the patches in the order of the cells, from min_, by axis
  float limit2_ = 0;
};

}  // namespace tern
