// Step limits: dt = C sqrt(dx/|g|); dt = C dx/u with u = sqrt(2 |g| H) for a fluid that is free to fall by H, and with the speeds
// of walls, clamps and bodies; for a viscous one dt = C h^2/nu; and for the structure dt_s = C dx_s/c_p,
// c_p^2 = E (1 - nu)/(rho (1 + nu)(1 - 2 nu)), in plane stress E/(rho (1 - nu^2)).
// Added mass of a cantilever of free length L in its first mode: rho_f L/1.875 per wet face, over rho_s T.

#include "scene/estimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "scene/gravity.hpp"
#include "scene/held_particles.hpp"
#include "scene/mid_surface.hpp"
#include "scene/placement.hpp"
#include "scene/scene_check.hpp"
#include "scene/shell_sampling.hpp"

namespace tern {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double longest_of_run = 0.01;  ///< first window, where nothing moves yet, over the time of the run

template <int D>
Vector<D> value(const VectorExpression& field, const Vector<D>& x) {
  Vector<D> result;
  for (int d = 0; d < D; ++d) result[d] = field[d](0, x[0], x[1], D == 3 ? x[D - 1] : 0);
  return result;
}

/// A closed shell, with what it keeps the fluid out of.
Shape without_hollow(Shape shape, bool is_shell) {
  if (shape.kind == Shape::Kind::ring && shape.end - shape.begin >= 2 * std::numbers::pi * (1 - 1e-9)) {
    shape.kind = Shape::Kind::ball;
    shape.radius += 0.5 * shape.thickness;
  } else if (shape.kind == Shape::Kind::line && shape.closed) {
    shape.kind = Shape::Kind::polygon;
  } else if (is_shell && shape.kind == Shape::Kind::difference) {  // a ball less a smaller one
    return shape.parts[0];
  }
  return shape;
}

/// Mass of the fluid that a body displaces when it dives, over its own.
template <int D>
double displaced_mass(const StructureBody& body, double fluid_density) {
  if (!body.is_shell) return fluid_density / body.density;
  const Shape whole = without_hollow(body.shape, true);
  if (whole.kind == body.shape.kind) return fluid_density / body.density;
  const MidSurface<D> surface = mid_surface<D>(body);
  double own = 0;
  for (const auto& cell : cells_of(surface)) own += cell.area * surface.thickness;
  const auto displaced = static_cast<double>(fill_lattice<D>(whole, body.spacing).size()) * std::pow(body.spacing, D);
  return fluid_density * displaced / (body.density * own);
}

/// At how many ends of its longest free extent a body is clamped; `is_held`: its held_particles().
template <int D>
int held_ends(const StructureBody& body, const std::vector<bool>& is_held) {
  Vector<D> low = Vector<D>::Constant(infinity), high = -low;
  std::vector<Vector<D>> held;
  std::size_t n = 0;
  for (const Vector<D>& x : fill_body<D>(body)) {
    if (is_held[n++])
      held.push_back(x);
    else
      low = low.cwiseMin(x), high = high.cwiseMax(x);
  }
  int along = 0;
  (high - low).maxCoeff(&along);
  const auto any = [&](auto beyond) { return std::any_of(held.begin(), held.end(), beyond); };
  return any([&](const Vector<D>& x) { return x[along] < low[along]; }) + any([&](const Vector<D>& x) { return x[along] > high[along]; });
}

template <int D>
BodyEstimate estimate_body(const Case& scene, const StructureBody& body) {
  BodyEstimate result;
  result.name = body.name;
  const auto clamped = [&](const Vector<D>& x) {
    return std::any_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& s) { return contains<D>(s, x); });
  };
  const std::vector<bool> held = held_particles<D>(body);
  result.particles = held.size();
  result.clamped = static_cast<std::size_t>(std::count(held.begin(), held.end(), true));
  const double distance = point_distance<D>(body.spacing, body.is_shell, scene.fluid);
  for (const Vector<D>& x :
       (body.is_shell ? sample_shell_surface<D>(body, scene.walls, distance) : sample_surface<D>(body.shape, distance)).position)
    result.surface_points += !clamped(x);
  if (const double joined = body.is_shell ? 0 : joined_patch_length<D>(body.spacing, scene.fluid); joined > 0)
    result.surface_points = static_cast<std::size_t>(static_cast<double>(result.surface_points) * std::pow(body.spacing / joined, 2));
  const double nu = body.poisson_ratio;
  result.wave_speed = body.plane_stress ? std::sqrt(body.young_modulus / (body.density * (1 - nu * nu)))
                                        : std::sqrt(body.young_modulus * (1 - nu) / (body.density * (1 + nu) * (1 - 2 * nu)));
  result.sub_step = scene.structure->numerics.courant * body.spacing / result.wave_speed;
  result.thickness = thin_section<D>(body);
  if (body.is_shell) {
    const MidSurface<D> surface = mid_surface<D>(body);
    result.thickness = surface.thickness;
    result.wave_speed = shell_wave_speed(body);
    result.sub_step = shell_sub_step<D>(scene.structure->numerics.courant, body.spacing, surface.thickness, result.wave_speed);
  }
  if (scene.fluid && body.clamps.empty()) result.displaced_mass = displaced_mass<D>(body, scene.fluid->density);
  if (const double length = free_length<D>(body); scene.fluid && length > 4 * result.thickness) {
    const auto added_mass_ratio = [&](double wave_number) {
      return scene.fluid->density / (wave_number * body.density * result.thickness);
    };
    result.added_mass_ratio = added_mass_ratio(1.875104 / length);
    const double wave_number = (held_ends<D>(body, held) == 1 ? 1.875104 : 4.730041) / length;  // else held or free at both ends
    const double plate_speed = std::sqrt(body.young_modulus / (body.density * (1 - nu * nu)));
    result.bending_period = 2 * std::numbers::pi * std::sqrt(12 * (1 + added_mass_ratio(wave_number))) /
                            (wave_number * wave_number * result.thickness * plate_speed);
  }
  return result;
}

/// Whether a body cannot hold back fluid that is `depth` deep: it is loose, or held at one end and bent by a spacing there by its load.
template <int D>
bool gives_way(const Case& scene, const StructureBody& body, double gravity, double depth) {
  if (body.clamps.empty()) return true;
  if (held_ends<D>(body, held_particles<D>(body)) != 1) return false;
  const double thickness = body.is_shell ? mid_surface<D>(body).thickness : thin_section<D>(body), nu = body.poisson_ratio;
  const double stiffness = body.young_modulus * std::pow(thickness, 3) / (12 * (1 - nu * nu));
  return scene.fluid->density * gravity * depth * std::pow(free_length<D>(body), 4) > 8 * stiffness * scene.fluid->spacing;
}

constexpr int instants = 500;  ///< of the run at which motions are looked at

/// How an observer moves: as a wall shifts, or evenly.
template <int D>
struct Frame {
  const RigidMotion* wall = nullptr;
  Vector<D> velocity = Vector<D>::Zero();

  /// Displacement since the start [m].
  Vector<D> place(double t) const { return wall == nullptr ? Vector<D>(velocity * t) : placement<D>(*wall, t).shift; }
};

/// The observer at rest, and the one who goes along with the scene, if there is one.
template <int D>
std::vector<Frame<D>> frames_of(const Case& scene) {
  std::vector<Frame<D>> frames(1);
  if (const std::optional<std::size_t> wall = wall_of_frame(scene)) frames.push_back({&*scene.walls[*wall].motion});
  if (!scene.walls.empty() || scene.structure) return frames;
  Vector<D> sum = Vector<D>::Zero();
  double count = 0;
  bool moves = false;
  for (const FluidBody& body : scene.fluid->bodies) {
    moves = moves || !is_zero(body.velocity);
    for (const Vector<D>& x : fill_with_fluid<D>(body.shape, scene.fluid->spacing)) sum += value<D>(body.velocity, x), ++count;
  }
  if (moves) frames.push_back({nullptr, Vector<D>(sum / count)});
  return frames;
}

/// Velocity of the observer over the first of the instants [m/s].
template <int D>
Vector<D> velocity_at_start(const Frame<D>& frame, double end_time) {
  const double instant = end_time / instants;
  return (frame.place(instant) - frame.place(0)) / instant;
}

/// Whether the field has this value everywhere, to round-off.
template <int D>
bool is_even(const VectorExpression& field, const Vector<D>& value_of_all) {
  if (!std::all_of(field.begin(), field.begin() + D, [](const Expression& part) { return part.is_constant(); })) return false;
  return (value<D>(field, Vector<D>::Zero()) - value_of_all).norm() <= 1e-9 * value_of_all.norm();
}

// It starts at rest, or as the scene is under way, and no particle has room beside it or, along gravity, below it: walls and bodies are
// there, or more of the fluid, which may be behind a body that gives way. Whether the container is shaken later makes no free fall of it.
template <int D>
bool is_settled(const Case& scene, const Vector<D>& gravity) {
  Bounds<D> extent = bounding_box<D>(scene.fluid->bodies[0].shape);
  const std::vector<Frame<D>> frames = frames_of<D>(scene);
  const bool rests = std::any_of(frames.begin(), frames.end(), [&](const Frame<D>& frame) {
    const Vector<D> velocity = velocity_at_start(frame, scene.end_time);
    return std::all_of(scene.fluid->bodies.begin(), scene.fluid->bodies.end(),
                       [&](const FluidBody& body) { return is_even<D>(body.velocity, velocity); });
  });
  if (!rests) return false;
  for (const FluidBody& body : scene.fluid->bodies) {
    const auto own = bounding_box<D>(body.shape);
    extent = {extent.min.cwiseMin(own.min), extent.max.cwiseMax(own.max)};
  }
  const double depth = (extent.max - extent.min).cwiseProduct(gravity / gravity.norm()).cwiseAbs().sum();
  constexpr double room = 0.25;  // in spacings, that a particle needs from a face at least
  const double dx = scene.fluid->spacing;
  const std::optional<Shape> region = fluid_region(scene);
  std::vector<Shape> holding, yielding;
  if (scene.structure)
    for (const StructureBody& body : scene.structure->bodies)
      (gives_way<D>(scene, body, gravity.norm(), depth) ? yielding : holding).push_back(without_hollow(body.shape, body.is_shell));
  const auto is_in_fluid = [&](const Vector<D>& x) {
    const auto& bodies = scene.fluid->bodies;
    return std::any_of(bodies.begin(), bodies.end(), [&](const FluidBody& body) { return signed_distance<D>(body.shape, x) < room * dx; });
  };
  const auto is_in = [&](const std::vector<Shape>& bodies, const Vector<D>& x) {
    return std::any_of(bodies.begin(), bodies.end(), [&](const Shape& body) { return signed_distance<D>(body, x) < room * dx; });
  };
  const auto is_taken = [&](const Vector<D>& x) {
    bool taken = is_in(holding, x) || (region && signed_distance<D>(*region, x) > -room * dx);
    for (const WallCase& wall : scene.walls) taken = taken || (!wall.container && signed_distance<D>(wall.shape, x) < room * dx);
    return taken;
  };
  const auto is_free = [&](const Vector<D>& x, const Vector<D>& step) {  // halfway there may be a body that is thinner than a spacing
    Vector<D> there = x + step;
    while (is_in(yielding, there)) there += step;
    return !is_in_fluid(there) && !is_taken(x + 0.5 * step) && !is_taken(there);
  };
  for (const FluidBody& body : scene.fluid->bodies)
    for (const Vector<D>& x : fill_with_fluid<D>(body.shape, dx))
      for (int d = 0; d < D; ++d) {
        if (scene.periodic[d]) continue;
        const bool along = std::abs(gravity[d]) > 1e-9 * gravity.norm();
        for (const double side : {-1.0, 1.0})
          if (!(along && side * gravity[d] < 0) && is_free(x, side * dx * Vector<D>::Unit(d))) return false;
      }
  return true;
}

/// Adds the largest speed that a motion, or none, gives the corners of the shape between one instant and the next, where it is larger, to
/// an observer [m/s].
template <int D>
void raise_to_motion(const std::optional<RigidMotion>& motion, const Shape& shape, double end_time, const Frame<D>& frame,
                     std::vector<double>& speed) {
  const Bounds<D> bounds = bounding_box<D>(shape);
  const auto at = [&](double t) { return motion ? placement<D>(*motion, t) : Placement<D>(); };
  Placement<D> before = at(0);
  Vector<D> frame_before = frame.place(0);
  for (int k = 0; k < instants; ++k) {
    const double t = end_time * (k + 1) / instants;
    const Placement<D> now = at(t);
    const Vector<D> frame_now = frame.place(t);
    for (int corner = 0; corner < (1 << D); ++corner) {
      Vector<D> x = bounds.min;
      for (int d = 0; d < D; ++d)
        if (corner & (1 << d)) x[d] = bounds.max[d];
      speed[k] = std::max(speed[k], (now(x) - before(x) - (frame_now - frame_before)).norm() * instants / end_time);
    }
    before = now, frame_before = frame_now;
  }
}

/// Adds those of walls, clamps, and bodies that are held where they are.
template <int D>
void raise_to_motions(const Case& scene, const Frame<D>& frame, std::vector<double>& speed) {
  for (const WallCase& wall : scene.walls) raise_to_motion<D>(wall.motion, wall.shape, scene.end_time, frame, speed);
  if (!scene.structure) return;
  for (const StructureBody& body : scene.structure->bodies)
    if (!body.clamps.empty()) raise_to_motion<D>(std::nullopt, body.shape, scene.end_time, frame, speed);
  for (const ClampCase& clamp : scene.structure->clamps)  // which takes the whole of its body along
    for (const StructureBody& body : scene.structure->bodies)
      if (body.name == clamp.body) raise_to_motion<D>(clamp.motion, body.shape, scene.end_time, frame, speed);
}

/// Whether a clamp that moves holds the body.
bool is_taken_along(const Case& scene, const StructureBody& body) {
  return std::any_of(scene.structure->clamps.begin(), scene.structure->clamps.end(),
                     [&](const ClampCase& clamp) { return clamp.body == body.name && clamp.motion.has_value(); });
}

/// Mean over the run of the largest of `least` and the speeds of fluid and bodies at the start, walls and clamps, to the observer to whom
/// it is less [m/s].
template <int D>
double mean_of_largest_speed(const Case& scene, double least) {
  std::vector<double> smallest(instants, infinity);
  for (const Frame<D>& frame : frames_of<D>(scene)) {
    const Vector<D> of_frame = velocity_at_start(frame, scene.end_time);
    double first = least;
    const auto raise_to = [&](const VectorExpression& velocity, const auto& places) {
      if (is_zero(velocity)) {
        first = std::max(first, of_frame.norm());
        return;
      }
      for (const Vector<D>& x : places()) first = std::max(first, (value<D>(velocity, x) - of_frame).norm());
    };
    for (const FluidBody& body : scene.fluid->bodies)
      raise_to(body.velocity, [&] { return fill_with_fluid<D>(body.shape, scene.fluid->spacing); });
    if (scene.structure)
      for (const StructureBody& body : scene.structure->bodies)
        if (!is_taken_along(scene, body)) raise_to(body.velocity, [&] { return fill_body<D>(body); });
    std::vector<double> speed(instants, first);
    raise_to_motions<D>(scene, frame, speed);
    for (int k = 0; k < instants; ++k) smallest[k] = std::min(smallest[k], speed[k]);
  }
  return std::accumulate(smallest.begin(), smallest.end(), 0.0) / instants;
}

/// Adds the largest acceleration of two opposite corners of the shape at the instants, where it is larger [m/s^2].
template <int D>
void raise_to_acceleration(const std::optional<RigidMotion>& motion, const Shape& shape, double end_time, std::vector<double>& largest) {
  if (!motion) return;
  const double step = end_time / instants;
  const Bounds<D> bounds = bounding_box<D>(shape);
  for (int k = 1; k < instants; ++k) {
    // Over a tenth of the time between two instants: a motion may go to and fro within it.
    const auto at = [&](double shift) { return placement<D>(*motion, (k + 0.1 * shift) * step); };
    const Placement<D> before = at(-1), now = at(0), after = at(1);
    for (const Vector<D>& x : {bounds.min, bounds.max})
      largest[k] = std::max(largest[k], (before(x) - 2 * now(x) + after(x)).norm() / (0.01 * step * step));
  }
}

/// Mean over the run of the root of the largest acceleration of walls [m^(1/2)/s].
template <int D>
double mean_root_of_acceleration(const Case& scene) {
  std::vector<double> largest(instants, 0);
  for (const WallCase& wall : scene.walls) raise_to_acceleration<D>(wall.motion, wall.shape, scene.end_time, largest);
  double sum = 0;
  for (const double acceleration : largest) sum += std::sqrt(acceleration);
  return sum / (instants - 1);
}

/// Sums over places and instants of the run of the square of a load, and of its rate [units of the load, and those/s]. A few jumps, as of
/// a load that sets in, are no motion that windows could resolve; many are, and the load swings faster than it is looked at.
template <int D>
std::pair<double, double> size_and_rate(const LoadCase& load, const Bounds<D>& loaded, double end_time) {
  constexpr int looks = 40000, most_jumps = looks / 100;
  constexpr double jump = 0.1;  // of the largest
  const Vector<D> centre = 0.5 * (loaded.min + loaded.max);
  double size = 0, rate = 0;
  std::vector<Vector<D>> values(looks + 1);
  for (const Vector<D>& x : {loaded.min, centre, loaded.max}) {
    double largest = 0;
    for (int k = 0; k <= looks; ++k) {
      for (int d = 0; d < D; ++d) values[k][d] = load.value[d](end_time * k / looks, x[0], x[1], D == 3 ? x[D - 1] : 0);
      size += values[k].squaredNorm();
      largest = std::max(largest, values[k].norm());
    }
    double of_motion = 0, of_jumps = 0;
    int jumps = 0;
    for (int k = 1; k <= looks; ++k) {
      const double change = (values[k] - values[k - 1]).norm();
      const bool jumped = change > jump * largest;
      jumps += jumped;
      (jumped ? of_jumps : of_motion) += change * change;
    }
    rate += (of_motion + (jumps > most_jumps ? of_jumps : 0)) * std::pow(looks / end_time, 2);
  }
  return {size, rate};
}

template <int D>
double window_of_loads_in(const Case& scene) {
  constexpr double share = 1.0 / 8;  // of 1/omega: 50 windows a period
  double longest = infinity;
  for (const LoadCase& load : scene.structure->loads) {
    const bool changes = std::any_of(load.value.begin(), load.value.end(), [](const Expression& f) { return f.depends_on('t'); });
    if (!changes) continue;
    for (const StructureBody& body : scene.structure->bodies) {
      if (body.name != load.body) continue;
      const auto [size, rate] = size_and_rate<D>(load, bounding_box<D>(load.region ? *load.region : body.shape), scene.end_time);
      if (rate > 0) longest = std::min(longest, share * std::sqrt(size / rate));
    }
  }
  return longest;
}

template <int D>
double window_at_rest_in(const Case& scene, bool goes_along) {
  std::vector<double> speeds(instants, 0), accelerations(instants, 0);
  const std::vector<Frame<D>> frames = frames_of<D>(scene);
  raise_to_motions<D>(scene, goes_along ? frames.back() : frames.front(), speeds);
  for (const WallCase& wall : scene.walls) raise_to_acceleration<D>(wall.motion, wall.shape, scene.end_time, accelerations);
  if (scene.structure)
    for (const ClampCase& clamp : scene.structure->clamps)
      for (const StructureBody& body : scene.structure->bodies)
        if (body.name == clamp.body) raise_to_acceleration<D>(clamp.motion, body.shape, scene.end_time, accelerations);
  const double speed = *std::max_element(speeds.begin(), speeds.end());
  const double acceleration = *std::max_element(accelerations.begin(), accelerations.end());
  const FluidCase& fluid = *scene.fluid;
  double longest = longest_of_run * scene.end_time;
  if (speed > 0) longest = std::min(longest, fluid.numerics.courant * fluid.spacing / speed);
  if (acceleration > 0) longest = std::min(longest, fluid.numerics.gravity_courant * std::sqrt(fluid.spacing / acceleration));
  return longest;
}

/// Speed of a flow that gravity drives along periodic directions, the mean over the run: until it flows as between plates so far apart as
/// the fluid reaches across, if it sticks to them, it falls freely [m/s].
template <int D>
double driven_speed(const Case& scene, const Vector<D>& gravity, const Vector<D>& extent) {
  double fastest = 0;
  for (int d = 0; d < D; ++d) {
    if (!scene.periodic[d] || gravity[d] == 0) continue;
    double across = infinity;
    for (int other = 0; other < D; ++other)
      if (other != d && !scene.periodic[other]) across = std::min(across, extent[other] + scene.fluid->spacing);
    const bool sticks =
        scene.fluid->viscosity && std::any_of(scene.walls.begin(), scene.walls.end(), [](auto& wall) { return !wall.slip; });
    const double g = std::abs(gravity[d]), time = scene.end_time,
                 steady = sticks ? g * across * across * scene.fluid->density / (8 * *scene.fluid->viscosity) : infinity;
    const double in_fall = std::min(time, steady / g);
    fastest = std::max(fastest, g * in_fall * (1 - 0.5 * in_fall / time));
  }
  return fastest;
}

/// Of the places of fluid in 3D the shares that see a wall, that see more of it than one side of a box-shaped container at rest, which
/// takes its patches (fluid/boundary/plane_walls.hpp), and that see an obstacle that moves.
struct BesideWalls {
  double all = 0, patches = 0, moving = 0;
};

BesideWalls beside_walls(const Case& scene, const std::vector<Vector<3>>& places) {
  constexpr std::size_t most = 20000;  // places that are looked at
  const double support = 2 * scene.fluid->numerics.smoothing_length_ratio * scene.fluid->spacing;
  std::vector<Shape> shapes;
  for (const WallCase& wall : scene.walls) shapes.push_back(without_open_faces(wall));
  BesideWalls share;
  const std::size_t every = places.size() / most | 1;  // odd, so that all columns of an even lattice are looked at
  const double part = static_cast<double>(every) / static_cast<double>(places.size());
  for (std::size_t n = 0; n < places.size(); n += every) {
    const Vector<3>& x = places[n];
    int sides = 0;
    bool patches = false, moving = false;
    for (std::size_t w = 0; w < shapes.size(); ++w) {
      const WallCase& wall = scene.walls[w];
      if (wall.container && wall.shape.kind == Shape::Kind::box && !wall.motion) {
        for (int d = 0; d < 3; ++d) sides += (x[d] - shapes[w].min[d] < support) + (shapes[w].max[d] - x[d] < support);
      } else if (std::abs(signed_distance<3>(shapes[w], x)) < support) {
        patches = true;
        moving = moving || (wall.motion && !wall.container);
      }
    }
    share.all += part * (sides > 0 || patches);
    share.patches += part * (sides > 1 || patches);
    share.moving += part * moving;
  }
  return share;
}

/// What walls in 3D make of the cost of a step, over that of dam_break_3d, and the time that gauges of the force on them take at each time
/// of output [s]: fits to that case, kleefsman, hydrostatic_tank_3d, and tanks with gates, with a piston and that are shaken. The steps
/// are within a third of these, the gauges within a factor of 2.5.
struct CostOfWalls {
  double factor = 1, of_a_row = 0;
};

CostOfWalls cost_of_walls(const Case& scene, const std::vector<Vector<3>>& places) {
  constexpr double inside = 0.8, patches = 2.9, moving = 12, row = 2.2e-6, row_of_patches = 15e-6;
  const BesideWalls share = beside_walls(scene, places);
  const auto forces = std::count_if(scene.gauges.begin(), scene.gauges.end(), [](const GaugeCase& gauge) { return gauge.kind == "force"; });
  const double gauged = static_cast<double>(places.size()) * static_cast<double>(forces);
  return {inside + patches * share.patches + moving * share.moving, (row * share.all + row_of_patches * share.patches) * gauged};
}

template <int D>
void estimate_fluid(const Case& scene, Estimate& result) {
  const FluidCase& fluid = *scene.fluid;
  std::vector<Vector<D>> places;
  Vector<D> mean = Vector<D>::Zero(), low = Vector<D>::Constant(infinity), high = -low;
  for (const FluidBody& body : fluid.bodies)
    for (const Vector<D>& x : fill_with_fluid<D>(body.shape, fluid.spacing)) {
      const Vector<D> g = value<D>(scene.gravity, x);
      result.gravity = std::max(result.gravity, g.norm());
      mean += g;
      low = low.cwiseMin(x), high = high.cwiseMax(x);
      places.push_back(x);
    }
  result.fluid_particles = static_cast<long>(places.size());
  if constexpr (D == 3) {
    const CostOfWalls cost = cost_of_walls(scene, places);
    result.factor_of_walls = cost.factor, result.gauge_row = cost.of_a_row;
  }
  mean /= static_cast<double>(places.size());
  // A field that draws to a place within the fluid lets nothing fall; the widest extent counts then (fluid/reference.cpp).
  const bool draws_one_way = mean.norm() > 0.5 * result.gravity;
  result.settled = draws_one_way && is_settled<D>(scene, mean);
  const Vector<D> up = draws_one_way ? Vector<D>(-mean.normalized()) : Vector<D>(Vector<D>::Zero());
  double top = -infinity, bottom = infinity;
  for (const Vector<D>& x : places) top = std::max(top, up.dot(x)), bottom = std::min(bottom, up.dot(x));
  // The fluid process reckons with half of sqrt(|g| H) at least.
  const double height = draws_one_way ? top - bottom : (high - low).maxCoeff();
  const double strongest = largest_gravity<D>(scene, places);
  const double least = 0.5 * std::sqrt(strongest * (height + fluid.spacing));
  double fall = 0;
  if (draws_one_way && !result.settled) {
    for (const WallCase& wall : scene.walls) {
      const auto box = bounding_box<D>(wall.shape);
      if (!wall.container) continue;
      Vector<D> deepest;
      for (int d = 0; d < D; ++d) deepest[d] = up[d] > 0 ? box.min[d] : up[d] < 0 ? box.max[d] : 0;
      bottom = std::min(bottom, up.dot(deepest));
    }
    fall = std::sqrt(2 * result.gravity * std::max(0.0, top - bottom));
  }
  result.speed = mean_of_largest_speed<D>(scene, std::max({fall, least, driven_speed<D>(scene, mean, high - low)}));
  result.gravity_step = strongest > 0 ? fluid.numerics.gravity_courant * std::sqrt(fluid.spacing / strongest) : infinity;
  result.flow_step = result.speed > 0 ? fluid.numerics.courant * fluid.spacing / result.speed : infinity;
  if (const double root = mean_root_of_acceleration<D>(scene); root > 0)
    result.gravity_step = std::min(result.gravity_step, fluid.numerics.gravity_courant * std::sqrt(fluid.spacing) / root);
  const double h = fluid.numerics.smoothing_length_ratio * fluid.spacing;
  result.viscous_step = fluid.viscosity ? fluid.numerics.viscous_courant * h * h * fluid.density / *fluid.viscosity : infinity;
  const double longest = scene.output.frame_interval > 0 ? std::min(scene.output.frame_interval, scene.end_time) : scene.end_time;
  result.step = std::min({result.gravity_step, result.flow_step, result.viscous_step, longest});
}

/// Cost of a sub-step of a particle, in that of a solid in 2D. In 3D the particles on the faces of a solid, with so many of them across,
/// have fewer neighbours; what completes the derivatives of two layers makes up for it (bench-structure_substep over what is measured
/// here: 4.3 with two, 4.2 with three, 7.6 with six). The few particles of a shell are not worked on four at a time.
template <int D>
double solid_work(double across) {
  return D == 3 ? 11 - 20 / std::max(3.0, across) : 1;
}
template <int D>
constexpr double shell_work = D == 3 ? 14 : 3;

/// Cost of a window in implicit steps, in sub-steps of a body of so many particles. The factors of larger bodies fill up: in 2D beyond the
/// 1020 of `gray_cantilever`; in 3D the figure is that of some thousand, and some hundred take a third of it. A shell is one layer.
template <int D>
double implicit_window_of(double particles, bool is_shell) {
  if (D == 2) return implicit_window * std::max(1.0, std::sqrt(particles / 1020));
  return is_shell ? implicit_window_of_shell_in_3d : implicit_window_in_3d * std::sqrt(particles / 3000);
}

constexpr double pressure_share = 0.4;  ///< of the cost of a step of the fluid, paid once more in each coupling iteration

/// Mass behind the faces of the lightest body where the opposite one is wet as well, in layers of fluid particles.
double least_layers(const Case& scene, const std::vector<BodyEstimate>& bodies) {
  double least = infinity;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    least = std::min(least, 0.5 * scene.structure->bodies[b].density * bodies[b].thickness / (scene.fluid->density * scene.fluid->spacing));
  return least;
}

/// Mean in a window. Where water splashes against bodies it grows with what a layer weighs over the mass behind a face: 1.03 in
/// `dam_break_obstacle` (3.8 layers), 1.43 in `dam_break_plate` (0.58), 1.62 in `dam_break_plate_3d` (0.29). A loose body that its fluid
/// carries off moves as a whole, which the answers of its faces do not show: the iterations of a Krylov method go with the root of the
/// condition number, here of what the fluid that it displaces weighs more than it does. The factor is that of `rising_disc` and
/// `rising_ball_3d` with 10 to 1200 kg/m^3. Where nothing is learnt, bodies take 3 to 10.
double coupling_iterations(const Case& scene, const Estimate& result) {
  constexpr double of_lightest = 6, of_heavy = 2, of_splashes = 0.2, of_loose = 0.7;
  const bool every_window = scene.coupling.tolerance.has_value();
  if (scene.coupling.algorithm == CouplingAlgorithm::explicit_staggering || scene.coupling.max_iterations == 1) return 1;
  if (result.lightest || (every_window && result.light)) return of_lightest;
  double most = std::max(every_window ? of_heavy : 1, 1 + of_splashes / least_layers(scene, result.bodies));
  for (const BodyEstimate& body : result.bodies) most = std::max(most, 1 + of_loose * std::sqrt(std::max(0.0, body.displaced_mass - 1)));
  return most;
}

// The windows of a structure alone are equal parts of the time from one output to the next.
double window_alone(const Case& scene, double sub_step) {
  double interval = scene.end_time;
  for (const double output : {scene.output.frame_interval, scene.output.gauge_interval})
    if (output > 0) interval = std::min(interval, output);
  return interval / (std::floor(interval / (sub_steps_per_window(scene) * sub_step)) + 1);
}

/// The velocities at these places less those of the rigid motion that comes nearest to them, a shift and, if it can turn, a rotation.
template <int D>
std::vector<Vector<D>> less_rigid_motion(const std::vector<Vector<D>>& places, std::vector<Vector<D>> velocities, bool turns) {
  const double share = 1 / static_cast<double>(places.size());
  Vector<D> centre = Vector<D>::Zero(), mean = Vector<D>::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) centre += share * places[i], mean += share * velocities[i];
  const auto in_space = [](const Vector<D>& a) { return Eigen::Vector3d(a[0], a[1], D == 3 ? a[D - 1] : 0); };
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    velocities[i] -= mean;
    const Eigen::Vector3d arm = in_space(places[i] - centre);
    inertia += arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose();
    momentum += arm.cross(in_space(velocities[i]));
  }
  if (!turns || inertia.trace() == 0) return velocities;
  const Eigen::Matrix3d invertible = inertia + 1e-12 * inertia.trace() * Eigen::Matrix3d::Identity();  // of particles on a line too
  const Eigen::Vector3d spin = invertible.inverse() * momentum;
  for (std::size_t i = 0; i < places.size(); ++i) velocities[i] -= spin.cross(in_space(places[i] - centre)).template head<D>();
  return velocities;
}

/// Bodies whose velocities at the start are not those of a rigid motion that they can make vibrate: windows by the error of their motion
/// (coupler/motion_error.cpp), in the first mode of bending of a beam that is as long and as thick.
template <int D>
double motion_step(const Case& scene, const std::vector<BodyEstimate>& bodies) {
  constexpr double tolerance = 1e-4, bending = 1.0;  // (1.875^2/sqrt(12) h c/L^2 of a cantilever)
  double longest = infinity;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const StructureBody& body = scene.structure->bodies[b];
    if (is_zero(body.velocity)) continue;
    const auto places = fill_body<D>(body);
    std::vector<Vector<D>> velocities;
    double largest = 0, speed = 0;
    for (const Vector<D>& x : places)
      velocities.push_back(value<D>(body.velocity, x)), largest = std::max(largest, velocities.back().norm());
    const bool turns = body.rigid_clamps().empty() && body.hinges.size() <= 1;
    for (const Vector<D>& u : less_rigid_motion<D>({places.begin(), places.end()}, velocities, turns)) speed = std::max(speed, u.norm());
    if (speed <= 1e-9 * largest) continue;  // round-off
    const double length = free_length<D>(body), frequency = bending * bodies[b].wave_speed * bodies[b].thickness / (length * length);
    longest = std::min(longest, std::cbrt(12 * std::sqrt(2.0) * tolerance * scene.fluid->spacing / (speed * frequency * frequency)));
  }
  return longest;
}

/// Windows that grow by a tenth from the first one, beyond those that the same time takes at their full length.
double windows_of_growth(const Case& scene, const Estimate& result) {
  const double first = std::min(result.step, first_window(scene));
  const double windows = std::log(result.step / first) / std::log(1.1);
  return windows - (result.step - first) / (0.1 * result.step);
}

template <int D>
Estimate estimate_in(const Case& scene, const Costs& costs) {
  Estimate result;
  if (scene.fluid) estimate_fluid<D>(scene, result);
  double sub_step = infinity, structure_particles = 0, surface_points = 0;
  double of_a_sub_step = 0, of_implicit_steps = 0;  // work of the structure
  if (scene.structure) {
    for (const StructureBody& body : scene.structure->bodies) {
      result.bodies.push_back(estimate_body<D>(scene, body));
      sub_step = std::min(sub_step, result.bodies.back().sub_step);
      const auto particles = static_cast<double>(result.bodies.back().particles);
      structure_particles += particles;
      const double work = particles * (body.is_shell ? shell_work<D> : solid_work<D>(result.bodies.back().thickness / body.spacing));
      of_a_sub_step += work;
      of_implicit_steps += work * implicit_window_of<D>(particles, body.is_shell);
      surface_points += static_cast<double>(result.bodies.back().surface_points);
    }
    if (!scene.fluid) result.step = window_alone(scene, sub_step);
    const double layers = scene.fluid ? least_layers(scene, result.bodies) : infinity;
    result.light = layers <= layers_of_light;
    result.lightest = layers <= layers_of_lightest;
    if (result.light) result.step *= 0.5;  // Setup::window_share
    if (scene.fluid) {
      result.motion_step = std::min(motion_step<D>(scene, result.bodies), window_of_loads_in<D>(scene));
      result.step = std::min(result.step, result.motion_step);
      if (const double frame = scene.output.frame_interval; frame > 0) result.step = frame / std::ceil(frame / result.step * (1 - 1e-9));
    }
    result.sub_steps = std::ceil(result.step / sub_step * (1 - 1e-12));
  }
  result.steps = std::ceil(scene.end_time / result.step);
  if (scene.fluid && scene.structure) result.steps = std::ceil(result.steps + windows_of_growth(scene, result));
  const Integrator integrator = scene.structure ? scene.structure->numerics.integrator : Integrator::explicit_steps;
  const double of_sub_steps = of_a_sub_step * result.sub_steps;
  const double structure_work = integrator == Integrator::explicit_steps   ? of_sub_steps
                                : integrator == Integrator::implicit_steps ? of_implicit_steps
                                                                           : std::min(of_sub_steps, of_implicit_steps);
  result.iterations = scene.fluid && scene.structure ? coupling_iterations(scene, result) : 1;
  const double passes = !scene.fluid || scene.coupling.algorithm == CouplingAlgorithm::explicit_staggering ? 1 : 1 + result.iterations;
  const double solves = 1 + pressure_share * (result.iterations - 1);
  const auto particles = static_cast<double>(result.fluid_particles);
  // The cost of a window is measured in 2D. In 3D a point sees so many more particles that the pairs cost more than the messages: between
  // what dam_break_plate_3d and submerged_block_3d take.
  constexpr double point_in_3d = 5e-6;  // of a pass [CPU s]
  result.coupler_cpu = scene.fluid && scene.structure ? costs.window * result.steps : 0;
  if (D == 3 && scene.fluid) result.coupler_cpu += point_in_3d * surface_points * passes * result.steps;
  // Measured is fluid beside a body. Without one there are no faces of it, and pressures are solved for with a looser tolerance.
  const double alone = scene.structure ? 1 : 0.55;
  result.fluid_cpu = alone * costs.fluid * (D == 3 ? 3 * result.factor_of_walls : 1) * particles * result.steps * solves;
  const double interval = scene.output.gauge_interval;
  result.fluid_cpu += result.gauge_row * (interval > 0 ? std::min(result.steps, scene.end_time / interval) : result.steps);
  // Which particles see a point past the other points of its body, and its mirror images, is found in each pass. The factor 3 holds as
  // many points a particle as dam_break_plate_3d has.
  constexpr double point_of_fluid_in_3d = 15e-6;  // between what a dry and a wet point take, 12 and 40 us [CPU s]
  constexpr double points_held = 610.0 / 7500;
  if (D == 3 && scene.fluid)
    result.fluid_cpu += point_of_fluid_in_3d * std::max(0.0, surface_points - points_held * particles) * result.iterations * result.steps;
  result.structure_cpu = costs.structure * structure_work * result.steps * passes;
  const double process = 30e6;
  constexpr double memory_of_wall_patch = 250;  // reckoned from its fields, as a sampled point and as a face [bytes]
  result.memory = (scene.fluid ? process : 0) + (scene.structure ? process : 0) + (scene.fluid && scene.structure ? process : 0) +
                  particles * (D == 3 ? 6000 : 2000) + count_wall_patches<D>(scene) * memory_of_wall_patch +
                  structure_particles * (D == 3 ? 4000 : 1000);
  return result;
}

}  // namespace

double first_window(const Case& scene) {
  constexpr double particles = 10;
  double longest = infinity;
  const auto is_loaded = [&](const StructureBody& body) {
    const auto& loads = scene.structure->loads;
    return std::any_of(loads.begin(), loads.end(), [&](const LoadCase& load) { return load.body == body.name; });
  };
  for (const StructureBody& body : scene.structure->bodies)
    if (!is_zero(body.velocity) || is_loaded(body))
      longest = std::min(longest, particles * body.spacing * std::sqrt(body.density / body.young_modulus));
  return longest;
}

double window_of_loads(const Case& scene) { return scene.dimension == 2 ? window_of_loads_in<2>(scene) : window_of_loads_in<3>(scene); }

std::optional<std::size_t> wall_of_frame(const Case& scene) {
  const auto moves = [](const WallCase& wall) { return wall.motion.has_value(); };
  if (scene.walls.empty() || !std::all_of(scene.walls.begin(), scene.walls.end(), moves)) return std::nullopt;
  const auto found = std::find_if(scene.walls.begin(), scene.walls.end(), [](const WallCase& wall) { return wall.container; });
  return found == scene.walls.end() ? 0 : static_cast<std::size_t>(found - scene.walls.begin());
}

double window_at_rest(const Case& scene, bool goes_along) {
  return scene.dimension == 2 ? window_at_rest_in<2>(scene, goes_along) : window_at_rest_in<3>(scene, goes_along);
}

double largest_clamp_speed(const Case& scene) {
  std::vector<double> speed(instants, 0);
  for (const ClampCase& clamp : scene.structure ? scene.structure->clamps : std::vector<ClampCase>())
    if (scene.dimension == 2)
      raise_to_motion<2>(clamp.motion, clamp.region, scene.end_time, {}, speed);
    else
      raise_to_motion<3>(clamp.motion, clamp.region, scene.end_time, {}, speed);
  return *std::max_element(speed.begin(), speed.end());
}

double sub_steps_per_window(const Case& scene) {
  bool varies = !scene.structure->loads.empty();
  for (const ClampCase& clamp : scene.structure->clamps) varies |= clamp.motion.has_value();
  for (const Expression& component : scene.gravity) varies |= !component.is_constant();
  return varies ? 10 : 100;
}

Estimate estimate(const Case& scene, const Costs& costs) {
  return scene.dimension == 2 ? estimate_in<2>(scene, costs) : estimate_in<3>(scene, costs);
}

}  // namespace tern
