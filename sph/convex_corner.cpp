#include "sph/convex_corner.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.hpp"

namespace tern {
namespace {

/// Of the half space before a face, the least that may be open to fluid: what three faces at right angles leave in the corner between
/// them. No particle comes into a narrower one.
constexpr double least_open = 0.25;

/// Of the angle between normals: below it faces are one sheet, bent, and not the sides of a corner. Only asked for the sake of speed.
constexpr double sheet_cosine = 0.5;

/// What single precision is off by at most, as a share of the support, where lengths are within two of it.
constexpr double rounding = 1e-5;

/// What the cones from x through these faces, from there on, add to the sum of w~. `side`: 1 of faces that look at x, -1 of others.
template <int D>
double behind_cones(const Faces<D>& structure, const FaceKernel<D>& kernel, const Vector<D>& x, const std::vector<int>& faces,
                    double side) {
  constexpr std::size_t together = 32;
  std::array<std::array<float, together>, D> way, facing;
  std::array<float, together> area, behind;
  double sum = 0;
  for (std::size_t first = 0; first < faces.size(); first += together) {
    const std::size_t here = std::min(together, faces.size() - first);
    for (std::size_t m = 0; m < here; ++m) {
      const int k = faces[first + m];
      for (int c = 0; c < D; ++c) {
        way[c][m] = static_cast<float>(structure.position[k][c] - x[c]);
        facing[c][m] = static_cast<float>(side * structure.normal[k][c]);
      }
      area[m] = static_cast<float>(structure.area[k]);
    }
    const ConeKernel& cone = kernel.cones();
#pragma omp simd
    for (std::size_t m = 0; m < here; ++m) {
      float d[D], n[D], distance2 = 0, height = 0;
      for (int c = 0; c < D; ++c) {
        d[c] = way[c][m], n[c] = facing[c][m];
        distance2 += d[c] * d[c], height -= d[c] * n[c];
      }
      const float r = std::sqrt(distance2);
      behind[m] = cone(r, subtended_angle<D>(d, n, area[m]), area[m], height / r);
    }
    for (std::size_t m = 0; m < here; ++m) sum += double(behind[m]);
  }
  return sum;
}

}  // namespace

template <int D>
void FacesFrom::set(const Faces<D>& faces, const Vector<D>& x, const int* first, int count) {
  const std::size_t filled = (static_cast<std::size_t>(count) + lanes - 1) / lanes * lanes;
  face.assign(first, first + count);
  for (int c = 0; c < D; ++c) {
    way[c].assign(filled, 0);
    normal[c].assign(filled, 0);
  }
  front.assign(filled, -1e30F);  // what fills the last lanes has everything on one side
  reach.assign(filled, 0);
  for (int o = 0; o < count; ++o) {
    const int k = first[o];
    const Vector<D> d = faces.position[k] - x;
    for (int c = 0; c < D; ++c) {
      way[c][o] = static_cast<float>(d[c]);
      normal[c][o] = static_cast<float>(faces.normal[k][c]);
    }
    front[o] = static_cast<float>(-d.dot(faces.normal[k]));
    reach[o] = static_cast<float>(1.001 * std::sqrt(patch_reach2<D>(faces.area[k])));
  }
}

template <int D, class Holds>
bool FacesFrom::any_between(const Vector<D>& at, double support, float side, Holds&& holds) const {
  std::array<float, D> place;
  for (int c = 0; c < D; ++c) place[c] = static_cast<float>(at[c]);
  const float slack = static_cast<float>(rounding * support), slack2 = static_cast<float>(rounding * support * support);
  for (std::size_t first = 0; first < front.size(); first += lanes) {
    std::array<std::int32_t, lanes> may;
    std::int32_t any_may = 0;
    for (std::size_t m = 0; m < lanes; ++m) {
      const std::size_t o = first + m;
      // As patch_separates(), times the height between the ends.
      float drop = 0, offset2 = 0;  // drop: of the place below x
      for (int c = 0; c < D; ++c) drop -= place[c] * normal[c][o];
      for (int c = 0; c < D; ++c) {
        const float offset = place[c] * front[o] - way[c][o] * drop;
        offset2 += offset * offset;
      }
      const float bound = reach[o] * side * drop + slack2;
      may[m] = (side * front[o] > -slack) & (side * (drop - front[o]) > -slack) & (offset2 < bound * bound);
      any_may += may[m];
    }
    if (any_may == 0) continue;
    for (std::size_t m = 0; m < lanes; ++m)
      if (may[m] && holds(face[first + m])) return true;
  }
  return false;
}

template <int D>
template <class Turned>
void CornerView<D>::find(const Vector<D>& x, Turned&& behind_plate) {
  back_facing_.clear();
  turned_.clear();  // the far faces of plates
  finder_.for_each_turned_around(structure_, x, [&](int k) { sort_turned(k, behind_plate(k)); });
  remove_beyond_plates(x, back_facing_);
}

template <int D>
void CornerView<D>::sort_turned(int k, bool behind_plate) {
  if (behind_plate)
    turned_.push_back(k);
  else if (covered_.empty() || !covered_[k])
    back_facing_.push_back(k);
}

/// What lies beyond a plate bounds nothing. Seen from there, x is behind the far face of the plate.
template <int D>
void CornerView<D>::remove_beyond_plates(const Vector<D>& x, std::vector<int>& faces) {
  if (turned_.empty() || faces.empty()) return;
  // The line passes through a far face from its front. None is before one of them where all lie deep enough below the planes of these: the
  // height of a place above one is that along the normal of the first but for the way, at most two supports, times how normals differ.
  const Vector<D>& normal = structure_.normal[turned_[0]];
  double highest = -1e300, lowest = 1e300, turn2 = 0;
  for (int k : faces) highest = std::max(highest, (structure_.position[k] - x).dot(normal));
  for (int k : turned_) {
    lowest = std::min(lowest, (structure_.position[k] - x).dot(normal));
    turn2 = std::max(turn2, (structure_.normal[k] - normal).squaredNorm());
  }
  if (highest - lowest + 2 * kernel_.support() * std::sqrt(turn2) < -rounding * kernel_.support()) return;
  far_.set<D>(structure_, x, turned_.data(), static_cast<int>(turned_.size()));
  const auto beyond_plate = [&](int k) {
    const Vector<D>& place = structure_.position[k];
    return far_.any_between<D>(place - x, kernel_.support(), -1, [&](int far) { return patch_separates(structure_, far, place, x); });
  };
  faces.erase(std::remove_if(faces.begin(), faces.end(), beyond_plate), faces.end());
}

/// For an x that sees faces of one normal, and what lies behind their plane.
template <int D>
void CornerView<D>::find_behind(const Vector<D>& normal, const Vector<D>& x) {
  back_facing_.clear();
  turned_.clear();
  finder_.any_turned_around(structure_, x, normal, plate_cosine, [&](int k) {
    sort_turned(k, !passes_corner<D>(normal, structure_.normal[k]));
    return false;
  });
  if (back_facing_.empty()) return;  // as beside a plate, away from its edges
  // As remove_beyond_plates(), of the far faces of a plate all together.
  const auto beyond = finder_.turned_beyond(x, normal, plate_cosine);
  double highest = -1e300;
  for (int k : back_facing_) highest = std::max(highest, (x - structure_.position[k]).dot(normal));
  const bool is_deeper = highest - beyond.least_depth + 2 * kernel_.support() * beyond.spread < -rounding * kernel_.support();
  if (turned_.empty() && is_deeper) return;
  find(x, [&](int k) { return !passes_corner<D>(normal, structure_.normal[k]); });
}

template <int D>
void CornerView<D>::look(const Vector<D>& x, const int* seen, int seen_count, double spread) {
  // Most particles see one sheet, flat or bent: what makes a plate with all of it lies behind it. `turn`: by which the product of a normal
  // with that of one face of the sheet may differ from that with another's.
  const Vector<D>& normal = structure_.normal[seen[0]];
  const auto product = [&](int k) { return structure_.normal[k].dot(normal); };
  const auto any_back_facing = [&](double turn) {
    const auto may_be = [&](int k) { return product(k) > plate_cosine - turn; };
    return finder_.any_turned_around(structure_, x, normal, plate_cosine - turn, may_be);
  };
  back_facing_.clear();
  if (spread < 2 && !any_back_facing(spread)) return;  // as beside a plate, away from its edges
  double turn2 = 0;
  for (int m = 1; m < seen_count; ++m) turn2 = std::max(turn2, (structure_.normal[seen[m]] - normal).squaredNorm());
  const double turn = std::sqrt(turn2);
  if (!any_back_facing(turn)) return;
  bool near_is_set = false;
  find(x, [&](int k) {
    const double cosine = product(k);
    if (cosine <= plate_cosine - turn) return true;
    if (cosine > plate_cosine + turn) return false;
    if (!near_is_set) near_.set<D>(structure_, x, seen, seen_count);
    near_is_set = true;
    const auto makes_plate = [&](int face) { return !passes_corner<D>(structure_.normal[face], structure_.normal[k]); };
    const Vector<D>& place = structure_.position[k];
    return std::all_of(seen, seen + seen_count, makes_plate) || near_.any_between<D>(place - x, kernel_.support(), 1, [&](int face) {
      return makes_plate(face) && patch_separates(structure_, face, x, place);
    });
  });
}

template <int D>
double CornerView<D>::borne_share(int k) {
  const Vector<D>&x = structure_.position[k], &normal = structure_.normal[k];
  seen_.clear();
  const double spread = finder_.any_facing(x) ? finder_.see(structure_, x, seen_) : 0;
  const auto of_sheet = [&](int face, double more) { return structure_.normal[face].dot(normal) > sheet_cosine + more; };
  const bool one_sheet =
      seen_.empty() || of_sheet(seen_[0], spread) || std::all_of(seen_.begin(), seen_.end(), [&](int face) { return of_sheet(face, 0); });
  if (one_sheet) {  // what is a plate to the face is one to what it sees
    find_behind(normal, x);
  } else {  // beyond a plate is also what lies behind one that the face sees
    near_.set<D>(structure_, x, seen_.data(), static_cast<int>(seen_.size()));
    find(x, [&](int other) {
      const Vector<D>& place = structure_.position[other];
      const auto is_plate_of = [&](int face) { return !passes_corner<D>(structure_.normal[face], structure_.normal[other]); };
      return (is_plate_of(k) && (place - x).dot(normal) < 0) || near_.any_between<D>(place - x, kernel_.support(), 1, [&](int face) {
        return is_plate_of(face) && patch_separates(structure_, face, x, place);
      });
    });
    remove_beyond_plates(x, seen_);
  }
  const double past = behind_cones(structure_, kernel_, x, back_facing_, -1), hidden = behind_cones(structure_, kernel_, x, seen_, 1);
  const double half_space = (D == 2 ? 1 : 2) * std::numbers::pi * kernel_.surface_weight_beyond(0);
  const double open = 1 + (std::max(0.0, past) - std::max(0.0, hidden)) / half_space;  // at the end of the kernel w~ has both signs
  return 1 / std::max(open, least_open);
}

template <int D>
void find_covered_faces(const Faces<D>& structure, const Faces<D>& walls, const FaceFinder<D>& wall_finder, double before,
                        std::vector<std::uint8_t>& covered) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(structure.size());
  covered.resize(n);
  parallel_for(n, [&](std::ptrdiff_t k) {
    // In the wall is what has the nearest patch before it.
    const Vector<D> x = structure.position[k] + before * structure.normal[k];
    double nearest2 = 1e300, height = 1;
    wall_finder.for_each_around(x, [&](int wall) {
      const Vector<D> d = x - walls.position[wall];
      if (d.squaredNorm() >= nearest2) return;
      nearest2 = d.squaredNorm();
      height = d.dot(walls.normal[wall]);
    });
    covered[k] = height < 0;
  });
}

#define TERN_INSTANTIATE(D)     \
  template class CornerView<D>; \
  template void find_covered_faces<D>(const Faces<D>&, const Faces<D>&, const FaceFinder<D>&, double, std::vector<std::uint8_t>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern
