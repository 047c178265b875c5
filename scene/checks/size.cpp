// How much a case would hold, from lengths and areas alone, before anything is made of it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/checks/checks.hpp"
#include "scene/scene_check.hpp"

namespace tern {
namespace {

// More than this is a slip of the spacing or of a coordinate, not a scene: the state of as many fluid particles fills 100 GB, and the
// faces of as many patches of a wall 10 GB.
constexpr double most_particles = 5e7, most_patches = 5e7;

// All bodies share one process, whose state of as many particles fills 20 GB in 3D; a sub-step of them takes about 2 s of CPU. The box
// around a body says how many it has where the body is that box.
constexpr double most_elastic_particles = 5e6;

// Frames have names of six digits (run/frame_writer.cpp), by which they are sorted; a row of gauges.csv has some 100 bytes. Both intervals
// also cut the steps: nobody needs frames or rows that often, a run of as many steps takes weeks.
constexpr double most_frames = 1e6, most_rows = 1e8;

// To fill a shape each of its sides is looked at from each cell of the box around it, in some 5 ns.
constexpr double most_looks = 1e9;

/// Patches of a primitive of the shape tree.
template <int D>
double patches_of_primitive(const Shape& shape, double spacing) {
  const auto pieces = [&](double length) { return std::max(1.0, length / spacing); };
  double count = 0;
  if (shape.kind == Shape::Kind::polygon) {
    for (std::size_t i = 0, j = shape.vertices.size() - 1; i < shape.vertices.size(); j = i++)
      count += pieces(std::hypot(shape.vertices[i][0] - shape.vertices[j][0], shape.vertices[i][1] - shape.vertices[j][1]));
    return count;
  }
  if (shape.kind == Shape::Kind::line) {
    for (std::size_t i = 0; i + (shape.closed ? 0 : 1) < shape.vertices.size(); ++i) {
      const auto &a = shape.vertices[i], &b = shape.vertices[(i + 1) % shape.vertices.size()];
      count += 2 * pieces(std::hypot(a[0] - b[0], a[1] - b[1]));
    }
    return count;
  }
  if (shape.kind == Shape::Kind::plate) {
    std::array<double, 2> low = shape.vertices[0], high = low;
    for (std::size_t i = 0, j = shape.vertices.size() - 1; i < shape.vertices.size(); j = i++) {
      const auto &a = shape.vertices[j], &b = shape.vertices[i];
      count += pieces(std::hypot(b[0] - a[0], b[1] - a[1])) * pieces(shape.thickness);
      for (int d = 0; d < 2; ++d) low[d] = std::min(low[d], b[d]), high[d] = std::max(high[d], b[d]);
    }
    return count + 2 * pieces(high[0] - low[0]) * pieces(high[1] - low[1]);
  }
  if (shape.kind == Shape::Kind::ring || shape.kind == Shape::Kind::tube) {
    const double around = pieces((shape.end - shape.begin) * shape.radius);
    return 2 * around * (D == 2 ? 1 : pieces(shape.length) + pieces(shape.thickness));
  }
  if (shape.kind == Shape::Kind::ball) {
    const double around = pieces(2 * std::numbers::pi * shape.radius);
    return D == 2 ? around : around * around / std::numbers::pi;
  }
  for (int d = 0; d < D; ++d) {
    double of_face = 1;
    for (int e = 0; e < D; ++e)
      if (e != d) of_face *= pieces(shape.max[e] - shape.min[e]);
    count += 2 * of_face;
  }
  return count;
}

std::string most_text(double most) { return fmt::format("{:.0e}", most); }

}  // namespace

double count_sides(const Shape& shape) {
  double count = shape.vertices.empty() ? 1 : static_cast<double>(shape.vertices.size());
  for (const Shape& part : shape.parts) count += count_sides(part);
  return count;
}

template <int D>
double count_patches(const Shape& shape, double spacing) {
  if (shape.parts.empty()) return patches_of_primitive<D>(shape, spacing);
  double count = 0;
  for (const Shape& part : shape.parts) count += count_patches<D>(part, spacing);
  return count;
}

template <int D>
double count_wall_patches(const Case& scene) {
  double count = 0;
  if (scene.fluid)
    for (const WallCase& wall : scene.walls) count += count_patches<D>(wall.shape, wall_patch_share * scene.fluid->spacing);
  return count;
}

namespace {

template <int D>
std::string measures(const Shape& shape) {
  const Bounds<D> bounds = bounding_box<D>(shape);
  std::string text;
  for (int d = 0; d < D; ++d) text += fmt::format("{}{:.6g}", d ? " x " : "", bounds.max[d] - bounds.min[d]);
  return text + " m";
}

template <int D>
double cells_around(const Shape& shape, double spacing) {
  const Bounds<D> bounds = bounding_box<D>(shape);
  double cells = 1;
  for (int d = 0; d < D; ++d) cells *= std::max(1.0, (bounds.max[d] - bounds.min[d]) / spacing);
  return cells;
}

/// `before`: cells of the bodies before it, which share their process with it.
template <int D>
void check_body(const Shape& shape, double spacing, double patch, double most, double before, const std::string& where) {
  const double cells = cells_around<D>(shape, spacing);
  if (before + cells > most) {
    const std::string others = before > 0 ? fmt::format(" beside {:.3g} of the bodies before it", before) : "";
    fail_at(where, fmt::format("the spacing {} m would make up to {:.3g} particles of a body of {}{}, but at most {} are allowed; use a "
                               "larger spacing, or a smaller shape.",
                               spacing, cells, measures<D>(shape), others, most_text(most)));
  }
  if (const double sides = count_sides(shape); shape.kind != Shape::Kind::box && cells * sides > most_looks) {
    fail_at(where,
            fmt::format("to fill the shape, which measures {}, each of its {} sides would be looked at from {:.3g} cells of {} m, but "
                        "at most {} looks are allowed; correct a corner that is far off, use fewer corners or a larger spacing.",
                        measures<D>(shape), sides, cells, spacing, most_text(most_looks)));
  }
  const double patches = count_patches<D>(shape, patch);
  if (patches > most_patches) {
    fail_at(where, fmt::format("the surface of the shape, which measures {}, would have {:.3g} patches of {:.3g} m, but at most {} are "
                               "allowed; use a larger spacing, or a smaller shape.",
                               measures<D>(shape), patches, patch, most_text(most_patches)));
  }
}

}  // namespace

namespace {

/// Of a range whose ends may be open.
std::string room_text(double low, double high) {
  constexpr double open = 1e29;
  if (high > open) return low < -open ? "without end" : fmt::format("from {:.6g} m on", low);
  return low < -open ? fmt::format("up to {:.6g} m", high) : fmt::format("from {:.6g} to {:.6g} m", low, high);
}

// A body whose far end lies outside the container, where no clamp reaches it, is told before it is filled.
template <int D>
void check_far_end(const Case& scene, const StructureBody& body, const std::string& where) {
  const std::optional<Shape> container = fluid_region(scene);
  if (!container || !body.shape.parts.empty()) return;
  const Bounds<D> box = bounding_box<D>(body.shape), room = bounding_box<D>(*container);
  for (int d = 0; d < D; ++d) {
    bool low = box.min[d]<room.min[d] - 2 * body.spacing, high = box.max[d]> room.max[d] + 2 * body.spacing;
    for (const Shape& clamp : body.clamps) {
      const Bounds<D> held = bounding_box<D>(clamp);
      low &= held.min[d] > box.min[d] + 2 * body.spacing;
      high &= held.max[d] < box.max[d] - 2 * body.spacing;
    }
    if (!low && !high) continue;
    fail_at(where,
            fmt::format("the elastic body '{0}' stands outside the container: from {1:.6g} to {2:.6g} m in direction {3}, where there "
                        "is room {4}; move it inside (structure.body.{0}.shape), or clamp what is outside "
                        "(structure.body.{0}.clamp).",
                        body.name, box.min[d], box.max[d], "xyz"[d], room_text(room.min[d], room.max[d])));
  }
}

}  // namespace

template <int D>
void check_sizes(const Case& scene, const Setting& settings) {
  if (scene.fluid) {
    const double dx = scene.fluid->spacing;
    for (std::size_t i = 0; i < scene.fluid->bodies.size(); ++i)
      check_body<D>(scene.fluid->bodies[i].shape, dx, dx, most_particles, 0, settings.at("fluid").at("body").items[i].where);
    double before = 0;
    for (std::size_t i = 0; i < scene.walls.size(); ++i) {
      const WallCase& wall = scene.walls[i];
      const double patches = count_patches<D>(wall.shape, wall_patch_share * dx);
      before += patches;
      if (before <= most_patches) continue;
      fail_at(settings.at("wall").items[i].where,
              fmt::format("the wall '{}', which measures {}, would have {:.3g} patches of half the fluid's spacing, {:.3g} m, and so all "
                          "walls up to it {:.3g}, but at most {} are allowed; make it as large as the fluid can come to (a box may leave "
                          "faces open), or use a larger spacing.",
                          wall.name, measures<D>(wall.shape), patches, wall_patch_share * dx, before, most_text(most_patches)));
    }
  }
  if (!scene.structure) return;
  double before = 0;
  for (std::size_t i = 0; i < scene.structure->bodies.size(); ++i) {
    const StructureBody& body = scene.structure->bodies[i];
    const std::string& where = settings.at("structure").at("body").items[i].where;
    check_far_end<D>(scene, body, where);
    const bool fills_box = body.shape.kind == Shape::Kind::box && !body.is_shell;
    const double most = fills_box ? most_elastic_particles : most_particles;
    check_body<D>(body.shape, body.spacing, patch_length(body.spacing, scene.fluid), most, fills_box ? before : 0, where);
    if (fills_box) before += cells_around<D>(body.shape, body.spacing);
  }
}

template <int D>
void check_fluid_boxes(const Case& scene, const Setting& settings) {
  if (!scene.fluid) return;
  const std::optional<Shape> container = fluid_region(scene);
  const double slack = scene.fluid->spacing;
  for (std::size_t i = 0; i < scene.fluid->bodies.size(); ++i) {
    const Shape& shape = scene.fluid->bodies[i].shape;
    if (!shape.parts.empty()) continue;  // the box around what is cut out of something need not be reached
    const Bounds<D> box = bounding_box<D>(shape);
    const auto check = [&](int d, double low, double high, const char* of_what, const char* remedy) {
      if (box.min[d] >= low - slack && box.max[d] <= high + slack) return;
      fail_at(settings.at("fluid").at("body").items[i].where,
              fmt::format("fluid body {} reaches out of {}: from {:.6g} to {:.6g} m in direction {}, where there is room {}; {}.", i + 1,
                          of_what, box.min[d], box.max[d], "xyz"[d], room_text(low, high), remedy));
    };
    for (int d = 0; d < D; ++d) {
      if (container) {
        const Bounds<D> room = bounding_box<D>(*container);
        check(d, room.min[d], room.max[d], "the container", "shrink or move it");
      }
      check(d, scene.domain_min[d], scene.domain_max[d], "[domain], where particles are removed", "shrink it, or enlarge the domain");
    }
  }
}

void check_output(const Case& scene, const Setting& settings) {
  const auto check = [&](const char* key, double interval, const char* what, double most, const char* why) {
    if (interval == 0 || scene.end_time / interval <= most) return;
    fail_at(
        settings.at("output").at(key).where,
        fmt::format("{} [s] of [output] is {}, which makes {:.3g} {} until end_time, {} s, but at most {} are allowed, {}; give an "
                    "interval of at least {:.3g} s.",
                    key, interval, scene.end_time / interval, what, scene.end_time, most_text(most), why, 1.001 * scene.end_time / most));
  };
  check("frame_interval", scene.output.frame_interval, "frames", most_frames, "because their names have six digits");
  check("gauge_interval", scene.output.gauge_interval, "rows of gauges.csv", most_rows, "which already fill some 10 GB");
}

template double count_patches<2>(const Shape&, double);
template double count_patches<3>(const Shape&, double);
template double count_wall_patches<2>(const Case&);
template double count_wall_patches<3>(const Case&);
template void check_fluid_boxes<2>(const Case&, const Setting&);
template void check_fluid_boxes<3>(const Case&, const Setting&);
template void check_sizes<2>(const Case&, const Setting&);
template void check_sizes<3>(const Case&, const Setting&);

}  // namespace tern
