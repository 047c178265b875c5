// Checks of the scene as a whole: names, walls, domain, gauges.

#include "particles/case_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "particles/case_placement.hpp"
#include "particles/error.hpp"

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
    check_placement<D>(scene_, settings_);
    check_gauges();
  }

 private:
  [[noreturn]] static void fail(const std::string& where, const std::string& sentence) {
    throw BadInput(fmt::format("{}: {}", where, sentence));
  }

  static std::string text(const Vector<D>& x) {
    return fmt::format("({:.6g}) m", fmt::join(x.data(), x.data() + D, ", "));
  }

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
    for (const std::string table : {"wall", "gauge", "structure"}) {
      const Setting* list = settings_.find(table);
      if (list && table == "structure") list = list->find("body");
      if (!list) continue;
      std::set<std::string> seen;
      for (const Setting& item : list->items) {
        const std::string& name = item.at("name").text;
        if (name.find_first_of(",\"\n\r") != std::string::npos) {
          fail(item.at("name").where,
               fmt::format("the name '{}' holds a comma, a quote or a line break, which would break the "
                           "tables; use letters, digits, '_', '.' and '-'.",
                           name));
        }
        if (!seen.insert(name).second) {
          fail(item.at("name").where, fmt::format("the name '{}' is used twice in [[{}]]; give each its own.", name,
                                                  table == "structure" ? "structure.body" : table));
        }
      }
    }
  }

  void check_walls() const {
    int containers = 0;
    for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
      if (!scene_.walls[i].container) continue;
      if (++containers > 1) {
        fail(where_wall(i),
             fmt::format("'{}' is a second container, but the fluid can be inside one only; join them in one wall "
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
      for (int d = 0; d < D; ++d) {
        scene_.domain_min[d] = settings_.at("domain").at("min").items[d].number;
        scene_.domain_max[d] = settings_.at("domain").at("max").items[d].number;
      }
      return;
    }
    std::vector<Shape> extent;
    for (const WallCase& wall : scene_.walls) extent.push_back(wall.shape);
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

  void check_domain() const {
    const Setting* domain = settings_.find("domain");
    if (!domain) return;
    for (int d = 0; d < D; ++d) {
      const double length = scene_.domain_max[d] - scene_.domain_min[d];
      if (length <= 0) {
        fail(domain->where, fmt::format("min {} is not less than max {} m of [domain] in direction {}; exchange them.",
                                        scene_.domain_min[d], scene_.domain_max[d], "xyz"[d]));
      }
    }
  }

  void check_gauges() const {
    for (std::size_t i = 0; i < scene_.gauges.size(); ++i) {
      const GaugeCase& gauge = scene_.gauges[i];
      const std::string& where = settings_.at("gauge").items[i].where;
      using Kind = GaugeCase::Kind;
      if (gauge.kind != Kind::displacement && !scene_.fluid) {
        fail(where,
             fmt::format("the gauge '{}' measures the fluid, but the case has no [fluid]; remove it.", gauge.name));
      }
      Vector<D> at;
      for (int d = 0; d < D; ++d) at[d] = gauge.at[d];
      if (gauge.kind == Kind::pressure) {
        const auto walls = fluid_region(scene_);
        if (walls && signed_distance<D>(*walls, at) > 1e-6 * scene_.fluid->spacing) {
          fail(where, fmt::format("the gauge '{}' at {} is outside the container, where there is never fluid; move it.",
                                  gauge.name, text(at)));
        }
      }
      if (gauge.kind != Kind::displacement && gauge.kind != Kind::interface_force) continue;
      const auto body =
          std::find_if(structure().begin(), structure().end(), [&](const auto& b) { return b.name == gauge.body; });
      if (body == structure().end()) {
        std::vector<std::string> names;
        for (const StructureBody& known : structure()) names.push_back(known.name);
        fail(where, fmt::format("the gauge '{}' names the elastic body '{}', but {}.", gauge.name, gauge.body,
                                names.empty() ? "the case has no [structure]"
                                              : fmt::format("there is only '{}'", fmt::join(names, "', '"))));
      }
      if (gauge.kind == Kind::displacement && signed_distance<D>(body->shape, at) > 1e-6 * body->spacing) {
        fail(where, fmt::format("the gauge '{}' at {} is no point of the undeformed body '{}'; move it by {:.3g} m.",
                                gauge.name, text(at), gauge.body, signed_distance<D>(body->shape, at)));
      }
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
