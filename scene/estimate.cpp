// Step limits: dt = C sqrt(dx/|g|), dt = C dx/u with u = sqrt(2 |g| H) for a fluid that is free to fall by H, and for
// a viscous one dt = C h^2/nu, and for the structure dt_s = C dx_s/c_p, c_p^2 = E (1 - nu)/(rho (1 + nu)(1 - 2 nu)), in plane
// stress E/(rho (1 - nu^2)).
// Added mass of a cantilever of free length L in its first mode: rho_f L/1.875 per wet face, over rho_s T.

#include "scene/estimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/placement.hpp"

namespace tern {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

template <int D>
Vector<D> value(const VectorExpression& field, const Vector<D>& x) {
  Vector<D> result;
  for (int d = 0; d < D; ++d) result[d] = field[d](0, x[0], x[1], D == 3 ? x[D - 1] : 0);
  return result;
}

template <int D>
BodyEstimate estimate_body(const Case& scene, const StructureBody& body) {
  BodyEstimate result;
  result.name = body.name;
  const auto clamped = [&](const Vector<D>& x) {
    return std::any_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& s) { return contains<D>(s, x); });
  };
  Vector<D> low = Vector<D>::Constant(infinity), high = -low;
  for (const Vector<D>& x : fill_lattice<D>(body.shape, body.spacing)) {
    ++result.particles;
    if (clamped(x)) {
      ++result.clamped;
    } else {
      low = low.cwiseMin(x), high = high.cwiseMax(x);
    }
  }
  for (const Vector<D>& x : sample_surface<D>(body.shape, patch_length(body.spacing, scene.fluid)).position)
    result.surface_points += !clamped(x);
  const double nu = body.poisson_ratio;
  result.wave_speed = body.plane_stress ? std::sqrt(body.young_modulus / (body.density * (1 - nu * nu)))
                                        : std::sqrt(body.young_modulus * (1 - nu) / (body.density * (1 + nu) * (1 - 2 * nu)));
  result.sub_step = scene.structure->numerics.courant * body.spacing / result.wave_speed;
  result.thickness = thin_section<D>(body);
  const double length = (high - low).maxCoeff() + body.spacing;
  if (scene.fluid && length > 4 * result.thickness) {
    result.added_mass_ratio = scene.fluid->density * length / 1.875104 / (body.density * result.thickness);
  }
  return result;
}

// One body that fills the container from wall to wall, stands on its floor, starts at rest and is not disturbed.
template <int D>
bool is_settled(const Case& scene, const Vector<D>& gravity) {
  if (scene.structure || scene.walls.size() != 1 || !scene.walls[0].container || scene.walls[0].motion || scene.fluid->bodies.size() != 1 ||
      scene.fluid->bodies[0].shape.kind != Shape::Kind::box) {
    return false;
  }
  const FluidBody& body = scene.fluid->bodies[0];
  for (const Expression& component : body.velocity) {
    if (!component.is_constant() || component(0) != 0) return false;
  }
  const auto fluid = bounding_box<D>(body.shape), wall = bounding_box<D>(scene.walls[0].shape);
  for (int d = 0; d < D; ++d) {
    const double slack = 1e-6 * scene.fluid->spacing;
    const bool along = std::abs(gravity[d]) > 1e-9 * gravity.norm();
    const bool low = std::abs(fluid.min[d] - wall.min[d]) < slack, high = std::abs(fluid.max[d] - wall.max[d]) < slack;
    if (along ? !(gravity[d] < 0 ? low : high) : !(low && high)) return false;
  }
  return true;
}

template <int D>
void estimate_fluid(const Case& scene, Estimate& result) {
  const FluidCase& fluid = *scene.fluid;
  const Vector<D> gravity = value<D>(scene.gravity, [&] {
    const auto box = bounding_box<D>(fluid.bodies[0].shape);
    return Vector<D>(0.5 * (box.min + box.max));
  }());
  result.gravity = gravity.norm();
  result.settled = result.gravity > 0 && is_settled<D>(scene, gravity);
  double initial_speed = 0, top = -infinity, bottom = infinity;
  for (const FluidBody& body : fluid.bodies) {
    for (const Vector<D>& x : fill_with_fluid<D>(body.shape, fluid.spacing)) {
      ++result.fluid_particles;
      initial_speed = std::max(initial_speed, value<D>(body.velocity, x).norm());
      if (result.gravity > 0) {
        top = std::max(top, -gravity.dot(x) / result.gravity);
        bottom = std::min(bottom, -gravity.dot(x) / result.gravity);
      }
    }
  }
  // The fluid process reckons with half of sqrt(|g| H) at least.
  const double least = result.gravity > 0 ? 0.5 * std::sqrt(result.gravity * (top - bottom + fluid.spacing)) : 0;
  double fall = 0;
  if (result.gravity > 0 && !result.settled) {
    for (const WallCase& wall : scene.walls) {
      const auto box = bounding_box<D>(wall.shape);
      if (!wall.container) continue;
      Vector<D> deepest;
      for (int d = 0; d < D; ++d) deepest[d] = gravity[d] < 0 ? box.min[d] : gravity[d] > 0 ? box.max[d] : 0;
      bottom = std::min(bottom, -gravity.dot(deepest) / result.gravity);
    }
    fall = std::sqrt(2 * result.gravity * std::max(0.0, top - bottom));
  }
  result.speed = std::max({initial_speed, fall, least});
  result.gravity_step = result.gravity > 0 ? fluid.numerics.gravity_courant * std::sqrt(fluid.spacing / result.gravity) : infinity;
  result.flow_step = result.speed > 0 ? fluid.numerics.courant * fluid.spacing / result.speed : infinity;
  const double h = fluid.numerics.smoothing_length_ratio * fluid.spacing;
  result.viscous_step = fluid.viscosity ? fluid.numerics.viscous_courant * h * h * fluid.density / *fluid.viscosity : infinity;
  result.step = std::min({result.gravity_step, result.flow_step, result.viscous_step, scene.end_time});
}

// The windows of a structure alone are equal parts of the time from one output to the next.
double window_alone(const Case& scene, double sub_step) {
  double interval = scene.end_time;
  for (const double output : {scene.output.frame_interval, scene.output.gauge_interval})
    if (output > 0) interval = std::min(interval, output);
  return interval / (std::floor(interval / (sub_steps_per_window(scene) * sub_step)) + 1);
}

template <int D>
Estimate estimate_in(const Case& scene, const Costs& costs) {
  Estimate result;
  if (scene.fluid) estimate_fluid<D>(scene, result);
  double sub_step = infinity, structure_particles = 0;
  if (scene.structure) {
    for (const StructureBody& body : scene.structure->bodies) {
      result.bodies.push_back(estimate_body<D>(scene, body));
      sub_step = std::min(sub_step, result.bodies.back().sub_step);
      structure_particles += static_cast<double>(result.bodies.back().particles);
    }
    if (!scene.fluid) result.step = window_alone(scene, sub_step);
    result.sub_steps = std::ceil(result.step / sub_step * (1 - 1e-12));
  }
  result.steps = std::ceil(scene.end_time / result.step);
  const Integrator integrator = scene.structure ? scene.structure->numerics.integrator : Integrator::explicit_steps;
  const double paid_sub_steps = integrator == Integrator::explicit_steps   ? result.sub_steps
                                : integrator == Integrator::implicit_steps ? implicit_window
                                                                           : std::min(result.sub_steps, implicit_window);
  const double passes = !scene.fluid || scene.coupling.algorithm == CouplingAlgorithm::explicit_staggering ? 1 : 2;
  const auto particles = static_cast<double>(result.fluid_particles);
  result.coupler_cpu = scene.fluid && scene.structure ? costs.window * result.steps : 0;
  result.fluid_cpu = costs.fluid * (D == 3 ? 3 : 1) * particles * result.steps;
  result.structure_cpu = costs.structure * (D == 3 ? 14 : 1) * structure_particles * result.steps * paid_sub_steps * passes;
  const double process = 30e6;
  result.memory = (scene.fluid ? process : 0) + (scene.structure ? process : 0) + (scene.fluid && scene.structure ? process : 0) +
                  particles * (D == 3 ? 6000 : 2000) + structure_particles * (D == 3 ? 4000 : 1000);
  return result;
}

}  // namespace

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
