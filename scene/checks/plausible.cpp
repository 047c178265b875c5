// What is allowed, but hardly meant: units that were mixed up, a clamp that is missing, a spacing as large as the scene. Each warning names
// what will be seen in the run.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "scene/checks/checks.hpp"
#include "scene/mid_surface.hpp"
#include "scene/placement.hpp"
#include "scene/scene_check.hpp"

namespace tern {
namespace {

constexpr double held_patches = 3;           ///< patches around a clamp in which a body meets no wall (meeting/meeting.cpp)
constexpr double round_off = 1e-6;           ///< in spacings
constexpr double least_reynolds = 100;       ///< from which on friction hardly matters for what moves a body
constexpr double nearly_of_the_fluid = 0.2;  ///< excess of density with which a body in it is held back (measured: 0.02 and 0.1)
/// Swing that a body gains in a period with the scheme fsa, over the mass of a layer of fluid particles before its face in the mass behind
/// that (measured: `piston` at 500 to 3500 kg/m^3, spacing and window halved), and what it loses anyway (docs/THEORY.md, Known limits).
constexpr double gain_of_fsa = 1.3, loss = 0.015;
/// Poisson's ratio from which on a body is too stiff in bending (measured, cantilever four across: 3 % at 0.499, 13 % at 0.4999).
constexpr double nearly_incompressible = 0.495;
constexpr int instants = 200;                                     ///< of the run at which motions are compared
constexpr double lightest_liquid = 100, heaviest_liquid = 20000;  ///< kg/m^3; petrol ether has 600, mercury 13 600
constexpr double largest_gravity = 3000;                          ///< m/s^2; large centrifuges have 200 to 300 g

template <int D>
class Plausible {
 public:
  Plausible(Case& scene, const Setting& settings) : scene_(scene), settings_(settings) {
    Vector<D> at;
    for (int d = 0; d < D; ++d) at[d] = 0.5 * (scene.domain_min[d] + scene.domain_max[d]);
    for (int d = 0; d < D; ++d) gravity_[d] = scene.gravity[d](0, at[0], at[1], D == 3 ? at[D - 1] : 0);
  }

  void run() {
    if (scene_.fluid) {
      look_at_units();
      look_at_fluid();
      look_at_open_faces();
      look_at_time();
      look_at_pressure_gauges();
    }
    for (std::size_t i = 0; i < bodies().size(); ++i) {
      look_at_modulus(bodies()[i], settings_.at("structure").at("body").items[i]);
      look_at_poisson_ratio(bodies()[i], settings_.at("structure").at("body").items[i]);
      look_at_contacts(i);
      look_at_weight_in_fluid(i);
      look_at_viscosity(i);
      look_at_clamps_in_walls(bodies()[i], where_body(i));
      look_at_scheme(bodies()[i]);
    }
  }

 private:
  const std::vector<StructureBody>& bodies() const {
    static const std::vector<StructureBody> none;
    return scene_.structure ? scene_.structure->bodies : none;
  }
  const std::string& where_body(std::size_t i) const { return settings_.at("structure").at("body").items[i].where; }
  const std::string& where_fluid(std::size_t i) const { return settings_.at("fluid").at("body").items[i].where; }

  template <class... Parts>
  void warn(const std::string& where, fmt::format_string<Parts...> sentence, Parts&&... parts) {
    scene_.warnings.push_back(where + ": " + fmt::format(sentence, std::forward<Parts>(parts)...));
  }
  static std::string text(const Vector<D>& x) { return fmt::format("({:.6g}) m", fmt::join(x.data(), x.data() + D, ", ")); }

  /// Extent of the box along gravity [m].
  double height(const Vector<D>& low, const Vector<D>& high) const {
    return gravity_.norm() > 0 ? (high - low).dot(gravity_.cwiseAbs()) / gravity_.norm() : 0;
  }

  void look_at_units() {
    const double density = scene_.fluid->density, gravity = gravity_.norm();
    if (density < lightest_liquid || density > heaviest_liquid)
      warn(settings_.at("fluid").at("density").where,
           "the density of the fluid is {:.4g} kg/m^3, and that of water 1000: are these its units?", density);
    if (gravity > largest_gravity)
      warn(settings_.at("gravity").where, "gravity is {:.4g} m/s^2, and that of the earth 9.81: are these its units?", gravity);
  }

  // A fluid as thin as the reach of the kernel has no inside: each of its particles sees both of its sides.
  void look_at_fluid() {
    const FluidCase& fluid = *scene_.fluid;
    const double reach = 2 * fluid.numerics.smoothing_length_ratio * fluid.spacing;
    fluid_low_ = Vector<D>::Constant(std::numeric_limits<double>::max()), fluid_high_ = -fluid_low_;
    for (std::size_t i = 0; i < fluid.bodies.size(); ++i) {
      Vector<D> low = Vector<D>::Constant(std::numeric_limits<double>::max()), high = -low;
      std::size_t count = 0;
      for (const Vector<D>& x : fill_with_fluid<D>(fluid.bodies[i].shape, fluid.spacing)) {
        low = low.cwiseMin(x), high = high.cwiseMax(x);
        ++count;
      }
      const Vector<D> half = Vector<D>::Constant(0.5 * fluid.spacing);
      low -= half, high += half;
      fluid_low_ = fluid_low_.cwiseMin(low), fluid_high_ = fluid_high_.cwiseMax(high);
      int thin = 0;
      const double least = (high - low).minCoeff(&thin);
      if (least < reach * (1 - round_off))
        warn(where_fluid(i),
             "fluid body {} of {} particles is {:.2g} of them thick in direction {}, less than the reach of the kernel, {:.2g}: none of "
             "them "
             "is inside the fluid, and its pressure means little. With a spacing of {:.2g} m some are.",
             i + 1, count, least / fluid.spacing, "xyz"[thin], reach / fluid.spacing, fluid.spacing * least / reach / 2);
    }
  }

  /// Whether an elastic body or an obstacle stands everywhere between the fluid and the plane x_d = `plane`.
  bool is_caught(int d, double plane) const {
    std::vector<const Shape*> stand;
    if (scene_.structure)
      for (const StructureBody& body : scene_.structure->bodies) stand.push_back(&body.shape);
    for (const WallCase& wall : scene_.walls)
      if (!wall.container) stand.push_back(&wall.shape);
    const double spacing = scene_.fluid->spacing, near = 1e-3 * spacing;
    const auto falls_on_one = [&](Vector<D> x) {
      const double side = plane > x[d] ? 1 : -1;
      while (side * (plane - x[d]) > -spacing) {  // as far as the nearest shape, again and again
        double nearest = std::numeric_limits<double>::max();
        for (const Shape* shape : stand) nearest = std::min(nearest, signed_distance<D>(*shape, x));
        if (nearest < near) return true;
        x[d] += side * nearest;
      }
      return false;
    };
    for (const FluidBody& body : scene_.fluid->bodies) {
      const auto points = fill_with_fluid<D>(body.shape, spacing);
      if (!std::all_of(points.begin(), points.end(), falls_on_one)) return false;
    }
    return true;
  }

  /// Largest velocity with which fluid starts along an axis, up or down it [m/s].
  double speed_along(int d, bool up) const {
    double most = 0;
    for (const FluidBody& body : scene_.fluid->bodies) {
      if (is_zero(body.velocity)) continue;
      for (const Vector<D>& x : fill_with_fluid<D>(body.shape, scene_.fluid->spacing))
        most = std::max(most, (up ? 1 : -1) * body.velocity[d](0, x[0], x[1], D == 3 ? x[D - 1] : 0));
    }
    return most;
  }

  // Fluid beyond an open face runs down outside, and fluid that gravity draws to an open face, or that starts towards one,
  // leaves, unless a body closes it.
  void look_at_open_faces() {
    for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
      const WallCase& wall = scene_.walls[w];
      if (!wall.container || wall.shape.kind != Shape::Kind::box) continue;
      const Bounds<D> box = bounding_box<D>(wall.shape);
      int along = 0;
      gravity_.cwiseAbs().maxCoeff(&along);
      for (int d = 0; d < D; ++d) {
        if (scene_.periodic[d]) continue;
        for (const bool high : {false, true}) {
          const std::string face = "xyz"[d] + std::string(high ? "_max" : "_min");
          if (!is_open(wall, face)) continue;
          const double beyond = high ? fluid_high_[d] - box.max[d] : box.min[d] - fluid_low_[d];
          if (beyond > 0.5 * scene_.fluid->spacing)
            warn(where_fluid(0), "the fluid begins up to {:.3g} m beyond the open face {} of the container '{}', where nothing holds it.",
                 beyond, face, wall.name);
          if (const double out = speed_along(d, high);
              gravity_[d] == 0 && out * scene_.end_time > scene_.fluid->spacing - beyond && !is_caught(d, (high ? box.max : box.min)[d]))
            warn(
                where_fluid(0),
                "the fluid starts with up to {:.3g} m/s towards the open face {} of the container '{}', through which it leaves the scene; "
                "there is no inflow that follows it.",
                out, face, wall.name);
          if (d == along && (high ? gravity_[d] > 0 : gravity_[d] < 0) && !is_caught(d, (high ? box.max : box.min)[d]))
            warn(settings_.at("wall").items[w].where,
                 "gravity draws the fluid to the open face {} of the container '{}', through which it leaves the scene; the sign of "
                 "gravity, "
                 "{:.3g} m/s^2 in direction {}, may be wrong.",
                 face, wall.name, gravity_[d], "xyz"[d]);
        }
      }
    }
  }

  // Where nothing but gravity moves anything, and that by less than a spacing, lengths are hardly in metres.
  void look_at_time() {
    const double fall = 0.5 * gravity_.norm() * scene_.end_time * scene_.end_time;
    bool moves = fall == 0 || fall >= scene_.fluid->spacing;
    for (const FluidBody& body : scene_.fluid->bodies) moves |= !is_zero(body.velocity);
    for (const WallCase& wall : scene_.walls) moves |= wall.motion.has_value();
    for (const Expression& component : scene_.gravity) moves |= !component.is_constant();
    for (const StructureBody& body : bodies()) moves |= !is_zero(body.velocity);
    if (scene_.structure) {
      moves |= !scene_.structure->loads.empty();
      for (const ClampCase& clamp : scene_.structure->clamps) moves |= clamp.motion.has_value();
    }
    if (moves) return;
    warn(settings_.at("fluid").at("spacing").where,
         "until end_time, {:.3g} s, nothing falls farther than {:.2g} m, less than one spacing of the fluid, {:.3g} m: next to nothing "
         "will be "
         "seen to move. Lengths are in metres.",
         scene_.end_time, fall, scene_.fluid->spacing);
  }

  void look_at_pressure_gauges() {
    for (std::size_t i = 0; i < scene_.gauges.size(); ++i) {
      const GaugeCase& gauge = scene_.gauges[i];
      if (gauge.kind != "pressure") continue;
      const Vector<D> at = gauge.place<D>("at");
      const auto say = [&](const std::string& what) {
        warn(settings_.at("gauge").items[i].where, "the gauge '{}' at {} is inside {}: its column is empty while that stands there.",
             gauge.name, text(at), what);
      };
      for (const WallCase& wall : scene_.walls)
        if (!wall.container && signed_distance<D>(wall.shape, at) < 0) say("the obstacle '" + wall.name + "'");
      for (const StructureBody& body : bodies())
        if (signed_distance<D>(body.shape, at) < 0) say("the elastic body '" + body.name + "'");
    }
  }

  // A pressure as large as Young's modulus leaves nothing of a body.
  void look_at_modulus(const StructureBody& body, const Setting& table) {
    const Bounds<D> bounds = bounding_box<D>(body.shape);
    const double own = body.density * gravity_.norm() * height(bounds.min, bounds.max);
    const double wet = scene_.fluid ? scene_.fluid->density * gravity_.norm() * height(fluid_low_, fluid_high_) : 0;
    if (std::max(own, wet) <= body.young_modulus) return;
    warn(table.at("young_modulus").where,
         "Young's modulus of '{}' is {:.3g} Pa, but {} presses with {:.3g} Pa: nothing would be left of the body. The unit is Pa; 1 MPa is "
         "1e6, 1 GPa is 1e9.",
         body.name, body.young_modulus, own > wet ? "its own weight" : "the weight of the fluid", std::max(own, wet));
  }

  // What is next to incompressible locks: few particles across cannot bend without a change of their volume.
  void look_at_poisson_ratio(const StructureBody& body, const Setting& table) {
    if (body.poisson_ratio < nearly_incompressible || body.is_shell) return;
    warn(table.at("poisson_ratio").where,
         "'{}' is nearly incompressible, with a Poisson's ratio of {:g}: it bends too little (a cantilever of four particles across by 3 % "
         "at 0.499, 13 % at 0.4999, 40 % at 0.49999; half of that with eight), and explicit sub-steps are short. 0.49 is right to 1 %.",
         body.name, body.poisson_ratio);
  }

  auto surface_of(const StructureBody& body) const { return sample_surface<D>(body.shape, patch_length(body.spacing, scene_.fluid)); }

  /// A place where the surface of a body touches a shape and is not clamped. `by_weight`: one that gravity presses onto it, of a free body.
  template <class Surface>
  std::optional<Vector<D>> touching(const StructureBody& body, const Surface& surface, const Shape& shape, bool by_weight) const {
    if (by_weight && (gravity_.norm() == 0 || !body.clamps.empty())) return std::nullopt;
    for (std::size_t k = 0; k < surface.position.size(); ++k) {
      if (by_weight && surface.normal[k].dot(gravity_) <= round_off * gravity_.norm()) continue;
      const Vector<D>& x = surface.position[k];
      const bool clamped = std::any_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& s) { return contains<D>(s, x); });
      if (!clamped && std::abs(signed_distance<D>(shape, x)) < round_off * body.spacing) return x;
    }
    return std::nullopt;
  }

  bool are_apart(const StructureBody& one, const StructureBody& other) const {
    const Bounds<D> a = bounding_box<D>(one.shape), b = bounding_box<D>(other.shape);
    const double close = round_off * one.spacing;
    return (a.min - b.max).maxCoeff() > close || (b.min - a.max).maxCoeff() > close;
  }

  // What gravity alone presses onto a wall or another body at the start enters it after a few steps, and ends the run. Bodies that only
  // touch do so as soon as one of them moves towards the other.
  void look_at_contacts(std::size_t i) {
    const StructureBody& one = bodies()[i];
    std::vector<std::size_t> near;  // of the bodies before
    for (std::size_t j = 0; j < i; ++j)
      if (!are_apart(one, bodies()[j])) near.push_back(j);
    if (near.empty() && (gravity_.norm() == 0 || !one.clamps.empty())) return;
    const auto stands = [&](std::size_t upper, const std::string& other, const Vector<D>& x) {
      warn(where_body(upper),
           "the elastic body '{}' stands on {} at {}, but has no clamp. Contact of bodies is not modelled: gravity presses it in, and the "
           "run stops there. Clamp it (structure.body.{}.clamp), or leave room below it.",
           bodies()[upper].name, other, text(x), bodies()[upper].name);
    };
    const auto surface = surface_of(one);
    for (const WallCase& wall : scene_.walls)
      if (const auto x = touching(one, surface, without_open_faces(wall), true)) stands(i, "the wall '" + wall.name + "'", *x);
    for (const std::size_t j : near) {
      const StructureBody& other = bodies()[j];
      if (const auto x = touching(one, surface, other.shape, true)) {
        stands(i, "the elastic body '" + other.name + "'", *x);
      } else if (const auto below = touching(other, surface_of(other), one.shape, true)) {
        stands(j, "the elastic body '" + one.name + "'", *below);
      } else if (const auto beside = touching(one, surface, other.shape, false)) {
        warn(
            where_body(i),
            "the elastic bodies '{}' and '{}' touch at {}. They are not joined, and contact of bodies is not modelled: the run stops where "
            "one enters the other. Leave room between them.",
            other.name, one.name, text(*beside));
      }
    }
  }

  // What drives a body of nearly the fluid's density is small beside what the particles around it resist (docs/THEORY.md, Known limits).
  void look_at_weight_in_fluid(std::size_t i) {
    const StructureBody& body = bodies()[i];
    if (!scene_.fluid || gravity_.norm() == 0 || body.is_shell || !body.clamps.empty()) return;  // a shell may be hollow
    const double excess = body.density / scene_.fluid->density - 1;
    if (std::abs(excess) < round_off || std::abs(excess) > nearly_of_the_fluid) return;
    warn(
        where_body(i),
        "the elastic body '{}' is free and {:.2g} % {} than the fluid: where water is all around it, it will {} too slowly. Blocks 2 % and "
        "10 % denser than water have gone seven tenths of their way after 1 s (docs/THEORY.md, Known limits).",
        body.name, 100 * std::abs(excess), excess > 0 ? "denser" : "lighter", excess > 0 ? "sink" : "rise");
  }

  // A surface of a body bears pressure alone: neither friction nor the viscous part of the normal stress, 2 mu du_n/dn.
  void look_at_viscosity(std::size_t i) {
    if (!scene_.fluid || !scene_.fluid->viscosity) return;
    const Bounds<D> box = bounding_box<D>(bodies()[i].shape);
    const double size = (box.max - box.min).minCoeff(), nu = *scene_.fluid->viscosity / scene_.fluid->density;
    const double reynolds = size / nu * std::max(std::sqrt(gravity_.norm() * size), size / scene_.end_time);
    if (reynolds > least_reynolds) return;
    warn(where_body(i),
         "the fluid does not drag on the elastic body '{}': bodies bear its pressure, but neither its friction nor its viscous "
         "normal stress. At a Reynolds number of {:.2g} (sqrt(|g| L) L/nu over the {:.3g} m of the body, or L^2/(nu end_time)) that "
         "is much of its resistance: a disc that falls through honey in a round vessel falls 1.7 times too fast.",
         bodies()[i].name, reynolds, size);
  }

  // The scheme for comparisons does work on a body that vibrates, the more the lighter the body is.
  void look_at_scheme(const StructureBody& body) {
    if (!scene_.fluid || scene_.coupling.scheme != InterfaceScheme::fsa) return;
    const double thickness = body.is_shell ? mid_surface<D>(body).thickness : thin_section<D>(body);
    const double gain = gain_of_fsa * scene_.fluid->density * scene_.fluid->spacing / (body.density * thickness);
    if (gain < loss) return;
    warn(settings_.at("coupling").at("scheme").where,
         "the scheme fsa feeds vibrations: where the fluid cannot give way, the swing of '{}' grows by about {:.2g} % a period ({} times "
         "the mass of a layer of fluid particles over the mass behind the face). It is for comparison with published results; the default "
         "is \"riemann\".",
         body.name, 100 * gain, gain_of_fsa);
  }

  // A body that is clamped in a wall has to move as that does: the wall would run into what is farther from the clamp.
  void look_at_clamps_in_walls(const StructureBody& body, const std::string& where) {
    const double allowed = held_patches * patch_length(body.spacing, scene_.fluid);
    for (const WallCase& wall : scene_.walls) {
      const Shape shape = without_open_faces(wall);
      for (const Vector<D>& x : fill_body<D>(body)) {
        const double distance = signed_distance<D>(shape, x);
        if ((wall.container ? distance : -distance) < -round_off * body.spacing) continue;
        if (std::none_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& clamp) { return contains<D>(clamp, x); })) continue;
        const RigidMotion* held_by = nullptr;
        for (const ClampCase& clamp : scene_.structure->clamps)
          if (clamp.body == body.name && clamp.motion && contains<D>(clamp.region, x)) held_by = &*clamp.motion;
        const auto [apart, at] = farthest_apart(held_by, wall.motion ? &*wall.motion : nullptr, x);
        if (apart <= allowed) continue;
        warn(
            where,
            "the elastic body '{}' is clamped in the wall '{}' at {}, but they move apart, by {:.3g} m at t = {:.3g} s: the wall runs into "
            "the body. Give both the same motion ([[wall]] and [[structure.clamp]]).",
            body.name, wall.name, text(x), apart, at);
        break;
      }
    }
  }

  /// Largest distance [m] between where two motions (null: none) bring the point, and when [s].
  std::pair<double, double> farthest_apart(const RigidMotion* first, const RigidMotion* second, const Vector<D>& x) const {
    std::pair<double, double> farthest{0, 0};
    if (!first && !second) return farthest;
    for (int k = 1; k <= instants; ++k) {
      const double t = scene_.end_time * k / instants;
      const auto place = [&](const RigidMotion* motion) { return motion ? placement<D>(*motion, t)(x) : x; };
      farthest = std::max(farthest, std::pair((place(first) - place(second)).norm(), t));
    }
    return farthest;
  }

  Case& scene_;
  const Setting& settings_;
  Vector<D> gravity_, fluid_low_ = Vector<D>::Zero(), fluid_high_ = Vector<D>::Zero();
};

}  // namespace

template <int D>
void check_plausible(Case& scene, const Setting& settings) {
  Plausible<D>(scene, settings).run();
}

template void check_plausible<2>(Case&, const Setting&);
template void check_plausible<3>(Case&, const Setting&);

}  // namespace tern
