#include "scene/keys/motion.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"
#include "scene/small_file.hpp"

namespace tern {
namespace {

namespace fs = std::filesystem;

// An expression of the motion of a wall or clamp ("wall 'gate'"): it depends on t alone and is 0 at t = 0.
void check_motion(const Expression& expression, const std::string& where, const std::string& what, const std::string& unit,
                  const std::string& mover) {
  if (expression.depends_on('x') || expression.depends_on('y') || expression.depends_on('z')) {
    throw BadInput(
        fmt::format("{}: the {} '{}' of the {} depends on the place, but it moves as a rigid whole; use t "
                    "only.",
                    where, what, expression.text(), mover));
  }
  double at_start = 0;
  try {
    at_start = expression(0);
  } catch (const NumericalFailure& fault) {
    throw BadInput(fmt::format("{}: the {} of the {}: {}", where, what, mover, fault.what()));
  }
  if (std::abs(at_start) > 1e-9) {
    throw BadInput(
        fmt::format("{}: the {} '{}' of the {} is {} {} at t = 0 instead of 0; subtract it, or shift "
                    "its shape.",
                    where, what, expression.text(), mover, at_start, unit));
  }
}

}  // namespace

void complete_motion(std::optional<RigidMotion>& motion, const Setting& table, const std::string& mover, int dimension,
                     const fs::path& folder) {
  if (!motion) return;
  const auto fail = [&](const Setting& at, const std::string& sentence) {
    throw BadInput(fmt::format("{}: the {} {}", at.where, mover, sentence));
  };
  const Setting *displacement = table.find("displacement"), *rotation = table.find("rotation");
  const Setting *file = table.find("motion_file"), *pivot = table.find("pivot"), *axis = table.find("axis");
  if (file && (displacement || rotation))
    fail(*file, fmt::format("has both motion_file and {}; give one of them.", displacement ? "displacement" : "rotation"));
  if (displacement)
    for (const Expression& component : motion->displacement) check_motion(component, displacement->where, "displacement", "m", mover);
  if (rotation) check_motion(motion->rotation, rotation->where, "rotation", "rad", mover);
  if (file) {
    const std::string path = (folder / file->text).string();
    std::string contents;
    try {
      contents = read_small_file(path, largest_motion_file);
    } catch (const InputOutputError& fault) {
      fail(*file, fmt::format("moves after '{}', but {} {}; give a CSV file by its path relative to the case file.", file->text, path,
                              fault.what()));
    }
    motion->table.emplace(contents, path, dimension);
  }
  const bool turns = rotation || (motion->table && motion->table->rotates());
  if (turns && !pivot) fail(table, "is rotated, but has no pivot; give the point about which it turns.");
  if (turns && dimension == 3 && !axis) fail(table, "is rotated, but has no axis; give its direction.");
  if (!turns && (pivot || axis)) fail(pivot ? *pivot : *axis, "is not rotated, so it has no use for pivot or axis; remove it.");
  if (axis && dimension == 2) fail(*axis, "has an axis, but in 2D it can only turn in the plane; remove it.");
  if (axis) {
    const double length = std::hypot(motion->axis[0], motion->axis[1], motion->axis[2]);
    if (length == 0) fail(*axis, "has an axis of length 0; give its direction.");
    for (double& component : motion->axis) component /= length;
  }
}

}  // namespace tern
