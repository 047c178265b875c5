// From a TOML file to a Case: read, override, complete, convert, check the scene.

#include "scene/case_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "base/error.hpp"
#include "scene/parameter_table.hpp"
#include "scene/placement.hpp"
#include "scene/preset.hpp"
#include "scene/scene_check.hpp"

namespace tern {
namespace {

namespace fs = std::filesystem;

// The file that a path, a folder or a name under cases/ stands for.
std::string find_case_file(const std::string& name_or_path) {
  for (const fs::path& candidate :
       {fs::path(name_or_path), fs::path(name_or_path) / "case.toml", fs::path("cases") / name_or_path / "case.toml"}) {
    std::error_code ignored;
    if (fs::is_regular_file(candidate, ignored)) return candidate.string();
  }
  throw BadInput(
      fmt::format("There is no case '{0}': neither the file {0}, nor {0}/case.toml, nor cases/{0}/case.toml exists; "
                  "give the path of a case.toml or of its folder.",
                  name_or_path));
}

double number(const Setting& table, const std::string& key) { return table.at(key).number; }
std::string text(const Setting& table, const std::string& key) { return table.at(key).text; }

std::array<double, 3> point(const Setting& list) {
  std::array<double, 3> values{};
  for (std::size_t d = 0; d < list.items.size(); ++d) values[d] = list.items[d].number;
  return values;
}

VectorExpression expressions(const Setting& list) {
  VectorExpression values;
  for (std::size_t d = 0; d < list.items.size(); ++d) {
    const Setting& item = list.items[d];
    values[d] = item.type == Setting::Type::text ? Expression(item.text) : Expression(item.number);
  }
  return values;
}

VectorExpression expressions_or_zero(const Setting& table, const std::string& key) {
  const Setting* list = table.find(key);
  return list ? expressions(*list) : VectorExpression{};
}

// Two sides of a polygon cross or touch other than at a shared corner.
bool crosses_itself(const std::vector<std::array<double, 2>>& v) {
  const auto turn = [](const auto& a, const auto& b, const auto& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  };
  const std::size_t n = v.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      const auto &a = v[i], &b = v[i + 1], &c = v[j], &d = v[(j + 1) % n];
      if (turn(a, b, c) * turn(a, b, d) <= 0 && turn(c, d, a) * turn(c, d, b) <= 0 && (turn(a, b, c) != 0 || turn(a, b, d) != 0)) {
        return true;
      }
    }
  }
  return false;
}

Shape read_shape(const Setting& setting, int dimension) {
  const std::string& kind = setting.keys.front();
  const Setting& body = setting.items.front();
  Shape shape;
  if (kind == "box") {
    shape.kind = Shape::Kind::box;
    shape.min = point(body.at("min"));
    shape.max = point(body.at("max"));
    for (int d = 0; d < dimension; ++d) {
      if (shape.min[d] < shape.max[d]) continue;
      throw BadInput(fmt::format("{}: the box has min {} and max {} m in direction {}; min has to be less than max.",
                                 setting.items.front().where, shape.min[d], shape.max[d], "xyz"[d]));
    }
  } else if (kind == "polygon") {
    shape.kind = Shape::Kind::polygon;
    double twice_area = 0;
    for (const Setting& vertex : body.at("vertices").items) shape.vertices.push_back({point(vertex)[0], point(vertex)[1]});
    for (std::size_t i = 0, j = shape.vertices.size() - 1; i < shape.vertices.size(); j = i++) {
      const auto &a = shape.vertices[j], &b = shape.vertices[i];
      twice_area += a[0] * b[1] - b[0] * a[1];
      if (a == b) {
        throw BadInput(
            fmt::format("{}: corner {} of the polygon repeats the one before, ({}, {}) m; remove one.", body.where, i + 1, b[0], b[1]));
      }
    }
    if (crosses_itself(shape.vertices) || twice_area == 0) {
      throw BadInput(
          fmt::format("{}: the sides of the polygon cross, or it has no area; give the corners in order around it.", body.where));
    }
  } else if (kind == "ball") {
    shape.kind = Shape::Kind::ball;
    shape.center = point(body.at("center"));
    shape.radius = number(body, "radius");
  } else {
    shape.kind = kind == "union" ? Shape::Kind::union_of : Shape::Kind::difference;
    for (const Setting& part : body.items) shape.parts.push_back(read_shape(part, dimension));
  }
  return shape;
}

// An expression of the motion of a wall or clamp ("wall 'gate'"): it depends on t alone and is 0 at t = 0.
void check_motion(const Expression& expression, const std::string& where, const std::string& what, const std::string& unit,
                  const std::string& mover) {
  if (expression.depends_on('x') || expression.depends_on('y') || expression.depends_on('z')) {
    throw BadInput(
        fmt::format("{}: the {} '{}' of the {} depends on the place, but it moves as a rigid whole; use t "
                    "only.",
                    where, what, expression.text(), mover));
  }
  if (std::abs(expression(0)) > 1e-9) {
    throw BadInput(
        fmt::format("{}: the {} '{}' of the {} is {} {} at t = 0 instead of 0; subtract it, or shift "
                    "its shape.",
                    where, what, expression.text(), mover, expression(0), unit));
  }
}

std::optional<RigidMotion> read_motion(const Setting& setting, const std::string& mover, int dimension, const fs::path& folder) {
  const auto fail = [&](const Setting& at, const std::string& sentence) {
    throw BadInput(fmt::format("{}: the {} {}", at.where, mover, sentence));
  };
  const Setting *displacement = setting.find("displacement"), *rotation = setting.find("rotation");
  const Setting *file = setting.find("motion_file"), *pivot = setting.find("pivot"), *axis = setting.find("axis");
  if (file && (displacement || rotation))
    fail(*file, fmt::format("has both motion_file and {}; give one of them.", displacement ? "displacement" : "rotation"));
  RigidMotion motion;
  if (displacement) {
    motion.displacement = expressions(*displacement);
    for (const Expression& component : motion.displacement) check_motion(component, displacement->where, "displacement", "m", mover);
  }
  if (rotation) {
    motion.rotation = rotation->type == Setting::Type::text ? Expression(rotation->text) : Expression(rotation->number);
    check_motion(motion.rotation, rotation->where, "rotation", "rad", mover);
  }
  if (file) {
    const fs::path path = folder / file->text;
    std::ifstream stream(path, std::ios::binary);
    std::stringstream contents;
    if (!fs::is_regular_file(path) || !stream || !(contents << stream.rdbuf())) {
      fail(*file, fmt::format("moves after '{}', but {} cannot be read or is empty; its path is relative to the case file.", file->text,
                              path.string()));
    }
    motion.table.emplace(contents.str(), path.string(), dimension);
  }
  const bool turns = rotation || (motion.table && motion.table->rotates());
  if (turns && !pivot) fail(setting, "is rotated, but has no pivot; give the point about which it turns.");
  if (turns && dimension == 3 && !axis) fail(setting, "is rotated, but has no axis; give its direction.");
  if (!turns && (pivot || axis)) fail(pivot ? *pivot : *axis, "is not rotated, so it has no use for pivot or axis; remove it.");
  if (axis && dimension == 2) fail(*axis, "has an axis, but in 2D it can only turn in the plane; remove it.");
  if (pivot) motion.pivot = point(*pivot);
  if (axis) {
    motion.axis = point(*axis);
    const double length = std::hypot(motion.axis[0], motion.axis[1], motion.axis[2]);
    if (length == 0) fail(*axis, "has an axis of length 0; give its direction.");
    for (double& component : motion.axis) component /= length;
  }
  if (!displacement && !rotation && !file) return std::nullopt;
  return motion;
}

WallCase read_wall(const Setting& setting, int dimension, const fs::path& folder) {
  WallCase wall;
  wall.name = text(setting, "name");
  const Setting* container = setting.find("container");
  const Setting* obstacle = setting.find("obstacle");
  if ((container == nullptr) == (obstacle == nullptr)) {
    throw BadInput(fmt::format("{}: the wall '{}' has {} container and obstacle; give exactly one of them.", setting.where, wall.name,
                               container ? "both" : "neither"));
  }
  wall.container = container != nullptr;
  wall.shape = read_shape(container ? *container : *obstacle, dimension);
  wall.slip = setting.at("slip").boolean;
  for (const Setting& face : setting.at("open").items) wall.open.push_back(face.text);
  const Setting& open = setting.at("open");
  if (!wall.open.empty() && !(wall.container && wall.shape.kind == Shape::Kind::box)) {
    throw BadInput(
        fmt::format("{}: the wall '{}' has open faces, but only a container that is a box can have them.", open.where, wall.name));
  }
  for (const std::string& face : wall.open) {
    if (dimension == 2 && face[0] == 'z') {
      throw BadInput(fmt::format("{}: the wall '{}' has no face {} in 2D; remove it.", open.where, wall.name, face));
    }
  }
  wall.motion = read_motion(setting, "wall '" + wall.name + "'", dimension, folder);
  return wall;
}

FluidCase read_fluid(const Setting& setting, int dimension) {
  FluidCase fluid;
  fluid.density = number(setting, "density");
  fluid.spacing = number(setting, "spacing");
  if (setting.find("viscosity")) fluid.viscosity = number(setting, "viscosity");
  for (const Setting& body : setting.at("body").items) {
    fluid.bodies.push_back({read_shape(body.at("shape"), dimension), expressions_or_zero(body, "velocity")});
  }
  const Setting& numerics = setting.at("numerics");
  fluid.numerics.smoothing_length_ratio = number(numerics, "smoothing_length_ratio");
  fluid.numerics.gradient = text(numerics, "gradient") == "sum" ? GradientForm::sum : GradientForm::blend;
  fluid.numerics.blend_theta = number(numerics, "blend_theta");
  fluid.numerics.density_relaxation = number(numerics, "density_relaxation");
  fluid.numerics.shifting = number(numerics, "shifting");
  fluid.numerics.noise_damping = number(numerics, "noise_damping");
  fluid.numerics.courant = number(numerics, "courant");
  fluid.numerics.gravity_courant = number(numerics, "gravity_courant");
  fluid.numerics.viscous_courant = number(numerics, "viscous_courant");
  fluid.numerics.contact_distance = number(numerics, "contact_distance");
  fluid.numerics.pressure_tolerance = number(numerics, "pressure_tolerance");
  return fluid;
}

ClampCase read_clamp(const Setting& setting, int dimension, const fs::path& folder) {
  ClampCase clamp{text(setting, "name"), text(setting, "body"), read_shape(setting.at("region"), dimension), std::nullopt};
  clamp.motion = read_motion(setting, "clamp '" + clamp.name + "'", dimension, folder);
  return clamp;
}

LoadCase read_load(const Setting& setting, int dimension) {
  LoadCase load;
  load.name = text(setting, "name");
  load.body = text(setting, "body");
  if (const Setting* region = setting.find("region")) load.region = read_shape(*region, dimension);
  const Setting *traction = setting.find("traction"), *pressure = setting.find("pressure"), *body_force = setting.find("body_force");
  const int given = (traction != nullptr) + (pressure != nullptr) + (body_force != nullptr);
  if (given != 1) {
    throw BadInput(fmt::format("{}: the load '{}' has {} of traction, pressure and body_force; give exactly one.", setting.where, load.name,
                               given == 0 ? "none" : "several"));
  }
  if (pressure) {
    load.kind = LoadCase::Kind::pressure;
    load.value[0] = pressure->type == Setting::Type::text ? Expression(pressure->text) : Expression(pressure->number);
  } else {
    load.kind = traction ? LoadCase::Kind::traction : LoadCase::Kind::body_force;
    load.value = expressions(traction ? *traction : *body_force);
  }
  return load;
}

StructureCase read_structure(const Setting& setting, int dimension, bool coupled, const fs::path& folder) {
  StructureCase structure;
  for (const Setting& item : setting.at("body").items) {
    StructureBody body;
    body.name = text(item, "name");
    body.shape = read_shape(item.at("shape"), dimension);
    body.spacing = number(item, "spacing");
    body.density = number(item, "density");
    body.young_modulus = number(item, "young_modulus");
    body.poisson_ratio = number(item, "poisson_ratio");
    for (const Setting& clamp : item.at("clamp").items) body.clamps.push_back(read_shape(clamp, dimension));
    body.velocity = expressions_or_zero(item, "velocity");
    body.material = text(item, "material");
    if (item.find("mooney_ratio")) body.mooney_ratio = number(item, "mooney_ratio");
    if (const Setting* plane = item.find("plane")) {
      if (dimension == 3)
        throw BadInput(
            fmt::format("{}: the body '{}' is in plane {}, which has no meaning in 3D; remove it.", plane->where, body.name, plane->text));
      body.plane_stress = plane->text == "stress";
    }
    if (item.find("mass_damping")) body.mass_damping = number(item, "mass_damping");
    structure.bodies.push_back(std::move(body));
  }
  if (const Setting* clamps = setting.find("clamp"))
    for (const Setting& clamp : clamps->items) structure.clamps.push_back(read_clamp(clamp, dimension, folder));
  for (const ClampCase& clamp : structure.clamps)
    for (StructureBody& body : structure.bodies)
      if (body.name == clamp.body) body.clamps.push_back(clamp.region);
  if (const Setting* loads = setting.find("load"))
    for (const Setting& load : loads->items) structure.loads.push_back(read_load(load, dimension));
  const Setting& numerics = setting.at("numerics");
  structure.numerics.smoothing_length_ratio = number(numerics, "smoothing_length_ratio");
  structure.numerics.riemann_diffusion = number(numerics, "riemann_diffusion");
  structure.numerics.hourglass_penalty = number(numerics, "hourglass_penalty");
  structure.numerics.courant = number(numerics, "courant");
  const std::string integrator = numerics.find("integrator") ? text(numerics, "integrator") : coupled ? "auto" : "explicit";
  structure.numerics.integrator = integrator == "implicit" ? Integrator::implicit_steps
                                  : integrator == "auto"   ? Integrator::automatic
                                                           : Integrator::explicit_steps;
  return structure;
}

struct GaugeKeys {
  GaugeCase::Kind kind;
  std::vector<std::string> required, optional;
};

const std::map<std::string, GaugeKeys>& gauge_keys() {
  using Kind = GaugeCase::Kind;
  static const std::map<std::string, GaugeKeys> keys = {
      {"displacement", {Kind::displacement, {"body", "at"}, {}}},
      {"pressure", {Kind::pressure, {"at"}, {}}},
      {"elevation", {Kind::elevation, {"at"}, {}}},
      {"front", {Kind::front, {}, {}}},
      {"interface_force", {Kind::interface_force, {"body"}, {}}},
      {"force", {Kind::force, {"wall"}, {"at"}}},
      {"wall_pressure", {Kind::wall_pressure, {"wall", "at"}, {"diameter"}}},
      {"reaction", {Kind::reaction, {"body"}, {"clamp", "at"}}},
      {"flux", {Kind::flux, {"from", "to"}, {}}},
  };
  return keys;
}

GaugeCase read_gauge(const Setting& setting, const Case& scene) {
  const std::string& kind = setting.at("kind").text;
  const GaugeKeys& keys = gauge_keys().at(kind);
  GaugeCase gauge;
  gauge.kind = keys.kind;
  gauge.name = text(setting, "name");
  for (const std::string key : {"body", "clamp", "wall", "at", "diameter", "from", "to"}) {
    const Setting* value = setting.find(key);
    const bool needed = std::count(keys.required.begin(), keys.required.end(), key) > 0;
    if (value ? needed || std::count(keys.optional.begin(), keys.optional.end(), key) > 0 : !needed) continue;
    throw BadInput(fmt::format("{}: the gauge '{}' of kind {} {} '{}'; {} it.", value ? value->where : setting.where, gauge.name, kind,
                               needed ? "needs the key" : "has no use for the key", key, needed ? "give" : "remove"));
  }
  if (setting.find("body")) gauge.body = text(setting, "body");
  if (setting.find("clamp")) gauge.clamp = text(setting, "clamp");
  if (setting.find("wall")) gauge.wall = text(setting, "wall");
  for (const WallCase& wall : scene.walls)
    if (wall.name == gauge.wall && wall.motion) gauge.at = wall.motion->pivot;
  for (const auto& [key, place] : {std::pair{"at", &gauge.at}, std::pair{"from", &gauge.from}, std::pair{"to", &gauge.to}})
    if (const Setting* value = setting.find(key)) *place = point(*value);
  if (gauge.kind == GaugeCase::Kind::wall_pressure)
    gauge.diameter = setting.find("diameter") ? number(setting, "diameter") : scene.fluid ? scene.fluid->spacing : 0;
  return gauge;
}

// Hash FNV-1a with 64 bits.
std::string hash_of(const std::string& settings) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : settings) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return fmt::format("{:016x}", hash);
}

Case convert(const Setting& settings, const fs::path& folder) {
  Case scene;
  scene.title = text(settings, "title");
  scene.dimension = static_cast<int>(number(settings, "dimension"));
  scene.end_time = number(settings, "end_time");
  scene.gravity = expressions(settings.at("gravity"));
  if (const Setting* walls = settings.find("wall")) {
    for (const Setting& wall : walls->items) scene.walls.push_back(read_wall(wall, scene.dimension, folder));
  }
  if (const Setting* fluid = settings.find("fluid")) scene.fluid = read_fluid(*fluid, scene.dimension);
  if (const Setting* structure = settings.find("structure"))
    scene.structure = read_structure(*structure, scene.dimension, scene.fluid.has_value(), folder);
  if (const Setting* coupling = settings.find("coupling")) {
    const std::string algorithm = text(*coupling, "algorithm");
    scene.coupling.algorithm = algorithm == "CM0"   ? CouplingAlgorithm::cm0
                               : algorithm == "CM2" ? CouplingAlgorithm::cm2
                               : algorithm == "CM3" ? CouplingAlgorithm::cm3
                                                    : CouplingAlgorithm::automatic;
    scene.coupling.acceleration = text(*coupling, "acceleration") == "aitken" ? Acceleration::aitken : Acceleration::iqn_ils;
    scene.coupling.tolerance = number(*coupling, "tolerance");
    const std::string scheme = text(*coupling, "scheme");
    scene.coupling.scheme = scheme == "fsa" ? InterfaceScheme::fsa : scheme == "pi" ? InterfaceScheme::pi : InterfaceScheme::riemann;
    scene.coupling.riemann_limiter = number(*coupling, "riemann_limiter");
    scene.coupling.robin_mass_factor = number(*coupling, "robin_mass_factor");
    if (const Setting* vem = coupling->find("vem")) {
      scene.coupling.vem_coefficient = number(*vem, "coefficient");
      const std::string form = text(*vem, "form");
      scene.coupling.vem_form = form == "seed" ? VemForm::seed : form == "sum" ? VemForm::sum : VemForm::pairmax;
    }
  }
  if (const Setting* gauges = settings.find("gauge")) {
    for (const Setting& gauge : gauges->items) scene.gauges.push_back(read_gauge(gauge, scene));
  }
  scene.output.frame_interval = number(settings.at("output"), "frame_interval");
  scene.output.gauge_interval = number(settings.at("output"), "gauge_interval");
  return scene;
}

// Particles across each body, at the spacings of the case.
std::vector<double> particles_across(const Setting& settings, const fs::path& folder) {
  const Case scene = convert(settings, folder);
  std::vector<double> across;
  for (const StructureBody& body : scene.structure->bodies)
    across.push_back((scene.dimension == 2 ? thin_section<2>(body) : thin_section<3>(body)) / body.spacing);
  return across;
}

}  // namespace

Case read_case(const std::string& name_or_path, const CaseOptions& options) {
  const std::string file = find_case_file(name_or_path);
  Setting document = read_toml_file(file);
  document.where = file;
  if (!options.preset.empty()) {
    Setting preset;
    preset.type = Setting::Type::text;
    preset.text = options.preset;
    preset.where = "--preset " + options.preset;
    document.set("preset", std::move(preset));
  }
  // --set preset=... chooses the group as well; every other --set goes on top of it, in whichever order they are given.
  for (const auto& [key, value] : options.overrides)
    if (key == "preset") apply_override(document, key, value);
  const fs::path folder = fs::path(file).parent_path();
  const auto with_overrides = [&] {
    Setting whole = document;
    for (const auto& [key, value] : options.overrides) apply_override(whole, key, value);
    return complete_settings(whole);
  };
  const std::vector<std::string> changes = apply_preset(document, [&] { return particles_across(with_overrides(), folder); });
  const Setting settings = with_overrides();
  Case scene = convert(settings, folder);
  scene.preset = text(settings, "preset");
  scene.preset_changes = changes;
  const fs::path absolute = fs::absolute(file).lexically_normal();
  scene.path = absolute.string();
  scene.name = absolute.filename() == "case.toml" ? absolute.parent_path().filename().string() : absolute.stem().string();
  scene.settings = to_json(settings);
  std::string hashed = scene.settings;
  for (const WallCase& wall : scene.walls)
    if (wall.motion && wall.motion->table) hashed += wall.motion->table->text();
  if (scene.structure) {
    for (const ClampCase& clamp : scene.structure->clamps)
      if (clamp.motion && clamp.motion->table) hashed += clamp.motion->table->text();
  }
  scene.hash = hash_of(hashed);
  check_scene(scene, settings);
  return scene;
}

}  // namespace tern
