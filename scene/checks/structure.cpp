// Clamps and loads.

#include "scene/checks/checks.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "scene/mid_surface.hpp"

namespace tern {

template <int D>
void check_structure(const Case& scene, const Setting& settings) {
  if (!scene.structure) return;
  const Setting& table = settings.at("structure");
  for (std::size_t i = 0; i < scene.structure->clamps.size(); ++i) {
    const ClampCase& clamp = scene.structure->clamps[i];
    const std::string& where = table.at("clamp").items[i].where;
    const StructureBody& body = body_named(clamp.body, scene, where, "clamp '" + clamp.name + "'");
    if (body.is_shell) continue;  // mid_surface() has looked
    const auto particles = fill_lattice<D>(body.shape, body.spacing);
    if (std::none_of(particles.begin(), particles.end(), [&](const auto& x) { return contains<D>(clamp.region, x); })) {
      fail_at(where, fmt::format("the region of the clamp '{}' holds no particle of the body '{}'; enlarge it to at least one "
                                 "spacing, {:.3g} m, of the body.",
                                 clamp.name, clamp.body, body.spacing));
    }
  }
  for (std::size_t i = 0; i < scene.structure->loads.size(); ++i) {
    const LoadCase& load = scene.structure->loads[i];
    const std::string& where = table.at("load").items[i].where;
    const StructureBody& body = body_named(load.body, scene, where, "load '" + load.name + "'");
    const bool on_volume = load.kind == LoadCase::Kind::body_force;
    const auto is_loaded = [&](const Vector<D>& x) {
      const bool clamped = std::any_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& c) { return contains<D>(c, x); });
      return !clamped && (!load.region || contains<D>(*load.region, x));
    };
    const auto nowhere = [&](const auto& points) { return std::none_of(points.begin(), points.end(), is_loaded); };
    if (on_volume ? nowhere(fill_body<D>(body))
                  : nowhere(sample_surface<D>(body.shape, patch_length(body.spacing, scene.fluid)).position)) {
      fail_at(where, fmt::format("the load '{}' acts on nothing: no {} of the body '{}' lies in its region outside the clamps; "
                                 "move or enlarge the region (a surface has to lie inside it, not on its edge).",
                                 load.name, on_volume ? "particle" : "point of the surface", load.body));
    }
  }
}

template void check_structure<2>(const Case&, const Setting&);
template void check_structure<3>(const Case&, const Setting&);

}  // namespace tern
