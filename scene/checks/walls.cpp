// Rigid walls.

#include "scene/checks/checks.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "scene/scene_check.hpp"

namespace tern {

void check_walls(const Case& scene, const Setting& settings) {
  int containers = 0;
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    if (!scene.walls[i].container) continue;
    if (++containers > 1) {
      fail_at(settings.at("wall").items[i].where,
              fmt::format("'{}' is a second container, but the fluid can be inside one only; join them in one wall "
                          "with union.",
                          scene.walls[i].name));
    }
  }
  if (!scene.fluid && !scene.walls.empty()) {
    fail_at(settings.at("wall").items[0].where, "a wall acts on the fluid only, but the case has no [fluid]; remove it.");
  }
}

bool is_open(const WallCase& wall, const std::string& face) {
  return std::find(wall.open.begin(), wall.open.end(), face) != wall.open.end();
}

Shape without_open_faces(const WallCase& wall) {
  Shape shape = wall.shape;
  for (int d = 0; d < 3; ++d) {
    if (is_open(wall, std::string(1, "xyz"[d]) + "_min")) shape.min[d] = -1e30;
    if (is_open(wall, std::string(1, "xyz"[d]) + "_max")) shape.max[d] = 1e30;
  }
  return shape;
}

std::optional<Shape> fluid_region(const Case& scene) {
  for (const WallCase& wall : scene.walls)
    if (wall.container) return without_open_faces(wall);
  return std::nullopt;
}

}  // namespace tern
