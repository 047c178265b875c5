#include "sph/convex_corner.hpp"

#include <algorithm>
#include <numbers>

#include "base/parallel.hpp"

namespace tern {

/// Within the support. Faces in one plane with x make no corner.
template <int D>
bool CornerView<D>::is_turned(const Vector<D>& x, int k) const {
  const Vector<D> d = structure_.position[k] - x;
  return d.dot(structure_.normal[k]) > 1e-6 * kernel_.support() && d.squaredNorm() < kernel_.support() * kernel_.support();
}

template <int D>
template <class Turned>
void CornerView<D>::find(const Vector<D>& x, Turned&& behind_plate) {
  back_facing_.clear();
  turned_.clear();  // the far faces of plates
  finder_.for_each_turned_around(x, [&](int k) {
    if (!is_turned(x, k)) return;
    if (behind_plate(k))
      turned_.push_back(k);
    else if (covered_.empty() || !covered_[k])
      back_facing_.push_back(k);
  });
  if (turned_.empty()) return;
  // What lies beyond a plate bounds nothing. Seen from there, the particle is behind the far face of the plate.
  const auto beyond_plate = [&](int k) {
    return std::any_of(turned_.begin(), turned_.end(),
                       [&](int far) { return patch_separates(structure_, far, structure_.position[k], x); });
  };
  back_facing_.erase(std::remove_if(back_facing_.begin(), back_facing_.end(), beyond_plate), back_facing_.end());
}

/// For an x that sees faces of one normal, and what lies behind their plane.
template <int D>
void CornerView<D>::find_behind(const Vector<D>& normal, const Vector<D>& x) {
  back_facing_.clear();
  const auto is_back_facing = [&](int k) { return is_turned(x, k) && passes_corner<D>(normal, structure_.normal[k]); };
  if (!finder_.any_turned_around(x, normal, plate_cosine, is_back_facing)) return;  // as beside a plate, away from its edges
  find(x, [&](int k) { return !passes_corner<D>(normal, structure_.normal[k]); });
}

template <int D>
void CornerView<D>::look(const Vector<D>& x, const int* seen, int seen_count) {
  // Most particles see one flat face: whatever is hidden from them lies behind it.
  const Vector<D>& normal = structure_.normal[seen[0]];
  const bool flat =
      std::all_of(seen, seen + seen_count, [&](int face) { return (structure_.normal[face] - normal).squaredNorm() < 1e-12; });
  if (flat) return find_behind(normal, x);
  // The lines to two far faces that lie side by side enter the body through the same face, or through the next one.
  const int* entered = seen;
  find(x, [&](int k) {
    const auto passes = [&](int face) {
      return !passes_corner<D>(structure_.normal[face], structure_.normal[k]) &&
             patch_separates(structure_, face, x, structure_.position[k]);
    };
    const int* through = std::find_if(entered, seen + seen_count, passes);
    if (through == seen + seen_count) {
      through = std::find_if(seen, entered, passes);
      if (through == entered) return false;
    }
    entered = through;
    return true;
  });
}

template <int D>
double CornerView<D>::borne_share(int k) {
  const Vector<D>& x = structure_.position[k];
  find_behind(structure_.normal[k], x);
  double behind = 0;
  for (int other : back_facing_) {
    const Vector<D> d = structure_.position[other] - x;
    const double r = d.norm(), cosine = d.dot(structure_.normal[other]) / r;
    behind += subtended_angle<D>(d, Vector<D>(-structure_.normal[other]), structure_.area[other]) * kernel_.surface_weight_beyond(r) -
              structure_.area[other] * cosine * kernel_.midpoint_rest(r);
  }
  const double half_space = (D == 2 ? 1 : 2) * std::numbers::pi * kernel_.surface_weight_beyond(0);
  return 1 / (1 + std::max(0.0, behind) / half_space);  // at the end of the kernel w~ has both signs
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
