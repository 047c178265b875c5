// Surface points and what the coupler must know of the material behind them: section_mass = rho_0 T / N_wet, T the
// thickness behind the point, N_wet = 2 where the opposite face is exposed too.

#include "structure/surface_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "scene/geometry.hpp"
#include "scene/scene_check.hpp"
#include "scene/shell_sampling.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

bool inside_any(const std::vector<Shape>& shapes, const auto& x) {
  constexpr int D = std::decay_t<decltype(x)>::RowsAtCompileTime;
  return std::any_of(shapes.begin(), shapes.end(), [&](const Shape& s) { return contains<D>(s, x); });
}

/// Whether fluid can come to x at t = 0, closer to it than to any wall. `region`: of the container.
template <int D>
bool is_within_reach(const Case& scene, const std::optional<Shape>& region, const Vector<D>& x, double slack) {
  if (!scene.fluid) return false;
  if (region && signed_distance<D>(*region, x) > -slack) return false;
  return std::none_of(scene.walls.begin(), scene.walls.end(),
                      [&](const WallCase& wall) { return !wall.container && signed_distance<D>(wall.shape, x) < slack; });
}

/// Row of the particle of the body nearest to x, of those that are clamped or of those that are not; -1 when there is none.
template <int D>
std::int32_t nearest_row(const Reference<D>& reference, const Body& body, const Vector<D>& x, bool clamped) {
  std::int32_t nearest = -1;
  double least = std::numeric_limits<double>::max();
  for (std::size_t p = body.first; p < body.first + body.count; ++p) {
    const auto row = reference.particle_row[p];
    if ((reference.inverse_mass[row] == 0) != clamped) continue;
    const double squared = (reference.position_of(row) - x).squaredNorm();
    if (squared < least) {
      least = squared;
      nearest = row;
    }
  }
  return nearest;
}

template <int D>
std::int32_t clamp_of(const Reference<D>& reference, std::int32_t row) {
  const auto holds = [&](const Clamp& clamp) { return std::find(clamp.row.begin(), clamp.row.end(), row) != clamp.row.end(); };
  return static_cast<std::int32_t>(std::find_if(reference.clamps.begin(), reference.clamps.end(), holds) - reference.clamps.begin());
}

/// Numbers the patches of feet as they come.
template <int D>
class Patches {
 public:
  /// `length`: edge of the cubes that join the feet of a body; 0: every foot is a patch.
  std::uint32_t of(const Body& body, double length, std::int32_t clamp, const Vector<D>& x, const Vector<D>& normal) {
    if (length == 0) return count_++;
    Key key{static_cast<long>(body.first), clamp};
    int direction = 0;
    normal.cwiseAbs().maxCoeff(&direction);
    key[2] = normal[direction] > 0 ? direction : D + direction;
    // A hair away from the edges of the cubes, on which a face of the body may lie.
    for (int a = 0; a < D; ++a) key[3 + a] = std::lround(std::floor((x[a] - body.shape.min[a]) / length + 1e-6));
    const auto [patch, is_new] = known_.try_emplace(key, count_);
    count_ += is_new;
    return patch->second;
  }

 private:
  using Key = std::array<long, 3 + D>;
  std::map<Key, std::uint32_t> known_;
  std::uint32_t count_ = 0;
};

/// Of the patches, the means of what their feet have.
template <int D>
std::vector<Vector<D>> means_of_patches(const SurfaceAttachment<D>& attachment, std::vector<Vector<D>> of_feet) {
  const std::size_t count = attachment.properties.body.size();
  if (count == of_feet.size()) return of_feet;
  std::vector<Vector<D>> means(count, Vector<D>::Zero());
  for (std::size_t k = 0; k < of_feet.size(); ++k) means[attachment.patch[k]] += attachment.share[k] * of_feet[k];
  return means;
}

/// The patches that these feet are of.
template <int D>
Surface<D> joined(const SurfaceAttachment<D>& attachment, Surface<D> feet) {
  const std::size_t count = attachment.properties.body.size();
  if (count == attachment.row.size()) return feet;
  Surface<D> surface;
  surface.position = means_of_patches(attachment, std::move(feet.position));
  surface.velocity = means_of_patches(attachment, std::move(feet.velocity));
  surface.normal.assign(count, Vector<D>::Zero());
  for (std::size_t k = 0; k < feet.area.size(); ++k) surface.normal[attachment.patch[k]] += feet.area[k] * feet.normal[k];
  for (Vector<D>& normal : surface.normal) {
    surface.area.push_back(normal.norm());
    normal /= surface.area.back();
  }
  return surface;
}

/// sum_j w_kj y_j over the rows that bear foot k.
template <int D>
Vector<D> weighted(const SurfaceAttachment<D>& attachment, std::size_t k, const RowVectors<D>& y) {
  Vector<D> sum = Vector<D>::Zero();
  for (auto n = attachment.weights.first[k]; n < attachment.weights.first[k + 1]; ++n)
    for (int a = 0; a < D; ++a) sum[a] += attachment.weights.weight[n] * y[a][attachment.weights.bearer[n]];
  return sum;
}

/// Where the clamps of the reference are [of each], and at the end those without a name, which do not move.
template <int D>
std::vector<Placement<D>> places_of_clamps(const Reference<D>& reference, double t) {
  std::vector<Placement<D>> place(reference.clamps.size() + 1);
  for (std::size_t c = 0; c < reference.clamps.size(); ++c)
    if (reference.clamps[c].motion) place[c] = placement<D>(*reference.clamps[c].motion, t);
  return place;
}

template <int D>
std::vector<Vector<D>> velocity_of_feet(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const State<D>& state,
                                        const Workspace<D>& work) {
  std::vector<Vector<D>> velocity(attachment.row.size());
  std::vector<Matrix<D>> turn;  // of the clamps
  for (std::size_t c = 0; c < reference.clamps.size(); ++c)
    turn.push_back(reference.clamps[c].motion ? turn_by<D>(state.clamp_angle[c], reference.clamps[c].motion->axis) : Matrix<D>::Identity());
  for (std::size_t k = 0; k < velocity.size(); ++k) {
    if (attachment.clamp[k] >= 0) {
      for (int a = 0; a < D; ++a) velocity[k][a] = state.velocity[a][attachment.row[k]];
      const auto c = static_cast<std::size_t>(attachment.clamp[k]);
      if (c < turn.size() && state.clamp_spin[c] != 0)
        velocity[k] += turning_velocity<D>(state.clamp_spin[c], reference.clamps[c].motion->axis, turn[c] * attachment.offset[k]);
      continue;
    }
    if (attachment.on_shell[k] < 0) {
      velocity[k] = weighted<D>(attachment, k, state.velocity);
      continue;
    }
    const ShellBody<D>& shell = reference.shells[attachment.on_shell[k]];
    for (int a = 0; a < D; ++a) {  // by the adjoint of a unit force
      velocity[k][a] = 0;
      spread_force<D>(shell.layer, work.shells[shell.index], attachment.shell[k], Vector<D>::Unit(a),
                      [&](std::size_t j, const Vector<D>& share) {
                        for (int b = 0; b < D; ++b)
                          velocity[k][a] += share[b] * state.velocity[b][shell.first_row + static_cast<std::int32_t>(j)];
                      });
    }
  }
  return velocity;
}

}  // namespace

template <int D>
SurfaceAttachment<D> attach_surface(const Reference<D>& reference, const Case& scene) {
  SurfaceAttachment<D> attachment;
  const std::optional<Shape> region = fluid_region(scene);
  std::vector<std::int32_t> free_solid;  // row, where a foot is on a free face of a solid, else -1
  Patches<D> patches;
  for (std::uint32_t b = 0; b < reference.bodies.size(); ++b) {
    const Body& body = reference.bodies[b];
    const double distance = point_distance<D>(body.spacing, body.shell >= 0, scene.fluid);
    const auto points = body.shell >= 0 ? sample_shell_surface<D>(scene.structure->bodies[b], scene.walls, distance)
                                        : sample_surface<D>(body.shape, distance);
    const double joined_length = body.shell < 0 ? joined_patch_length<D>(body.spacing, scene.fluid) : 0;
    for (std::size_t k = 0; k < points.position.size(); ++k) {
      const Vector<D>& x = points.position[k];
      const Vector<D>& normal = points.normal[k];
      const bool clamped = inside_any(body.clamps, x);
      if (clamped && !is_within_reach<D>(scene, region, x, 1e-3 * body.spacing)) continue;
      const auto row = nearest_row<D>(reference, body, x, clamped);
      if (row < 0) continue;  // the whole body is clamped, or the clamp holds no particle here
      const double depth = thickness<D>(body.shape, x, normal);
      // A hair inside the opposite face: on it, whether a clamp contains the point would be a matter of round-off.
      const Vector<D> opposite = x - (depth - 1e-3 * body.spacing) * normal;
      const int wet_faces = inside_any(body.clamps, opposite) ? 1 : 2;
      attachment.body.push_back(b);
      attachment.clamp.push_back(clamped ? clamp_of(reference, row) : -1);
      attachment.patch.push_back(patches.of(body, joined_length, attachment.clamp.back(), x, normal));
      attachment.row.push_back(row);
      attachment.offset.push_back(x - reference.position_of(row));
      attachment.normal.push_back(normal);
      attachment.area.push_back(points.area[k]);
      const ShellBody<D>* shell = clamped ? nullptr : reference.shell_of(body);
      attachment.on_shell.push_back(shell == nullptr ? -1 : static_cast<std::int32_t>(shell->index));
      attachment.shell.push_back(shell == nullptr ? ShellPoint<D>{}
                                                  : shell_point<D>(shell->layer, row - shell->first_row, x - reference.position_of(row)));
      if (clamped) attachment.held.push_back(attachment.row.size() - 1);
      free_solid.push_back(!clamped && shell == nullptr ? row : -1);
      if (attachment.patch.back() < attachment.properties.body.size()) continue;  // the properties of a patch are those of its first foot
      attachment.properties.body.push_back(b);
      attachment.properties.section_mass.push_back(clamped ? held_mass : body.material.density * depth / wet_faces);
      attachment.properties.impedance.push_back(body.material.density * body.material.pressure_wave_speed());
      attachment.properties.least_mass.push_back(clamped ? held_mass : body.material.density * body.spacing);
      if (shell != nullptr && std::abs(normal.dot(shell->layer.particles.frame[row - shell->first_row].col(D - 1))) > 0.5) {  // on a face
        attachment.properties.least_mass.back() = attachment.properties.section_mass.back();  // nothing travels through the thickness
      }
    }
  }
  std::vector<Vector<D>> faces;
  for (std::size_t k = 0; k < attachment.row.size(); ++k) faces.push_back(attachment.area[k] * attachment.normal[k]);
  attachment.weights = surface_weights<D>(reference, free_solid, attachment.offset, faces);
  std::vector<double> area(attachment.properties.body.size(), 0);
  for (std::size_t k = 0; k < attachment.row.size(); ++k) area[attachment.patch[k]] += attachment.area[k];
  for (std::size_t k = 0; k < attachment.row.size(); ++k) attachment.share.push_back(attachment.area[k] / area[attachment.patch[k]]);
  return attachment;
}

template <int D>
std::vector<Vector<D>> surface_velocity(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const State<D>& state,
                                        const Workspace<D>& work) {
  return means_of_patches(attachment, velocity_of_feet(attachment, reference, state, work));
}

template <int D>
std::vector<Vector<D>> held_feet_moved(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, double begin, double end) {
  const std::vector<Placement<D>> before = places_of_clamps(reference, begin), after = places_of_clamps(reference, end);
  std::vector<Vector<D>> moved;
  moved.reserve(attachment.held.size());
  for (const std::size_t k : attachment.held) {
    const Vector<D> x = reference.position_of(attachment.row[k]) + attachment.offset[k];
    moved.push_back(after[attachment.clamp[k]](x) - before[attachment.clamp[k]](x));
  }
  return moved;
}

template <int D>
Surface<D> present_feet(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const State<D>& state,
                        const Workspace<D>& work) {
  const std::size_t count = attachment.row.size();
  Surface<D> surface;
  surface.velocity = velocity_of_feet(attachment, reference, state, work);
  surface.position.resize(count);
  surface.normal.resize(count);
  surface.area.resize(count);
  const std::vector<Placement<D>> place = places_of_clamps(reference, seconds(state.time));
  for (std::size_t k = 0; k < count; ++k) {
    const auto row = attachment.row[k];
    if (attachment.clamp[k] >= 0) {
      const Placement<D>& rigid = place[attachment.clamp[k]];
      surface.position[k] = rigid(reference.position_of(row) + attachment.offset[k]);
      surface.normal[k] = rigid.turn * attachment.normal[k];
      surface.area[k] = attachment.area[k];
      continue;
    }
    ShellPlace<D> place_k;
    if (attachment.on_shell[k] >= 0) {
      const ShellBody<D>& shell = reference.shells[attachment.on_shell[k]];
      place_k = place_of<D>(shell.layer, work.shells[shell.index], attachment.shell[k]);
    } else {
      place_k.gradient = deformation_gradient_of<D>(work, row);
      place_k.position = reference.position_of(row) + attachment.offset[k] + weighted<D>(attachment, k, state.displacement);
    }
    const Matrix<D>& f = place_k.gradient;
    const Vector<D> normal = f.determinant() * f.inverse().transpose() * attachment.normal[k];
    const double stretch = normal.norm();
    surface.position[k] = place_k.position;
    surface.normal[k] = normal / stretch;
    surface.area[k] = attachment.area[k] * stretch;
  }
  return surface;
}

template <int D>
Surface<D> present_surface(const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const State<D>& state,
                           const Workspace<D>& work) {
  return joined(attachment, present_feet(attachment, reference, state, work));
}

template SurfaceAttachment<2> attach_surface<2>(const Reference<2>&, const Case&);
template SurfaceAttachment<3> attach_surface<3>(const Reference<3>&, const Case&);
template std::vector<Vector<2>> surface_velocity<2>(const SurfaceAttachment<2>&, const Reference<2>&, const State<2>&, const Workspace<2>&);
template std::vector<Vector<3>> surface_velocity<3>(const SurfaceAttachment<3>&, const Reference<3>&, const State<3>&, const Workspace<3>&);
template std::vector<Vector<2>> held_feet_moved<2>(const SurfaceAttachment<2>&, const Reference<2>&, double, double);
template std::vector<Vector<3>> held_feet_moved<3>(const SurfaceAttachment<3>&, const Reference<3>&, double, double);
template Surface<2> present_feet<2>(const SurfaceAttachment<2>&, const Reference<2>&, const State<2>&, const Workspace<2>&);
template Surface<3> present_feet<3>(const SurfaceAttachment<3>&, const Reference<3>&, const State<3>&, const Workspace<3>&);
template Surface<2> present_surface<2>(const SurfaceAttachment<2>&, const Reference<2>&, const State<2>&, const Workspace<2>&);
template Surface<3> present_surface<3>(const SurfaceAttachment<3>&, const Reference<3>&, const State<3>&, const Workspace<3>&);

}  // namespace tern::structure
