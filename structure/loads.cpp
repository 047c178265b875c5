// Forces of the loads, f = t A_k (traction, per undeformed area), f = -p a_k n_k (pressure, on the present surface),
// f = b V_i (force per undeformed volume, of a cell as much as is in the region), each a function of t and of the place X in the
// undeformed body.

#include "structure/loads.hpp"

#include <algorithm>
#include <cmath>

#include "scene/geometry.hpp"

namespace tern::structure {
namespace {

/// Part of a cell about x, with these columns as its edges, that lies in the region. A part of the cell counts as far as the face of the
/// region that is nearest to its middle cuts it: a face along the cell is exact.
template <int D, class Edges>
double share_in(const Shape& region, const Vector<D>& x, const Edges& edges) {
  constexpr int parts = 4;  // of each edge
  const double width = edges.colwise().norm().maxCoeff();
  const double distance = signed_distance<D>(region, x), reach = 0.5 * edges.colwise().norm().sum();
  if (std::abs(distance) > reach) return distance < 0 ? 1 : 0;
  double sum = 0;
  int count = 1;
  for (int e = 0; e < edges.cols(); ++e) count *= parts;
  for (int n = 0; n < count; ++n) {
    Vector<D> place = x;
    for (int e = 0, rest = n; e < edges.cols(); ++e, rest /= parts) place += ((rest % parts + 0.5) / parts - 0.5) * edges.col(e);
    sum += std::clamp(0.5 - signed_distance<D>(region, place) * parts / width, 0.0, 1.0);
  }
  return sum / count;
}

/// Of the cell of a particle: of a shell that of its mid-surface.
template <int D>
double share_in(const Shape& region, const Reference<D>& reference, std::size_t p) {
  const auto row = reference.particle_row[p];
  const Body& body = reference.bodies[reference.particle_body[p]];
  const Vector<D> x = reference.position_of(row);
  const ShellBody<D>* shell = reference.shell_of(body);
  if (shell == nullptr) return share_in<D>(region, x, Matrix<D>(body.spacing * lattice_axes<D>(body.shape)));
  const std::size_t particle = row - shell->first_row;
  const double width = std::pow(shell->layer.particles.area[particle], 1.0 / (D - 1));
  return share_in<D>(region, x, (width * shell->layer.particles.frame[particle].template leftCols<D - 1>()).eval());
}

}  // namespace

template <int D>
Loads<D>::Loads(const StructureCase& structure, const Reference<D>& reference, const SurfaceAttachment<D>& attachment) {
  for (const LoadCase& input : structure.loads) {
    Load load{input, {}, {}, {}};
    const auto is_on = [&](std::uint32_t body) { return reference.bodies[body].name == input.body; };
    if (input.kind == LoadCase::Kind::body_force) {
      for (std::size_t p = 0; p < reference.particle_row.size(); ++p) {
        const auto row = reference.particle_row[p];
        const std::uint32_t body = reference.particle_body[p];
        const bool bears = reference.inverse_mass[row] > 0 || reference.bodies[body].shell >= 0;  // as weight (structure.cpp)
        if (!bears || !is_on(body)) continue;
        const double share = input.region ? share_in(*input.region, reference, p) : 1;
        if (share == 0) continue;
        load.row.push_back(row);
        load.volume.push_back(share * (reference.inverse_mass[row] > 0 ? reference.volume[row]
                                                                       : reference.mass[row] / reference.bodies[body].material.density));
      }
    } else {
      for (std::size_t k = 0; k < attachment.row.size(); ++k)
        if (attachment.clamp[k] < 0 && is_on(attachment.body[k]) &&
            (!input.region || contains<D>(*input.region, reference.position_of(attachment.row[k]) + attachment.offset[k])))
          load.point.push_back(k);
    }
    loads_.push_back(std::move(load));
  }
  if (any())
    for (auto& axis : force_) axis.assign(reference.rows, 0);
}

template <int D>
void Loads<D>::update(double t, const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const State<D>& state,
                      const Workspace<D>& work) {
  if (!any()) return;
  for (auto& axis : force_) std::fill(axis.begin(), axis.end(), 0);
  const auto at = [&](const VectorExpression& value, int a, const Vector<D>& x) { return value[a](t, x[0], x[1], D == 3 ? x[D - 1] : 0); };
  const bool follows =
      std::any_of(loads_.begin(), loads_.end(), [](const Load& load) { return load.input.kind == LoadCase::Kind::pressure; });
  const Surface<D> surface = follows ? present_feet(attachment, reference, state, work) : Surface<D>{};
  for (const Load& load : loads_) {
    for (std::size_t n = 0; n < load.row.size(); ++n)
      for (int a = 0; a < D; ++a) force_[a][load.row[n]] += load.volume[n] * at(load.input.value, a, reference.position_of(load.row[n]));
    for (const auto k : load.point) {
      const auto row = attachment.row[k];
      const Vector<D> x = reference.position_of(row) + attachment.offset[k];
      if (load.input.kind == LoadCase::Kind::pressure) {
        const double force = -at(load.input.value, 0, x) * surface.area[k];
        add_point_force<D>(attachment, reference, work, k, force * surface.normal[k], force_);
      } else {
        Vector<D> force;
        for (int a = 0; a < D; ++a) force[a] = attachment.area[k] * at(load.input.value, a, x);
        add_point_force<D>(attachment, reference, work, k, force, force_);
      }
    }
  }
}

template <int D>
void Loads<D>::add_to(RowVectors<D>& force) const {
  if (!any()) return;
  for (int a = 0; a < D; ++a)
    for (std::size_t row = 0; row < force[a].size(); ++row) force[a][row] += force_[a][row];
}

template class Loads<2>;
template class Loads<3>;

}  // namespace tern::structure
