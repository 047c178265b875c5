#include "fluid/mirror_images.hpp"

#include <array>
#include <cmath>

namespace tern::fluid {
namespace {

/// Cosine of the angle between two planes up to which they are taken to be at right angles: the images of an image then do not
/// depend on the order of the mirrors.
constexpr double right_angle = 0.05;

}  // namespace

template <int D>
void mirror_in_walls(const Faces<D>& walls, const FaceRows& rows, int i, const Vector<D>& x, double close,
                     std::vector<Vector<D>>& images) {
  images.clear();
  std::array<Vector<D>, D> normals;  // of the planes so far, as long as each is at right angles to all before
  int planes = 0;
  bool right_angles = true;
  for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
    const int k = rows.face[entry];
    const Vector<D>& n = walls.normal[k];
    const auto mirrored = [&](const Vector<D>& place) { return Vector<D>(place + 2 * (walls.position[k] - place).dot(n) * n); };
    const Vector<D> image = mirrored(x);
    // The wall is a mirror where it is: its patch has to lie at the foot of the perpendicular.
    if (!patch_separates(walls, k, x, image)) continue;
    bool known = false;
    for (const auto& other : images) known = known || (other - image).squaredNorm() < close * close;
    if (known) continue;
    for (int p = 0; p < planes; ++p) right_angles = right_angles && std::abs(n.dot(normals[p])) < right_angle;
    const std::size_t before = images.size();
    images.push_back(image);
    if (!right_angles || planes == D) continue;
    for (std::size_t m = 0; m < before; ++m) images.push_back(mirrored(images[m]));
    normals[planes++] = n;
  }
}

template void mirror_in_walls<2>(const Faces<2>&, const FaceRows&, int, const Vector<2>&, double, std::vector<Vector<2>>&);
template void mirror_in_walls<3>(const Faces<3>&, const FaceRows&, int, const Vector<3>&, double, std::vector<Vector<3>>&);

}  // namespace tern::fluid
