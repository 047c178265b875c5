#include "fluid/boundary/mirror_images.hpp"

#include <array>
#include <cmath>

namespace tern::fluid {
namespace {

/// Cosine of the angle between two planes up to which they are taken to be at right angles: the images of an image then do not
/// depend on the order of the mirrors.
constexpr double right_angle = 0.05;
/// Of one particle; the first that are seen. Three at right angles have seven images, as many as the protocol takes.
constexpr int most_planes = 3;

}  // namespace

template <int D>
void mirror_in_walls(const Faces<D>& walls, const FaceRows& rows, int i, const Vector<D>& x, double close, std::vector<Vector<D>>& images) {
  images.clear();
  const auto mirrored = [&](const Vector<D>& place, int k) {
    return Vector<D>(place + 2 * (walls.position[k] - place).dot(walls.normal[k]) * walls.normal[k]);
  };
  std::array<int, most_planes> plane;  // a patch of each
  int planes = 0;
  for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i] && planes < most_planes; ++entry) {
    const int k = rows.face[entry];
    const Vector<D> image = mirrored(x, k);
    // The wall is a mirror where it is: its patch has to lie at the foot of the perpendicular.
    if (!patch_separates(walls, k, x, image)) continue;
    bool known = false;
    for (const auto& other : images) known = known || (other - image).squaredNorm() < close * close;
    if (known) continue;
    images.push_back(image);
    plane[planes++] = k;
  }
  const auto at_right_angles = [&](int a, int b) { return std::abs(walls.normal[plane[a]].dot(walls.normal[plane[b]])) < right_angle; };
  for (int a = 0; a < planes; ++a)
    for (int b = a + 1; b < planes; ++b) {
      if (!at_right_angles(a, b)) continue;
      const Vector<D> image = mirrored(images[a], plane[b]);
      images.push_back(image);
      for (int c = b + 1; D == 3 && c < planes; ++c)
        if (at_right_angles(a, c) && at_right_angles(b, c)) images.push_back(mirrored(image, plane[c]));
    }
}

template void mirror_in_walls<2>(const Faces<2>&, const FaceRows&, int, const Vector<2>&, double, std::vector<Vector<2>>&);
template void mirror_in_walls<3>(const Faces<3>&, const FaceRows&, int, const Vector<3>&, double, std::vector<Vector<3>>&);

}  // namespace tern::fluid
