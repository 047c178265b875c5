#include "fluid/boundary/wall_clipping.hpp"

#include <algorithm>
#include <cmath>

namespace tern::fluid {
namespace {

/// Sine of the angle between wall and face below which they are parallel rather than one cutting the other.
constexpr double least_angle = 0.3;

template <int D>
double half_length(const Faces<D>& faces, int k) {
  return 0.5 * (D == 2 ? faces.area[k] : std::sqrt(faces.area[k]));
}

}  // namespace

template <int D>
void ClippedWalls<D>::clip(const Faces<D>& walls, const FaceFinder<D>& finder, const Faces<D>& structure) {
  if (!any_) {
    if (structure.size() == 0) return;
    faces_ = walls;
    any_ = true;
    largest_ = 0;
    for (int wall = 0; wall < static_cast<int>(walls.size()); ++wall) largest_ = std::max(largest_, half_length(walls, wall));
  }
  for (int wall : clipped_) {
    faces_.position[wall] = walls.position[wall];
    faces_.area[wall] = walls.area[wall];
  }
  clipped_.clear();
  for (int k = 0; k < static_cast<int>(structure.size()); ++k) {
    const double reach = std::sqrt(double(D)) * (largest_ + half_length(structure, k)) + largest_;  // the finder may lag by half a patch
    finder.for_each_near(structure.position[k], reach, [&](int wall) {
      if (faces_.area[wall] == walls.area[wall]) cut(wall, structure, k);  // what is cut already is no longer a square
    });
  }
}

template <int D>
void ClippedWalls<D>::cut(int wall, const Faces<D>& structure, int k) {
  const Vector<D>& n = structure.normal[k];
  const Vector<D> from_face = faces_.position[wall] - structure.position[k];
  const double half = half_length(faces_, wall), reach = half + half_length(structure, k);
  if (from_face.squaredNorm() > D * reach * reach) return;
  // Along the wall, out of the body.
  const Vector<D> out = n - n.dot(faces_.normal[wall]) * faces_.normal[wall];
  const double sine = out.norm();
  if (sine < least_angle) return;
  // The face cuts the patch, which reaches from -half to half, at this place.
  const double place = -from_face.dot(n) / sine;
  if (std::abs(place) >= half) return;
  const Vector<D> along = out / sine;
  if ((from_face + place * along).squaredNorm() >= patch_reach2<D>(structure.area[k])) return;
  faces_.position[wall] += 0.5 * (place + half) * along;
  faces_.area[wall] *= (half - place) / (2 * half);
  clipped_.push_back(wall);
}

template class ClippedWalls<2>;
template class ClippedWalls<3>;

}  // namespace tern::fluid
