#include "sph/convex_corner.hpp"

#include <algorithm>
#include <numbers>

#include "base/parallel.hpp"

namespace tern {

template <int D>
template <class Turned>
void CornerView<D>::find(const Vector<D>& x, Turned&& behind_plate) {
  back_facing_.clear();
  turned_.clear();  // the far faces of plates
  const double support = kernel_.support();
  finder_.for_each_around(x, [&](int k) {
    const Vector<D> d = structure_.position[k] - x;
    if (d.dot(structure_.normal[k]) <= 1e-6 * support || d.squaredNorm() >= support * support) return;  // in one plane: no corner
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

template <int D>
void CornerView<D>::look(const Vector<D>& x, const int* seen, int seen_count) {
  // Most particles see one flat face: whatever is hidden from them lies behind it.
  const Vector<D>& normal = structure_.normal[seen[0]];
  const bool flat =
      std::all_of(seen, seen + seen_count, [&](int face) { return (structure_.normal[face] - normal).squaredNorm() < 1e-12; });
  find(x, [&](int k) {
    if (flat) return !passes_corner<D>(normal, structure_.normal[k]);
    return std::any_of(seen, seen + seen_count, [&](int face) {
      return !passes_corner<D>(structure_.normal[face], structure_.normal[k]) &&
             patch_separates(structure_, face, x, structure_.position[k]);
    });
  });
}

template <int D>
double CornerView<D>::borne_share(int k) {
  const Vector<D>& x = structure_.position[k];
  find(x, [&](int other) { return !passes_corner<D>(structure_.normal[k], structure_.normal[other]); });
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
