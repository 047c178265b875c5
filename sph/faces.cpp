#include "sph/faces.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace tern {
namespace {

/// A patch hidden by another of the same surface lies clearly behind it: a tenth of a patch tells it from a neighbour.
template <int D>
double least_depth(double area) {
  return 0.1 * (D == 2 ? area : std::sqrt(area));
}

}  // namespace

template <int D>
void FaceFinder<D>::see(const Faces<D>& faces, const Vector<D>& x, std::vector<int>& seen) const {
  if (faces.size() == 0) return;
  const auto first = seen.size();
  std::array<int, candidates + near_lanes> near;
  for_ranges_around(x, [&](int begin, int end, const std::array<float, D>& from) {
    int found = 0;
    for (int m = begin; m < end; m += near_lanes) {
      const PatchBits facing = patch_bits<D>(coordinate_, normal_, m, from, near2_, limit2_, -1, slack_);
      unsigned bits = bits_before(facing.may, m, end);
      for (unsigned open = bits & ~facing.sure; open != 0; open &= open - 1) {
        const int k = contents_.order[m + std::countr_zero(open)];
        const Vector<D> d = faces.position[k] - x;
        if (d.squaredNorm() >= support_ * support_ || d.dot(faces.normal[k]) >= 0) bits &= ~(open & -open);
      }
      found = append_places(bits, m, found, near.data());
    }
    const std::size_t before = seen.size();
    seen.resize(before + static_cast<std::size_t>(found));
    for (int m = 0; m < found; ++m) seen[before + static_cast<std::size_t>(m)] = contents_.order[near[m]];
  });
  if (first < seen.size() && any_may_hide(faces, x, seen, first)) remove_hidden(faces, x, seen, first);
}

/// Whether one of the patches that x sees may hide another, by a bound. One that hides, o, stands before the plane of the other, k, and has
/// it behind its own plane by its depth (below): (p_o - p_k).(n_o + n_k) is above the depth. On a surface whose normals turn evenly that
/// is 0. Let n be the mean normal, t and z the ways from x along and across its plane, and m = n_k - (n_k.n) n = M + H t + r with a
/// symmetric H and a rest r. Then it is at most
///   max f - min f + 2 max|t| max|r| + 2 (max z - min z) max(1 - n_k.n),   f_k = 2 z_k + t_k.m_k + t_k.M .
template <int D>
bool FaceFinder<D>::any_may_hide(const Faces<D>& faces, const Vector<D>& x, const std::vector<int>& seen, std::size_t first) const {
  const std::size_t count = seen.size() - first;
  if (count > candidates) return true;
  double area = 1e300;
  for (auto m = first; m < seen.size(); ++m)
    if (faces.two_sided[seen[m]]) area = std::min(area, faces.area[seen[m]]);
  if (area == 1e300) return false;  // no patch hides another where none has two sides, as before walls
  using Lanes = std::array<double, candidates>;
  std::array<Lanes, D> along, turn;  // t and m
  Lanes across;                      // z
  Vector<D> n = Vector<D>::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const int k = seen[first + i];
    const Vector<D>&place = faces.position[k], &normal = faces.normal[k];
    for (int c = 0; c < D; ++c) along[c][i] = place[c] - x[c], turn[c][i] = normal[c];
    n += normal;
  }
  if (n.norm() < 0.5 * static_cast<double>(count)) return true;
  n.normalize();
  const double limit = 0.999 * least_depth<D>(area);

  double low = 1e300, high = -1e300, lean = 0;
#pragma omp simd reduction(min : low) reduction(max : high, lean)
  for (std::size_t i = 0; i < count; ++i) {
    double z = 0, a = 0;
    for (int c = 0; c < D; ++c) z += along[c][i] * n[c], a += turn[c][i] * n[c];
    for (int c = 0; c < D; ++c) along[c][i] -= z * n[c], turn[c][i] -= a * n[c];
    across[i] = z;
    low = std::min(low, z), high = std::max(high, z), lean = std::max(lean, 1 - a);
  }
  if (2 * (high - low) + 4 * support_ * std::sqrt(2 * lean) < limit) return false;  // as on a plane: |m| is below sqrt(2 (1 - n_k.n))

  Vector<D> sum_t = Vector<D>::Zero(), sum_m = Vector<D>::Zero();
  Eigen::Matrix<double, D, D> sum_tt, sum_mt;
  for (int c = 0; c < D; ++c) {
    for (std::size_t i = 0; i < count; ++i) sum_t[c] += along[c][i], sum_m[c] += turn[c][i];
    for (int e = 0; e < D; ++e) {
      double tt = 0, mt = 0;
#pragma omp simd reduction(+ : tt, mt)
      for (std::size_t i = 0; i < count; ++i) tt += along[c][i] * along[e][i], mt += turn[c][i] * along[e][i];
      sum_tt(c, e) = tt, sum_mt(c, e) = mt;
    }
  }
  const double number = static_cast<double>(count);
  sum_tt -= sum_t * sum_t.transpose() / number;
  sum_mt -= sum_m * sum_t.transpose() / number;
  // H leads from the plane of n into it; across it anything that lets the sum be inverted will do.
  sum_tt += (sum_tt.trace() + support_ * support_) * n * n.transpose();
  sum_tt.diagonal().array() += 1e-6 * support_ * support_;
  const Eigen::Matrix<double, D, D> slope = sum_mt * sum_tt.inverse(), bend = 0.5 * (slope + slope.transpose());
  const Vector<D> mean = (sum_m - bend * sum_t) / number;

  double least = 1e300, most = -1e300, reach2 = 0, rest2 = 0;
#pragma omp simd reduction(min : least) reduction(max : most, reach2, rest2)
  for (std::size_t i = 0; i < count; ++i) {
    double f = 2 * across[i], t2 = 0, r2 = 0;
    for (int c = 0; c < D; ++c) {
      double rest = turn[c][i] - mean[c];
      for (int e = 0; e < D; ++e) rest -= bend(c, e) * along[e][i];
      f += along[c][i] * (turn[c][i] + mean[c]);
      t2 += along[c][i] * along[c][i], r2 += rest * rest;
    }
    least = std::min(least, f), most = std::max(most, f), reach2 = std::max(reach2, t2), rest2 = std::max(rest2, r2);
  }
  return most - least + 2 * std::sqrt(reach2 * rest2) + 2 * (high - low) * lean >= limit;
}

template <int D>
void FaceFinder<D>::remove_hidden(const Faces<D>& faces, const Vector<D>& x, std::vector<int>& seen, std::size_t first) const {
  // A hidden patch may not be dropped before all have been asked: it may be the one that hides another. Until then it is
  // marked by its complement.
  // Each is held against each, and few hide one. Two looks at all of them, without branch and division and a shade less strict, so
  // that rounding decides nothing, leave those to the exact question. The first one asks only which lie behind another that lies
  // before them, in single precision. The second is patch_separates.
  using Lanes = std::array<double, candidates>;
  using ShortLanes = std::array<float, candidates>;
  std::array<Lanes, D> position, normal, from;
  std::array<ShortLanes, D> away, facing;
  Lanes front, depth, reach2;
  ShortLanes sunk;
  const float rounding = static_cast<float>(1e-5 * support_);
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
        away[c][cutters] = static_cast<float>(-d[c]);
        facing[c][cutters] = static_cast<float>(faces.normal[k][c]);
      }
      front[cutters] = d.dot(faces.normal[k]);
      depth[cutters] = least_depth<D>(faces.area[k]);
      sunk[cutters] = static_cast<float>(depth[cutters]) - rounding;
      reach2[cutters] = 1.001 * patch_reach2<D>(faces.area[k]);
      cutter[cutters++] = k;
    }
    for (auto m = first; m < seen.size(); ++m) {
      const int k = seen[m];
      if (k < 0) continue;
      const Vector<D>& place = faces.position[k];
      std::array<float, D> at, up;
      for (int c = 0; c < D; ++c) {
        at[c] = static_cast<float>(place[c] - x[c]);
        up[c] = static_cast<float>(faces.normal[k][c]);
      }
      std::int32_t behind_one = 0;  // as wide as the numbers
      for (int o = 0; o < cutters; ++o) {
        float before = 0, above = 0;
        for (int c = 0; c < D; ++c) {
          before += (away[c][o] - at[c]) * up[c];
          above += (away[c][o] - at[c]) * facing[c][o];
        }
        behind_one += (before > -rounding) & (above > sunk[o]);
      }
      if (behind_one == 0) continue;
      std::int64_t perhaps = 0;
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

template class FaceFinder<2>;
template class FaceFinder<3>;

}  // namespace tern
