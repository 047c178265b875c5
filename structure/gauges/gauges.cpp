#include "structure/gauges/gauges.hpp"

namespace tern::structure {
namespace {

template <int D>
using Append = std::function<void(const Structure<D>&, GaugeValues&)>;

/// How the wall or clamp of that name moves; nothing if there is none.
std::optional<RigidMotion> motion_of(const std::string& name, const Case& scene) {
  for (const WallCase& wall : scene.walls)
    if (wall.name == name && wall.motion) return wall.motion;
  for (const ClampCase& clamp : scene.structure->clamps)
    if (clamp.name == name && clamp.motion) return clamp.motion;
  return std::nullopt;
}

/// u = x - X; in a frame that moves by x = c + Q (X - c) + s: the point of the frame that is now at x was at t = 0 at X + u.
template <int D>
Append<D> displacement(const GaugeCase& gauge, const Case& scene, const Structure<D>& at_start) {
  const Vector<D> reference = gauge.place<D>("at");
  const MaterialPoint point = at_start.material_point(gauge.text("body"), gauge.point("at"));
  const std::optional<RigidMotion> frame = motion_of(gauge.text("frame"), scene);
  return [reference, point, frame](const Structure<D>& structure, GaugeValues& values) {
    Vector<D> d = structure.displacement(point);
    if (frame) d = placement<D>(*frame, seconds(structure.time())).reference(reference + d) - reference;
    values.insert(values.end(), d.data(), d.data() + D);
  };
}

template <int D>
Append<D> reaction(const GaugeCase& gauge, const Case&, const Structure<D>& at_start) {
  at_start.reaction(gauge.text("body"), gauge.text("clamp"), gauge.point("at"));  // throws if there is no such clamp
  return [gauge](const Structure<D>& structure, GaugeValues& values) {
    const Reaction total = structure.reaction(gauge.text("body"), gauge.text("clamp"), gauge.point("at"));
    values.insert(values.end(), total.force.begin(), total.force.begin() + D);
    values.insert(values.end(), total.moment.begin() + (D == 2 ? 2 : 0), total.moment.end());
  };
}

/// The points of the surface within half a diameter of the sensor on the undeformed body, on its side of a thin one; at least the
/// nearest.
template <int D>
std::vector<std::size_t> points_of_sensor(const Surface<D>& surface, const std::vector<std::uint32_t>& body_of_point, std::uint32_t body,
                                          const Vector<D>& at, double diameter) {
  std::vector<std::size_t> points;
  const auto distance = [&](std::size_t k) { return (surface.position[k] - at).norm(); };
  for (std::size_t k = 0; k < body_of_point.size(); ++k)
    if (body_of_point[k] == body && (points.empty() || distance(k) < distance(points[0]))) points = {k};
  if (points.empty()) return points;
  const std::size_t nearest = points[0];
  for (std::size_t k = 0; k < body_of_point.size(); ++k) {
    const bool beside = surface.normal[k].dot(surface.normal[nearest]) > 0.5;
    if (k != nearest && body_of_point[k] == body && beside && distance(k) <= 0.5 * diameter * (1 + 1e-9)) points.push_back(k);
  }
  return points;
}

/// p = -sum f . n / sum a over the points k of the sensor.
template <int D>
Append<D> body_pressure(const GaugeCase& gauge, const Case& scene, const Structure<D>& at_start) {
  const auto points = points_of_sensor(at_start.surface(), at_start.surface_properties().body, body_index(gauge, scene),
                                       gauge.place<D>("at"), gauge.number("diameter"));
  return [points](const Structure<D>& structure, GaugeValues& values) {
    if (structure.time() == 0) return values.push_back(std::nullopt);  // before the first pressure solve
    const Surface<D> surface = structure.surface();
    double load = 0, area = 0;
    for (const std::size_t k : points) {
      load -= structure.load().force[k].dot(surface.normal[k]);
      area += surface.area[k];
    }
    values.push_back(area > 0 ? load / area : 0);
  };
}

/// How one kind of gauge is evaluated: what is found once, and a function of the present state.
template <int D>
struct Evaluation {
  const char* kind;
  Append<D> (*prepare)(const GaugeCase&, const Case&, const Structure<D>& at_start);
};

}  // namespace

template <int D>
StructureGauges<D>::StructureGauges(const Case& scene, const Structure<D>& structure) {
  const Evaluation<D> evaluations[] = {
      {"displacement", displacement<D>}, {"body_pressure", body_pressure<D>}, {"reaction", reaction<D>}};  // one entry per kind
  for (const GaugeCase& gauge : scene.gauges)
    for (const Evaluation<D>& evaluation : evaluations)
      if (gauge.kind == evaluation.kind) gauges_.push_back(evaluation.prepare(gauge, scene, structure));
}

template <int D>
GaugeValues StructureGauges<D>::values(const Structure<D>& structure) const {
  GaugeValues values;
  for (const Append<D>& append : gauges_) append(structure, values);
  return values;
}

template class StructureGauges<2>;
template class StructureGauges<3>;

}  // namespace tern::structure
