// Inelastic contact with walls: a particle closer than a fraction of dx to a face loses the normal velocity with which it
// approaches that face. Spray and thin sheets feel little or no pressure, so nothing else would stop them.

#include "base/parallel.hpp"
#include "fluid/fluid.hpp"
#include "sph/contact.hpp"

namespace tern::fluid {

template <int D>
void Fluid<D>::settle_wall_contacts() {
  const Faces<D>& faces = seen_walls_.faces();
  const double distance = constants_.numerics.contact_distance * constants_.spacing;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (wall_rows_.height[i] > distance) continue;
    for (int entry = wall_rows_.begin[i]; entry < wall_rows_.begin[i] + wall_rows_.count[i]; ++entry) {
      const int k = wall_rows_.face[entry];
      if (!touches<D>(faces.position[k], faces.normal[k], faces.area[k], predicted_position_[i], distance)) continue;
      const double approach = (faces.velocity[k] - predicted_velocity_[i]).dot(faces.normal[k]);
      if (approach > 0) predicted_velocity_[i] += approach * faces.normal[k];
    }
  }
}

template void Fluid<2>::settle_wall_contacts();
template void Fluid<3>::settle_wall_contacts();

}  // namespace tern::fluid
