// Inelastic contact with walls: a particle closer than a fraction of dx to a face loses the normal velocity with which it
// approaches that face. Spray and thin sheets feel little or no pressure, so nothing else would stop them.

#include "fluid/boundary/wall_contact.hpp"

#include "base/parallel.hpp"
#include "sph/contact.hpp"

namespace tern::fluid {

template <int D>
void settle_wall_contacts(const Constants<D>& constants, const Boundary<D>& boundary, const std::vector<Vector<D>>& position,
                          std::vector<Vector<D>>& velocity) {
  const Faces<D>& faces = boundary.seen_walls();
  const double distance = constants.numerics.contact_distance * constants.spacing;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(position.size());
  parallel_for(n, [&](std::ptrdiff_t i) {
    if (boundary.wall_rows.height[i] > distance) return;
    for (int entry = boundary.wall_rows.begin[i]; entry < boundary.wall_rows.begin[i] + boundary.wall_rows.count[i]; ++entry) {
      const int k = boundary.wall_rows.face[entry];
      if (!touches<D>(faces.position[k], faces.normal[k], faces.area[k], position[i], distance)) continue;
      const double approach = (faces.velocity[k] - velocity[i]).dot(faces.normal[k]);
      if (approach > 0) velocity[i] += approach * faces.normal[k];
    }
  });
}

template void settle_wall_contacts<2>(const Constants<2>&, const Boundary<2>&, const std::vector<Vector<2>>&, std::vector<Vector<2>>&);
template void settle_wall_contacts<3>(const Constants<3>&, const Boundary<3>&, const std::vector<Vector<3>>&, std::vector<Vector<3>>&);

}  // namespace tern::fluid
