#include "scene/scene_at_start.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "scene/held_particles.hpp"
#include "scene/mid_surface.hpp"

namespace tern {
namespace {

using nlohmann::json;

constexpr int path_parts = 512;          ///< of the run's time
constexpr double most_velocities = 200;  ///< about, of one body

template <int D>
json array_of(const Vector<D>& x) {
  json result = json::array();
  for (int d = 0; d < D; ++d) result.push_back(x[d]);
  return result;
}

template <int D>
json row(const Vector<D>& first, long count) {
  json result = array_of<D>(first);
  result.push_back(count);
  return result;
}

/// Rows are along x: points of a turned lattice are rows of one.
template <int D>
json rows(const LatticePoints<D>& points) {
  json result = json::array();
  for (const auto& run : points.runs()) {
    const long length = points.is_turned() ? 1 : run.count;
    for (long i = 0; i < run.count; i += length) result.push_back(row<D>(points.at(run, i), length));
  }
  return result;
}

/// Rows of the points that are marked.
template <int D>
json marked_rows(const LatticePoints<D>& points, const std::vector<bool>& is_marked) {
  json result = json::array();
  std::size_t first = 0;  // point of the run
  for (const auto& run : points.runs()) {
    const auto is_on = [&](long i) { return i < run.count && is_marked[first + static_cast<std::size_t>(i)]; };
    for (long i = 0; i < run.count; ++i) {
      if (!is_on(i)) continue;
      const long begin = i;
      while (!points.is_turned() && is_on(i + 1)) ++i;
      result.push_back(row<D>(points.at(run, begin), i + 1 - begin));
    }
    first += static_cast<std::size_t>(run.count);
  }
  return result;
}

template <int D>
Vector<D> value(const VectorExpression& expression, const Vector<D>& x) {
  Vector<D> result;
  for (int c = 0; c < D; ++c) result[c] = expression[c](0, x[0], x[1], D == 3 ? x[D - 1] : 0);
  return result;
}

/// Adds the largest speed of all points and, where they move, place and velocity at every n-th one in each direction.
template <int D>
void add_velocities(const LatticePoints<D>& points, const VectorExpression& expression, json& said) {
  const long n = std::max(1L, std::lround(std::pow(static_cast<double>(points.size()) / most_velocities, 1.0 / D)));
  json shown = json::array();
  double fastest = 0;
  for (const auto& run : points.runs()) {
    bool taken = true;
    for (int d = 1; d < D; ++d) taken &= run.index[d] % n == n / 2;
    for (long i = 0; i < run.count; ++i) {
      const Vector<D> x = points.at(run, i), u = value<D>(expression, x);
      fastest = std::max(fastest, u.norm());
      if (taken && (run.index[0] + i) % n == n / 2) shown.push_back(json::array({array_of<D>(x), array_of<D>(u)}));
    }
  }
  said["fastest"] = fastest;
  said["velocity"] = fastest > 0 ? shown : json::array();
}

template <int D>
json path(const RigidMotion& motion, double end_time) {
  json result = json::array();
  for (int k = 0; k <= path_parts; ++k) {
    const double t = end_time * k / path_parts;
    const Placement<D> place = placement<D>(motion, t);
    json points = json::array({array_of<D>(place(Vector<D>::Zero()))});
    for (int d = 0; d < D; ++d) points.push_back(array_of<D>(place(Vector<D>::Unit(d))));
    result.push_back({{"time", t}, {"angle", place.angle}, {"place", points}});
  }
  return result;
}

template <int D>
json with_path(const std::string& name, const std::optional<RigidMotion>& motion, double end_time) {
  json result = {{"name", name}};
  if (motion) result["path"] = path<D>(*motion, end_time);
  return result;
}

template <int D>
struct PlacedBody {
  json said;
  LatticePoints<D> points;
  const StructureBody* structure;
  const VectorExpression* velocity;
};

template <int D>
std::string text(const Case& scene, std::size_t most_points) {
  std::vector<PlacedBody<D>> bodies;
  std::size_t count = 0;
  const auto add = [&](const char* kind, const std::string& name, double spacing, LatticePoints<D> points, const StructureBody* structure,
                       const VectorExpression& velocity) {
    count += points.size();
    json said = {{"kind", kind}, {"name", name}, {"spacing", spacing}, {"count", points.size()}};
    bodies.push_back({std::move(said), std::move(points), structure, &velocity});
  };
  if (scene.fluid)
    for (const FluidBody& body : scene.fluid->bodies)
      add("fluid", "", scene.fluid->spacing, fill_with_fluid<D>(body.shape, scene.fluid->spacing), nullptr, body.velocity);
  if (scene.structure)
    for (const StructureBody& body : scene.structure->bodies)
      add("structure", body.name, body.spacing, fill_body<D>(body), &body, body.velocity);

  json result = {{"count", count}, {"walls", json::array()}, {"clamps", json::array()}, {"bodies", json::array()}};
  for (auto& [said, points, structure, velocity] : bodies) {
    if (structure) {
      const std::vector<bool> held = held_particles<D>(*structure);
      said["clamped"] = std::count(held.begin(), held.end(), true);
      if (count <= most_points) said["clamped_rows"] = marked_rows<D>(points, held);
    }
    if (count <= most_points) {
      said["step"] = points.step()[0];
      said["rows"] = rows<D>(points);
    }
    add_velocities<D>(points, *velocity, said);
    result["bodies"].push_back(std::move(said));
  }
  for (const WallCase& wall : scene.walls) result["walls"].push_back(with_path<D>(wall.name, wall.motion, scene.end_time));
  if (scene.structure)
    for (const ClampCase& clamp : scene.structure->clamps)
      result["clamps"].push_back(with_path<D>(clamp.name, clamp.motion, scene.end_time));
  Vector<D> low, high;
  json periodic = json::array();
  for (int d = 0; d < D; ++d) {
    low[d] = scene.domain_min[d], high[d] = scene.domain_max[d];
    periodic.push_back(scene.periodic[d]);
  }
  result["domain"] = json::array({array_of<D>(low), array_of<D>(high)});
  result["periodic"] = periodic;
  result["gravity"] = array_of<D>(value<D>(scene.gravity, 0.5 * (low + high)));
  return result.dump() + "\n";
}

}  // namespace

std::string scene_at_start(const Case& scene, std::size_t most_points) {
  return scene.dimension == 2 ? text<2>(scene, most_points) : text<3>(scene, most_points);
}

}  // namespace tern
