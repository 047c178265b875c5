#include "scene/held_particles.hpp"

#include <algorithm>

#include "scene/mid_surface.hpp"

namespace tern {

template <int D>
std::vector<bool> held_particles(const StructureBody& body) {
  std::vector<bool> held;
  if (body.is_shell) {
    for (const SurfaceCell<D>& cell : cells_of(mid_surface<D>(body))) held.push_back(cell.edge != EdgeKind::free);
    return held;
  }
  for (const Vector<D>& x : fill_body<D>(body))
    held.push_back(std::any_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& region) { return contains<D>(region, x); }));
  return held;
}

template std::vector<bool> held_particles<2>(const StructureBody&);
template std::vector<bool> held_particles<3>(const StructureBody&);

}  // namespace tern
