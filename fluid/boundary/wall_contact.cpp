// Inelastic contact with walls: a particle that would come closer than a fraction of dx to a face within the next window loses so much of
// the normal velocity with which it approaches that face. Spray and thin sheets feel little or no pressure: nothing else would stop them.

#include "fluid/boundary/wall_contact.hpp"

#include "base/parallel.hpp"
#include "sph/contact.hpp"

namespace tern::fluid {

template <int D>
void settle_wall_contacts(const Constants<D>& constants, double duration, const Boundary<D>& boundary,
                          const std::vector<Vector<D>>& position, std::vector<Vector<D>>& velocity, std::vector<Vector<D>>& stopped) {
  const Faces<D>& faces = boundary.seen_walls();
  const double distance = constants.numerics.contact_distance * constants.spacing;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(boundary.wall_rows.begin.size());
  if (distance == 0) return;
  const bool moving = boundary.walls.moving();
  parallel_for(n, [&](std::ptrdiff_t i) {
    stopped[i].setZero();
    // Too slow for any face at rest, in whatever direction it flies.
    if (!moving && velocity[i].norm() < permitted_approach(boundary.wall_rows.height[i], distance, duration)) return;
    for (int entry = boundary.wall_rows.begin[i]; entry < boundary.wall_rows.begin[i] + boundary.wall_rows.count[i]; ++entry) {
      const int k = boundary.wall_rows.face[entry];
      const Vector<D>& normal = faces.normal[k];
      const double height = (position[i] - faces.position[k]).dot(normal);
      const double excess = (faces.velocity_of(k) - velocity[i]).dot(normal) - permitted_approach(height, distance, duration);
      if (excess > 0 && stands_over<D>(faces.position[k], normal, faces.area[k], position[i])) {
        velocity[i] += excess * normal;
        stopped[i] += (excess / duration) * normal;
      }
    }
  });
}

template void settle_wall_contacts<2>(const Constants<2>&, double, const Boundary<2>&, const std::vector<Vector<2>>&,
                                      std::vector<Vector<2>>&, std::vector<Vector<2>>&);
template void settle_wall_contacts<3>(const Constants<3>&, double, const Boundary<3>&, const std::vector<Vector<3>>&,
                                      std::vector<Vector<3>>&, std::vector<Vector<3>>&);

}  // namespace tern::fluid
