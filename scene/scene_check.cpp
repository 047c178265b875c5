// Checks of the scene as a whole: names, walls, domain, gauges.

#include "scene/scene_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.hpp"
#include "scene/placement.hpp"

namespace tern {
namespace {

bool is_open(const WallCase& wall, const std::string& face) {
  return std::find(wall.open.begin(), wall.open.end(), face) != wall.open.end();
}

template <int D>
class SceneCheck {
 public:
  SceneCheck(Case& scene, const Setting& settings) : scene_(scene), settings_(settings) {}

  void run() {
    check_names();
    check_walls();
    set_default_domain();
    check_domain();
    check_structure();
    check_placement<D>(scene_, settings_);
    check_gauges();
  }

 private:
  [[noreturn]] static void fail(const std::string& where, const std::string& sentence) {
    throw BadInput(fmt::format("{}: {}", where, sentence));
  }

  static std::string text(const Vector<D>& x) { return fmt::format("({:.6g}) m", fmt::join(x.data(), x.data() + D, ", ")); }

  const std::string& where_wall(std::size_t i) const { return settings_.at("wall").items[i].where; }
  const std::vector<FluidBody>& fluid() const {
    static const std::vector<FluidBody> none;
    return scene_.fluid ? scene_.fluid->bodies : none;
  }
  const std::vector<StructureBody>& structure() const {
    static const std::vector<StructureBody> none;
    return scene_.structure ? scene_.structure->bodies : none;
  }

  void check_names() const {
    for (const std::string table : {"wall", "gauge", "structure.body", "structure.clamp", "structure.load"}) {
      const Setting* list = settings_.find(table.substr(0, table.find('.')));
      if (list && table.find('.') != std::string::npos) list = list->find(table.substr(table.find('.') + 1));
      if (!list) continue;
      std::set<std::string> seen;
      for (const Setting& item : list->items) {
        const std::string& name = item.at("name").text;
        if (name.find_first_of(",\"\n\r") != std::string::npos) {
          fail(item.at("name").where, fmt::format("the name '{}' holds a comma, a quote or a line break, which would break the "
                                                  "tables; use letters, digits, '_', '.' and '-'.",
                                                  name));
        }
        if (!seen.insert(name).second) {
          fail(item.at("name").where, fmt::format("the name '{}' is used twice in [[{}]]; give each its own.", name, table));
        }
      }
    }
  }

  void check_walls() const {
    int containers = 0;
    for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
      if (!scene_.walls[i].container) continue;
      if (++containers > 1) {
        fail(where_wall(i), fmt::format("'{}' is a second container, but the fluid can be inside one only; join them in one wall "
                                        "with union.",
                                        scene_.walls[i].name));
      }
    }
    if (!scene_.fluid && !scene_.walls.empty()) {
      fail(where_wall(0), "a wall acts on the fluid only, but the case has no [fluid]; remove it.");
    }
  }

  void set_default_domain() {
    if (settings_.find("domain")) {
      for (const Setting& direction : settings_.at("domain").at("periodic").items) {
        if (D == 2 && direction.text == "z") fail(direction.where, "there is no direction z in 2D that could be periodic; remove it.");
      }
      return;
    }
    std::vector<Shape> extent;
    for (const WallCase& wall : scene_.walls) {
      extent.push_back(wall.shape);
      if (wall.motion) extent.push_back(swept_box(wall));
    }
    if (extent.empty()) {
      for (const FluidBody& body : fluid()) extent.push_back(body.shape);
      for (const StructureBody& body : structure()) extent.push_back(body.shape);
    }
    Shape all;
    all.kind = Shape::Kind::union_of;
    all.parts = extent;
    const Bounds<D> bounds = bounding_box<D>(all);
    const double margin = 0.5 * (bounds.max - bounds.min).maxCoeff();
    for (int d = 0; d < D; ++d) {
      scene_.domain_min[d] = bounds.min[d] - margin;
      scene_.domain_max[d] = bounds.max[d] + margin;
    }
  }

  // The box around all places of a moving wall during the run.
  Shape swept_box(const WallCase& wall) const {
    constexpr int instants = 200;
    const Bounds<D> bounds = bounding_box<D>(wall.shape);
    Vector<D> low = bounds.min, high = bounds.max;
    for (int k = 0; k <= instants; ++k) {
      const Placement<D> place = placement<D>(*wall.motion, scene_.end_time * k / instants);
      for (int corner = 0; corner < (1 << D); ++corner) {
        Vector<D> x = bounds.min;
        for (int d = 0; d < D; ++d)
          if (corner & (1 << d)) x[d] = bounds.max[d];
        low = low.cwiseMin(place(x)), high = high.cwiseMax(place(x));
      }
    }
    Shape box;
    for (int d = 0; d < D; ++d) box.min[d] = low[d], box.max[d] = high[d];
    return box;
  }

  void check_domain() {
    const Setting* domain = settings_.find("domain");
    if (!domain) return;
    for (int d = 0; d < D; ++d) {
      const double length = scene_.domain_max[d] - scene_.domain_min[d];
      if (length <= 0) {
        fail(domain->where, fmt::format("min {} is not less than max {} m of [domain] in direction {}; exchange them.",
                                        scene_.domain_min[d], scene_.domain_max[d], "xyz"[d]));
      }
      if (scene_.periodic[d]) check_periodic(d, domain->at("periodic").where);
    }
  }

  // The fluid repeats itself in direction d: pairs have one nearest image, and walls have to repeat themselves as well.
  void check_periodic(int d, const std::string& where) {
    const char axis = "xyz"[d];
    if (!scene_.fluid) fail(where, "a periodic direction acts on the fluid only, but the case has no [fluid]; remove it.");
    if (scene_.structure) {
      fail(where,
           "a periodic direction and [structure] exclude each other, because elastic bodies have no periodic images; "
           "remove one of them.");
    }
    const FluidCase& water = *scene_.fluid;
    const double low = scene_.domain_min[d], high = scene_.domain_max[d], period = high - low;
    const double shortest = 4 * water.numerics.smoothing_length_ratio * water.spacing, slack = 1e-6 * water.spacing;
    if (period < shortest) {
      fail(where, fmt::format("the period in direction {} is {:.6g} m, but has to be at least two kernel supports, {:.6g} "
                              "m; enlarge [domain] or use a smaller fluid.spacing.",
                              axis, period, shortest));
    }
    const double count = period / water.spacing;
    if (std::abs(count - std::round(count)) > 1e-6 * count) {
      scene_.warnings.push_back(
          fmt::format("{}: the period in direction {} is {:.6g} spacings, so a lattice that fills it does not fit; {:.9g} m would be "
                      "a whole number of spacings.",
                      where, axis, count, period / std::round(count)));
    }
    for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
      const WallCase& wall = scene_.walls[i];
      const Bounds<D> bounds = bounding_box<D>(wall.shape);
      const Shape swept = wall.motion ? swept_box(wall) : Shape{};
      if (wall.motion && (swept.min[d] < bounds.min[d] - slack || swept.max[d] > bounds.max[d] + slack)) {
        fail(where_wall(i), fmt::format("the wall '{}' moves in the periodic direction {}, where it would leave its "
                                        "period; let it move across that direction only.",
                                        wall.name, axis));
      }
      if (bounds.min[d] < low - slack || bounds.max[d] > high + slack) {
        fail(where_wall(i), fmt::format("the wall '{}' reaches from {:.6g} to {:.6g} m in the periodic direction {}, but the period goes "
                                        "from {:.6g} to {:.6g} m; cut the wall there, its images continue it.",
                                        wall.name, bounds.min[d], bounds.max[d], axis, low, high));
      }
      if (!wall.container || wall.shape.kind != Shape::Kind::box) continue;
      for (const char* end : {"_min", "_max"}) {
        const std::string face = axis + std::string(end);
        if (is_open(wall, face)) continue;
        fail(where_wall(i), fmt::format("the container '{}' is closed at {}, but {} is a periodic direction; add \"{}\" to "
                                        "its open faces.",
                                        wall.name, face, axis, face));
      }
    }
  }

  // The elastic body that a clamp, a load or a gauge names.
  const StructureBody& body_named(const std::string& name, const std::string& where, const std::string& what) const {
    const auto body = std::find_if(structure().begin(), structure().end(), [&](const auto& b) { return b.name == name; });
    if (body != structure().end()) return *body;
    std::vector<std::string> names;
    for (const StructureBody& known : structure()) names.push_back(known.name);
    fail(where, fmt::format("the {} names the elastic body '{}', but {}.", what, name,
                            names.empty() ? "the case has no [structure]" : fmt::format("there is only '{}'", fmt::join(names, "', '"))));
  }

  // Clamps and loads name a body, and hold or load some of it.
  void check_structure() const {
    if (!scene_.structure) return;
    const Setting& settings = settings_.at("structure");
    for (std::size_t i = 0; i < scene_.structure->clamps.size(); ++i) {
      const ClampCase& clamp = scene_.structure->clamps[i];
      const std::string& where = settings.at("clamp").items[i].where;
      const StructureBody& body = body_named(clamp.body, where, "clamp '" + clamp.name + "'");
      const auto particles = fill_lattice<D>(body.shape, body.spacing);
      if (std::none_of(particles.begin(), particles.end(), [&](const auto& x) { return contains<D>(clamp.region, x); })) {
        fail(where, fmt::format("the region of the clamp '{}' holds no particle of the body '{}'; enlarge it to at least one "
                                "spacing, {:.3g} m, of the body.",
                                clamp.name, clamp.body, body.spacing));
      }
    }
    for (std::size_t i = 0; i < scene_.structure->loads.size(); ++i) {
      const LoadCase& load = scene_.structure->loads[i];
      const std::string& where = settings.at("load").items[i].where;
      const StructureBody& body = body_named(load.body, where, "load '" + load.name + "'");
      const bool on_volume = load.kind == LoadCase::Kind::body_force;
      const auto points = on_volume ? fill_lattice<D>(body.shape, body.spacing)
                                    : sample_surface<D>(body.shape, patch_length(body.spacing, scene_.fluid)).position;
      const auto is_loaded = [&](const Vector<D>& x) {
        const bool clamped = std::any_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& c) { return contains<D>(c, x); });
        return !clamped && (!load.region || contains<D>(*load.region, x));
      };
      if (std::none_of(points.begin(), points.end(), is_loaded)) {
        fail(where, fmt::format("the load '{}' acts on nothing: no {} of the body '{}' lies in its region outside the clamps; "
                                "move or enlarge the region (a surface has to lie inside it, not on its edge).",
                                load.name, on_volume ? "particle" : "point of the surface", load.body));
      }
    }
  }

  void check_gauges() const {
    for (std::size_t i = 0; i < scene_.gauges.size(); ++i) {
      const GaugeCase& gauge = scene_.gauges[i];
      const std::string& where = settings_.at("gauge").items[i].where;
      using Kind = GaugeCase::Kind;
      if (gauge.kind != Kind::displacement && gauge.kind != Kind::reaction && !scene_.fluid) {
        fail(where, fmt::format("the gauge '{}' measures the fluid, but the case has no [fluid]; remove it.", gauge.name));
      }
      Vector<D> at;
      for (int d = 0; d < D; ++d) at[d] = gauge.at[d];
      if (gauge.kind == Kind::pressure) {
        const auto walls = fluid_region(scene_);
        const bool moves =
            std::any_of(scene_.walls.begin(), scene_.walls.end(), [](const WallCase& wall) { return wall.container && wall.motion; });
        if (walls && !moves && signed_distance<D>(*walls, at) > 1e-6 * scene_.fluid->spacing) {
          fail(where,
               fmt::format("the gauge '{}' at {} is outside the container, where there is never fluid; move it.", gauge.name, text(at)));
        }
      }
      if (gauge.kind == Kind::flux) check_flux(gauge, where);
      if (gauge.kind == Kind::force || gauge.kind == Kind::wall_pressure) check_wall_gauge(gauge, at, where);
      if (gauge.kind != Kind::displacement && gauge.kind != Kind::interface_force && gauge.kind != Kind::reaction) continue;
      const StructureBody& body = body_named(gauge.body, where, "gauge '" + gauge.name + "'");
      if (gauge.kind == Kind::reaction) check_reaction(gauge, body, where);
      if (gauge.kind == Kind::displacement && signed_distance<D>(body.shape, at) > 1e-6 * body.spacing) {
        fail(where, fmt::format("the gauge '{}' at {} is no point of the undeformed body '{}'; move it by {:.3g} m.", gauge.name, text(at),
                                gauge.body, signed_distance<D>(body.shape, at)));
      }
    }
  }

  void check_reaction(const GaugeCase& gauge, const StructureBody& body, const std::string& where) const {
    if (body.clamps.empty())
      fail(where,
           fmt::format("the gauge '{}' measures the reaction of the body '{}', which has no clamp; give it one.", gauge.name, gauge.body));
    const auto& clamps = scene_.structure->clamps;
    if (gauge.clamp.empty() ||
        std::any_of(clamps.begin(), clamps.end(), [&](const ClampCase& c) { return c.name == gauge.clamp && c.body == gauge.body; })) {
      return;
    }
    fail(where, fmt::format("the gauge '{}' names the clamp '{}', but the body '{}' has no [[structure.clamp]] of this name; "
                            "correct it, or leave it out for all clamps of the body.",
                            gauge.name, gauge.clamp, gauge.body));
  }

  void check_flux(const GaugeCase& gauge, const std::string& where) const {
    int equal = 0;
    for (int d = 0; d < D; ++d) equal += gauge.from[d] == gauge.to[d];
    if (D == 2 && equal == 2) fail(where, fmt::format("the line of the gauge '{}' has length 0; move 'to'.", gauge.name));
    if (D == 3 && equal != 1) {
      fail(where, fmt::format("'from' and 'to' of the gauge '{}' agree in {} coordinates instead of one; they are opposite "
                              "corners of a rectangle across an axis.",
                              gauge.name, equal));
    }
  }

  void check_wall_gauge(const GaugeCase& gauge, const Vector<D>& at, const std::string& where) const {
    const auto wall = std::find_if(scene_.walls.begin(), scene_.walls.end(), [&](const auto& w) { return w.name == gauge.wall; });
    if (wall == scene_.walls.end()) {
      std::vector<std::string> names;
      for (const WallCase& known : scene_.walls) names.push_back(known.name);
      fail(where, fmt::format("the gauge '{}' names the wall '{}', but {}.", gauge.name, gauge.wall,
                              names.empty() ? "the case has no [[wall]]" : fmt::format("there is only '{}'", fmt::join(names, "', '"))));
    }
    if (gauge.kind == GaugeCase::Kind::force) return;
    const double slack = 0.1 * scene_.fluid->spacing, distance = signed_distance<D>(wall->shape, at);
    if (std::abs(distance) > slack) {
      fail(where, fmt::format("the sensor '{}' at {} is {:.3g} m away from the surface of the wall '{}'; move it there.", gauge.name,
                              text(at), std::abs(distance), gauge.wall));
    }
    bool on_open = false, on_closed = wall->open.empty();
    for (int d = 0; d < D && !wall->open.empty(); ++d)
      for (const auto& [side, face] : {std::pair{"_min", wall->shape.min[d]}, std::pair{"_max", wall->shape.max[d]}})
        if (std::abs(at[d] - face) <= slack) (is_open(*wall, std::string(1, "xyz"[d]) + side) ? on_open : on_closed) = true;
    if (on_open && !on_closed) {
      fail(where, fmt::format("the sensor '{}' at {} is on an open face of '{}', where there is no wall; move it.", gauge.name, text(at),
                              gauge.wall));
    }
  }

  Case& scene_;
  const Setting& settings_;
};

}  // namespace

std::optional<Shape> fluid_region(const Case& scene) {
  for (const WallCase& wall : scene.walls) {
    if (!wall.container) continue;
    Shape shape = wall.shape;
    for (int d = 0; d < scene.dimension && shape.kind == Shape::Kind::box; ++d) {
      if (is_open(wall, std::string(1, "xyz"[d]) + "_min")) shape.min[d] = -1e30;
      if (is_open(wall, std::string(1, "xyz"[d]) + "_max")) shape.max[d] = 1e30;
    }
    return shape;
  }
  return std::nullopt;
}

void check_scene(Case& scene, const Setting& settings) {
  scene.dimension == 2 ? SceneCheck<2>(scene, settings).run() : SceneCheck<3>(scene, settings).run();
}

}  // namespace tern
