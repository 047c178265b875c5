#include "sph/faces.hpp"

#include <algorithm>
#include <cmath>

namespace tern {
namespace {

/// A patch hidden by another of the same surface lies clearly behind it: a tenth of a patch tells it from a neighbour.
template <int D>
double least_depth(double area) {
  return 0.1 * (D == 2 ? area : std::sqrt(area));
}

constexpr int most_cutters = 256;  ///< looked at together

/// Takes out of `seen`, from `first` on, the faces that others of these hide from x. Only those at the places `hideable` are asked.
template <int D>
void remove_hidden(const Faces<D>& faces, double support, const Vector<D>& x, const std::vector<std::size_t>& hideable, std::size_t first,
                   std::vector<int>& seen) {
  // A hidden patch may not be dropped before all have been asked: it may be the one that hides another. Until then it is
  // marked by its complement.
  // Each is held against all, and few hide one. A look at all of them, without branches, in single precision and a shade less strict, so
  // that rounding decides nothing, asks which lie before the patch and have it behind them. The exact question is left to those.
  using Lanes = std::array<float, most_cutters>;
  std::array<Lanes, D> away, facing;
  Lanes sunk;
  std::array<std::int32_t, most_cutters> may;  // as wide as the numbers
  std::array<int, most_cutters> cutter;
  const float rounding = static_cast<float>(1e-5 * support);
  for (auto next = first; next < seen.size();) {
    int cutters = 0;
    for (; next < seen.size() && cutters < most_cutters; ++next) {
      const int k = seen[next] < 0 ? ~seen[next] : seen[next];
      if (!faces.two_sided[k]) continue;
      const Vector<D> d = faces.position[k] - x;
      for (int c = 0; c < D; ++c) {
        away[c][cutters] = static_cast<float>(d[c]);
        facing[c][cutters] = static_cast<float>(faces.normal[k][c]);
      }
      sunk[cutters] = static_cast<float>(least_depth<D>(faces.area[k])) - rounding;
      cutter[cutters++] = k;
    }
    for (const std::size_t m : hideable) {
      const int k = seen[m];
      if (k < 0) continue;
      const Vector<D>& place = faces.position[k];
      std::array<float, D> at, up;
      for (int c = 0; c < D; ++c) {
        at[c] = static_cast<float>(place[c] - x[c]);
        up[c] = static_cast<float>(faces.normal[k][c]);
      }
      std::int32_t any_may = 0;
      for (int o = 0; o < cutters; ++o) {
        float before = 0, above = 0;
        for (int c = 0; c < D; ++c) {
          before += (away[c][o] - at[c]) * up[c];
          above += (away[c][o] - at[c]) * facing[c][o];
        }
        may[o] = (before > -rounding) & (above > sunk[o]);
        any_may += may[o];
      }
      for (int o = 0; any_may > 0 && o < cutters; ++o)
        // What hides a patch stands in front of it: neighbours on a convex surface lie behind each other and hide nothing.
        if (may[o] && (faces.position[cutter[o]] - place).dot(faces.normal[k]) > 0 &&
            patch_separates(faces, cutter[o], x, place, least_depth<D>(faces.area[cutter[o]]))) {
          seen[m] = ~k;
          break;
        }
    }
  }
  seen.erase(std::remove_if(seen.begin() + static_cast<std::ptrdiff_t>(first), seen.end(), [](int k) { return k < 0; }), seen.end());
}

}  // namespace

/// Where a group of the cell `cell` that begins at `begin`, in the order of the cells, ends. The two sides of a plate are in different
/// groups, unless they come by turns.
template <int D>
int FaceFinder<D>::group_end(const Faces<D>& faces, std::ptrdiff_t cell, int begin) const {
  const int most = std::min(begin + near_lanes, contents_.start[cell + 1]);
  const Vector<D>& normal = faces.normal[contents_.order[begin]];
  const auto is_alike = [&](int m) { return normal.dot(faces.normal[contents_.order[m]]) > 0; };
  int end = begin + 1;
  while (end < most && is_alike(end)) ++end;
  const bool goes_on = begin > contents_.start[cell] && is_alike(begin - 1);
  return goes_on || end - begin >= near_lanes / 2 ? end : most;
}

template <int D>
void FaceFinder<D>::set_groups(const Faces<D>& faces) {
  const int cells = grid_.count();
  const auto for_cells = [&](const auto& work) {
    parallel_for(static_cast<std::ptrdiff_t>(cells), static_cast<std::ptrdiff_t>(faces.size()), work);
  };
  first_group_.assign(static_cast<std::size_t>(cells) + 1, 0);
  for_cells([&](std::ptrdiff_t cell) {
    for (int begin = contents_.start[cell]; begin < contents_.start[cell + 1]; begin = group_end(faces, cell, begin))
      ++first_group_[cell + 1];
  });
  for (int cell = 0; cell < cells; ++cell) first_group_[cell + 1] += first_group_[cell];
  const std::size_t groups = static_cast<std::size_t>(first_group_[cells]), places = groups * near_lanes;
  patch_.resize(places);
  hides_from_.resize(places);
  for (auto* by_axis : {&coordinate_, &offset_, &normal_})
    for (auto& of : *by_axis) of.resize(places);
  for (auto* by_axis : {&middle_, &mean_normal_})
    for (auto& of : *by_axis) of.resize(groups + near_lanes);
  for (auto* of : {&radius_, &reach2_, &lean_, &thickness_, &before_, &behind_}) of->resize(groups + near_lanes);
  for_cells([&](std::ptrdiff_t cell) {
    int begin = contents_.start[cell];
    for (int group = first_group_[cell]; group < first_group_[cell + 1]; ++group) {
      const int end = group_end(faces, cell, begin), first = group * near_lanes;
      for (int lane = 0; lane < near_lanes; ++lane) patch_[first + lane] = begin + lane < end ? contents_.order[begin + lane] : -1;
      bound_group(faces, group);
      begin = end;
    }
  });
  find_hideable(faces);
}

/// Sets what lies at the places of a group, and its bounds. What single precision makes of middle and normal and of those of a patch
/// differs from what they are by less than the margins.
template <int D>
void FaceFinder<D>::bound_group(const Faces<D>& faces, int group) {
  const int begin = group * near_lanes;
  int end = begin;
  Vector<D> low = Vector<D>::Constant(1e300), high = -low, middle, normal, sum = Vector<D>::Zero();
  for (; end < begin + near_lanes && patch_[end] >= 0; ++end) {
    const Vector<D> at = faces.position[patch_[end]] - min_;
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
    sum += faces.normal[patch_[end]];
  }
  for (int c = 0; c < D; ++c) {
    middle[c] = middle_[c][group] = static_cast<float>(0.5 * (low[c] + high[c]));
    normal[c] = mean_normal_[c][group] = static_cast<float>(sum[c] / (end - begin));
  }
  for (int m = begin; m < begin + near_lanes; ++m)
    for (int c = 0; c < D; ++c) {
      const bool is = m < end;
      coordinate_[c][m] = is ? static_cast<float>(faces.position[patch_[m]][c] - min_[c]) : far_off;
      offset_[c][m] = is ? static_cast<float>(faces.position[patch_[m]][c] - min_[c] - middle[c]) : far_off;
      normal_[c][m] = is ? static_cast<float>(faces.normal[patch_[m]][c]) : 0;
    }
  double radius2 = 0, lean2 = 0, lowest = 1e300, highest = -1e300;
  for (int m = begin; m < end; ++m) {
    const Vector<D> offset = faces.position[patch_[m]] - min_ - middle;
    const double height = offset.dot(normal);
    radius2 = std::max(radius2, offset.squaredNorm());
    lean2 = std::max(lean2, (faces.normal[patch_[m]] - normal).squaredNorm());
    lowest = std::min(lowest, height), highest = std::max(highest, height);
  }
  const double limit = std::sqrt(limit2_), radius = std::sqrt(radius2), lean = std::sqrt(lean2);
  const double reach = (1 + 1e-6) * (limit + radius), margin = 0x3p-23 * (2 * limit + radius);
  radius_[group] = static_cast<float>((1 + 1e-6) * radius);
  reach2_[group] = static_cast<float>((1 + 1e-6) * reach * reach);
  lean_[group] = static_cast<float>((1 + 1e-6) * lean + 1e-6);
  thickness_[group] = static_cast<float>((1 + 1e-6) * std::max(-lowest, highest));
  before_[group] = static_cast<float>(limit * lean - lowest + margin);
  behind_[group] = static_cast<float>(limit * lean + highest + margin);
}

/// A patch may hide another from some place only where it stands before the other's plane and has it behind its own by its depth, and
/// where it reaches the way from there to the other, which is shorter than the support. So on a plate, or on a surface that turns evenly,
/// none does.
template <int D>
void FaceFinder<D>::find_hideable(const Faces<D>& faces) {
  hideable_.assign(patch_.size() / near_lanes, 0);
  const double extent = (max_ - min_).maxCoeff();
  const float rounding = static_cast<float>(1e-5 * support_ + std::sqrt(double(D)) * 0x3p-23 * extent);
  float least = far_off;
  double largest_reach2 = 0;
  for (std::size_t m = 0; m < patch_.size(); ++m) {
    const int k = patch_[m];
    hides_from_[m] = k >= 0 && faces.two_sided[k] ? static_cast<float>(least_depth<D>(faces.area[k])) - rounding : far_off;
    least = std::min(least, hides_from_[m]);
    if (k >= 0 && faces.two_sided[k]) largest_reach2 = std::max(largest_reach2, patch_reach2<D>(faces.area[k]));
  }
  if (least == far_off) return;  // none has two sides, as before walls
  const float across = static_cast<float>(support_ + std::min(support_, std::sqrt(largest_reach2))) + rounding;
  parallel_for(static_cast<std::ptrdiff_t>(hideable_.size()), static_cast<std::ptrdiff_t>(patch_.size()), [&](std::ptrdiff_t group) {
    hideable_[group] = hideable_in(static_cast<int>(group), faces.position[patch_[group * near_lanes]], across, least, rounding);
  });
}

/// Bits of the patches of a group, of which one lies at `place`. `across`: how far from them those are that are asked [m]; `least`: of
/// hides_from_.
template <int D>
std::uint8_t FaceFinder<D>::hideable_in(int group, const Vector<D>& place, float across, float least, float rounding) const {
  unsigned found = 0;
  grid_.template for_rows_around<2>(place, [&](int low, int high) {
    for (int first = first_group_[low], end = first_group_[high + 1]; first < end; first += near_lanes) {
      // Of what a patch of each of these groups and one of this have at most: the first one's height above the second one's plane, and
      // the second one's depth below the first one's.
      std::array<std::int32_t, near_lanes> may;
      for (int g = 0; g < near_lanes; ++g) {
        float before = 0, above = 0, distance2 = 0, apart2 = 0, opposite2 = 0;
        for (int c = 0; c < D; ++c) {
          const float way = middle_[c][first + g] - middle_[c][group];
          const float other = mean_normal_[c][first + g], own = mean_normal_[c][group];
          before += way * own, above += way * other, distance2 += way * way;
          apart2 += (other - own) * (other - own), opposite2 += (other + own) * (other + own);
        }
        const float turn = std::sqrt(std::min(apart2, opposite2)), thickness = thickness_[first + g] + thickness_[group];
        const float reach = across + radius_[first + g] + radius_[group];
        before += thickness + radius_[first + g] * turn + across * lean_[group];
        above += thickness + radius_[group] * turn + across * lean_[first + g];
        may[g] = (before > -rounding) & (above > least) & (distance2 < reach * reach);
      }
      for (int g = 0; g < near_lanes && first + g < end; ++g)
        if (may[g]) found |= hidden_by_any(group, first + g, across * across, rounding);
    }
  });
  return static_cast<std::uint8_t>(found);
}

/// Bits of the patches of a group that one of `other` may hide from some place.
template <int D>
unsigned FaceFinder<D>::hidden_by_any(int group, int other, float across2, float rounding) const {
  unsigned found = 0;
  for (int lane = 0; lane < near_lanes; ++lane) {
    const int m = group * near_lanes + lane;
    std::int32_t any = 0;
    for (int o = other * near_lanes; o < (other + 1) * near_lanes; ++o) {
      float before = 0, above = 0, distance2 = 0;
      for (int c = 0; c < D; ++c) {
        const float way = coordinate_[c][o] - coordinate_[c][m];
        before += way * normal_[c][m], above += way * normal_[c][o], distance2 += way * way;
      }
      any += (before > -rounding) & (above > hides_from_[o]) & (distance2 < across2);
    }
    found |= static_cast<unsigned>(any != 0) << lane;
  }
  return found;
}

template <int D>
double FaceFinder<D>::see(const Faces<D>& faces, const Vector<D>& x, std::vector<int>& seen) const {
  if (faces.size() == 0) return 0;
  const auto first = seen.size();
  thread_local std::vector<std::size_t> kept;  // places in `seen` of patches that another may hide
  std::vector<std::size_t>& hideable = kept;
  hideable.clear();
  float apart2 = 0, lean = 0;  // of the normals from the mean of one of the groups: of the other means, and of each from its own
  int one = -1;
  std::array<int, candidates * near_lanes + near_lanes> near;
  const auto all = [](int) { return ~0U; };
  for_groups_around(x, before_, -1, -slack_, all, [&](const int* groups, int count, const std::array<float, D>& from) {
    if (one < 0) one = groups[0];
    int found = 0;
    for (int g = 0; g < count; ++g) {
      const int group = groups[g], m = group * near_lanes;
      const PatchBits facing = facing_bits(group, from);
      unsigned bits = facing.may;
      for (unsigned open = bits & ~facing.sure; open != 0; open &= open - 1) {
        const int k = patch_[m + std::countr_zero(open)];
        const Vector<D> d = faces.position[k] - x;
        if (d.squaredNorm() >= support_ * support_ || d.dot(faces.normal[k]) >= 0) bits &= ~(open & -open);
      }
      for (unsigned may = bits & hideable_[group]; may != 0; may &= may - 1)
        hideable.push_back(seen.size() + static_cast<std::size_t>(found + std::popcount(bits & ((may & -may) - 1))));
      found = append_values(bits, patch_.data(), m, found, near.data());
      float difference2 = 0;
      for (int c = 0; c < D; ++c)
        difference2 += (mean_normal_[c][group] - mean_normal_[c][one]) * (mean_normal_[c][group] - mean_normal_[c][one]);
      apart2 = std::max(apart2, bits != 0 ? difference2 : 0);
      lean = std::max(lean, bits != 0 ? lean_[group] : 0);
    }
    seen.insert(seen.end(), near.begin(), near.begin() + found);
  });
  if (!hideable.empty()) remove_hidden(faces, support_, x, hideable, first, seen);
  return 2 * (1 + 1e-6) * (std::sqrt(double(apart2)) + double(lean));
}

template class FaceFinder<2>;
template class FaceFinder<3>;

}  // namespace tern
