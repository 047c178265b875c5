#pragma once
// Extremes of the structure: scenes far from the ordinary. Shared by extremes_test.cpp (the quick ones) and
// bench/structure_extremes.cpp (all, as the table of docs/STRUCTURE.md).

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "structure/material.hpp"
#include "tests/structure/scenes.hpp"

namespace tern::structure::testing {

struct Extreme {
  enum class Result {
    none,
    frequency,         ///< of the end of the body, from its first way through rest, over `reference` [Hz]
    jacobian,          ///< J of the particle nearest to `end`, over `reference`
    angular_momentum,  ///< over its value at the start
  };
  std::string what;  ///< in words, with units
  Case scene;        ///< one body
  double until = 0;  ///< [s]
  Result result = Result::none;
  double reference = 0;
  std::string reference_name;
  int direction = 1;         ///< in which the end swings
  std::array<double, 3> end{};  ///< material point
  enum class Stop { never, may, must } stop = Stop::never;  ///< with a NumericalFailure
  bool quick = false;        ///< also in the test suite
};

/// A plate (3D: a square bar) 0.02 m thick along x, clamped at x < 0, `slenderness` times as long, started in its first bending
/// mode with an amplitude of about a hundredth of its length. Runs until it has come back through rest.
inline Extreme swing(int dimension, double slenderness, int across, double young_modulus, double poisson_ratio, Integrator integrator) {
  const double thickness = 0.02, length = slenderness * thickness, spacing = thickness / across;
  StructureBody b = body("plate", {-spacing, 0, 0}, {length, thickness, thickness}, spacing);
  b.young_modulus = young_modulus;
  b.poisson_ratio = poisson_ratio;
  b.clamps = {box({-1, -1, -1}, {0, 1, 1})};
  const double k = 1.875104 / length, speed = 1e-2 / slenderness * std::sqrt(young_modulus / b.density);
  b.velocity[1] = Expression(fmt::format("{0}*(cosh({1}*x)-cos({1}*x)-0.7340955*(sinh({1}*x)-sin({1}*x)))", 0.5 * speed, k));
  Extreme extreme;
  extreme.scene = scene(dimension, {b});
  extreme.scene.structure->numerics.integrator = integrator;
  const double across_modulus = young_modulus / (dimension == 2 ? 1 - poisson_ratio * poisson_ratio : 1);
  extreme.result = Extreme::Result::frequency;
  extreme.reference = k * k * thickness * std::sqrt(across_modulus / (12 * b.density)) / (2 * std::numbers::pi);
  extreme.reference_name = "f1 over thin-plate theory";
  extreme.until = 0.6 / extreme.reference;
  extreme.end = {length, 0.5 * thickness, dimension == 2 ? 0 : 0.5 * thickness};
  return extreme;
}

/// A block as long as thick, clamped at x < 0, with Poisson's ratio 0: it swings along x in sin(pi x/2L) with c/(4 L).
inline Extreme blocky(int dimension, int across, Integrator integrator) {
  const double length = 0.02, spacing = length / across;
  StructureBody b = body("block", {-spacing, 0, 0}, {length, length, length}, spacing);
  b.poisson_ratio = 0;
  b.clamps = {box({-1, -1, -1}, {0, 1, 1})};
  const double c = std::sqrt(b.young_modulus / b.density);
  b.velocity[0] = Expression(fmt::format("{}*sin({}*x)", 1e-3 * c, std::numbers::pi / (2 * length)));
  Extreme extreme;
  extreme.scene = scene(dimension, {b});
  extreme.scene.structure->numerics.integrator = integrator;
  extreme.result = Extreme::Result::frequency;
  extreme.direction = 0;
  extreme.reference = c / (4 * length);
  extreme.reference_name = "f1 over that of a bar";
  extreme.until = 0.6 / extreme.reference;
  extreme.end = {length, 0.5 * length, dimension == 2 ? 0 : 0.5 * length};
  return extreme;
}

/// A free square (cube) of 20 mm at 1000 rad/s about its middle, for `turns`.
inline Extreme spin(int dimension, int across, double turns, Integrator integrator) {
  StructureBody b = body("block", {-0.01, -0.01, -0.01}, {0.01, 0.01, 0.01}, 0.02 / across);
  b.young_modulus = 1e7;
  b.velocity[0] = Expression("-1000*y");
  b.velocity[1] = Expression("1000*x");
  Extreme extreme;
  extreme.scene = scene(dimension, {b});
  extreme.scene.structure->numerics.integrator = integrator;
  extreme.until = turns * 2 * std::numbers::pi / 1000;
  extreme.result = Extreme::Result::angular_momentum;
  extreme.reference_name = "angular momentum over that at the start";
  return extreme;
}

/// A flat block, `width` x 1 (x width) without Poisson's ratio, whose upper face goes down until `left` of its height is left.
/// Its sides may buckle outwards, its middle has nowhere to go.
inline Extreme squeeze(int dimension, int across, double width, double left, MaterialLaw law, Integrator integrator) {
  const double spacing = 1.0 / across;
  StructureBody b = body("block", {0, -spacing, 0}, {width, 1 + spacing, width}, spacing);
  b.poisson_ratio = 0;
  b.law = law;
  const Shape foot = box({-1, -1, -1}, {width + 1, 0, width + 1}), head = box({-1, 1, -1}, {width + 1, 2, width + 1});
  b.clamps = {foot, head};
  Extreme extreme;
  extreme.scene = scene(dimension, {b});
  extreme.scene.structure->numerics.integrator = integrator;
  const Material material = Material::isotropic(b.density, b.young_modulus, b.poisson_ratio);
  extreme.until = 10 / material.pressure_wave_speed();  // there in ten times what a wave needs
  RigidMotion motion;
  motion.displacement[1] = Expression(fmt::format("-{}*(1-cos({}*t))", 0.5 * (1 - left), std::numbers::pi / extreme.until));
  extreme.scene.structure->clamps = {{"head", "block", head, motion}};
  if (law == MaterialLaw::st_venant_kirchhoff) extreme.stop = Extreme::Stop::may;
  extreme.end = {0.5 * width, 0.5, dimension == 2 ? 0 : 0.5 * width};
  extreme.result = Extreme::Result::jacobian;
  extreme.reference = left;
  extreme.reference_name = "J in the middle over the squeeze";
  return extreme;
}

/// A free block of 1 m under a pressure all round that rises until a tenth of its area (2D) is left:
/// p = (mu (1 - s^2) - lambda ln J)/J with s^2 = J. Mass damping takes what swings.
inline Extreme compress(int across, Integrator integrator) {
  StructureBody b = body("block", {-0.5, -0.5, 0}, {0.5, 0.5, 0}, 1.0 / across);
  const Material material = Material::isotropic(b.density, b.young_modulus, b.poisson_ratio);
  const double c = material.pressure_wave_speed(), j = 0.1;
  b.mass_damping = c;
  Extreme extreme;
  extreme.scene = scene(2, {b});
  extreme.scene.structure->numerics.integrator = integrator;
  extreme.until = 60 / c;
  extreme.stop = Extreme::Stop::may;
  LoadCase load;
  load.kind = LoadCase::Kind::pressure;
  load.body = "block";
  load.value[0] = Expression(fmt::format("{}*min(1,{}*t)", (material.mu * (1 - j) - material.lambda * std::log(j)) / j, c / 30));
  extreme.scene.structure->loads = {load};
  extreme.result = Extreme::Result::jacobian;
  extreme.reference = j;
  extreme.reference_name = "J in the middle over 0.1";
  return extreme;
}

/// The plate of the dam break (E = 3.5 MPa) under a pressure of 30 MPa on one face, or hit at twice its wave speed.
inline Extreme violent(int dimension, bool blow, Integrator integrator) {
  Extreme extreme;
  extreme.scene = plate();
  StructureBody& b = extreme.scene.structure->bodies[0];
  if (dimension == 3) {
    extreme.scene.dimension = 3;
    b.spacing *= 2;
    b.shape.max[2] = 0.008;
    b.clamps[0].min[2] = -1;
    b.clamps[0].max[2] = 1;
  }
  if (blow) {
    b.velocity[0] = Expression("y > 0.045 ? 200 : 0");
  } else {
    LoadCase load;
    load.kind = LoadCase::Kind::pressure;
    load.body = "plate";
    load.region = box({0.59, 0, -1}, {0.5965, 0.1, 1});
    load.value[0] = Expression(3e7);
    extreme.scene.structure->loads = {load};
  }
  extreme.scene.structure->numerics.integrator = integrator;
  extreme.until = 5e-3;
  extreme.stop = Extreme::Stop::must;
  return extreme;
}

/// A plate so soft that its weight bends it through its whole length: E = 1 kPa, 0.2 m x 0.02 m, one second.
inline Extreme soft(Integrator integrator) {
  Extreme extreme = swing(2, 10, 4, 1e3, 0.3, integrator);
  extreme.scene.structure->bodies[0].velocity[1] = Expression();
  extreme.scene.gravity[1] = Expression(-9.81);
  extreme.until = 1;
  extreme.stop = Extreme::Stop::may;
  extreme.result = Extreme::Result::none;
  return extreme;
}

/// All of them, in the order of the table.
inline std::vector<Extreme> extremes() {
  using enum Integrator;
  std::vector<Extreme> all;
  const auto add = [&](const std::string& what, Extreme extreme, bool quick = false) {
    extreme.what = what + (extreme.scene.dimension == 3 ? ", 3D" : "") +
                   (extreme.scene.structure->numerics.integrator == implicit_steps ? ", implicit" : "");
    extreme.quick = quick;
    all.push_back(std::move(extreme));
  };
  for (const Integrator integrator : {explicit_steps, implicit_steps}) {
    const bool implicit = integrator == implicit_steps;
    for (const double nu : {0.3, 0.45, 0.49, 0.499, 0.4999})
      add(fmt::format("plate of L/t = 10, 4 across, Poisson's ratio {}", nu), swing(2, 10, 4, 2e6, nu, integrator), implicit && nu == 0.4999);
    for (const double nu : {0.3, 0.49, 0.4999})
      if (!implicit || nu < 0.4) add(fmt::format("bar of L/t = 6, 3 across, Poisson's ratio {}", nu), swing(3, 6, 3, 2e6, nu, integrator));
    for (const double e : {1e3, 1e6, 1e9, 1e12})
      add(fmt::format("plate of L/t = 10, 4 across, E = {:.0e} Pa", e), swing(2, 10, 4, e, 0.3, integrator), e == 1e3 || e == 1e12);
    add("plate of E = 1e3 Pa, 0.2 m x 0.02 m, under its weight, 1 s", soft(integrator), true);
    for (const int across : {2, 3, 4, 8, 16}) {
      Extreme plate = swing(2, 10, across, 2e6, 0.3, integrator);
      if (across == 2) plate.until *= 2;  // too soft: two layers carry no quadratic gradient
      add(fmt::format("plate of L/t = 10, {} across", across), plate, across == 2);
    }
    add("plate of L/t = 20, 4 across", swing(2, 20, 4, 2e6, 0.3, integrator));
    Extreme slender = swing(2, 200, 3, 2e6, 0.3, integrator);
    slender.until *= implicit ? 0.05 : 0.005;
    slender.result = Extreme::Result::none;
    add(fmt::format("plate of L/t = 200, 3 across, {} of a period", implicit ? "3 %" : "0.3 %"), slender);
  }
  for (const Integrator integrator : {explicit_steps, implicit_steps}) {
    add("block of L/t = 1, 8 across, stretched", blocky(2, 8, integrator), true);
    add("block of L/t = 1, 6 across, stretched", blocky(3, 6, integrator));
    add("free block of 20 mm, E = 10 MPa, 10 across, spinning at 1000 rad/s, 10 turns", spin(2, 10, 10, integrator), true);
    add("free block of 20 mm, E = 10 MPa, 6 across, spinning at 1000 rad/s, 2 turns", spin(3, 6, 2, integrator));
    for (const double left : {0.7, 0.5, 0.1}) {
      Extreme flat = squeeze(2, 8, left < 0.4 ? 8 : 2, left, MaterialLaw::neo_hookean, integrator);
      if (left < 0.4) flat.stop = Extreme::Stop::may;  // at the corners of the clamps
      add(fmt::format("block {:.0f} m x 1 m, 8 across, squeezed to {} of its height", left < 0.4 ? 8.0 : 2.0, left), flat, left > 0.4);
    }
    Extreme cuboid = squeeze(3, 4, 4, 0.1, MaterialLaw::neo_hookean, integrator);
    add("block 4 m x 1 m x 4 m, 4 across, squeezed to 0.1 of its height", cuboid);
    add("block 2 m x 1 m, 8 across, of St Venant and Kirchhoff, squeezed to 0.1", squeeze(2, 8, 2, 0.1, MaterialLaw::st_venant_kirchhoff, integrator), true);
    add("free block, 10 across, under a pressure all round, to J = 0.1", compress(10, integrator), true);
    add("plate of E = 3.5 MPa under 30 MPa on one face", violent(2, false, integrator), true);
    add("plate of E = 3.5 MPa under 30 MPa on one face", violent(3, false, integrator));
    add("plate whose upper half is hit at 200 m/s, twice the wave speed", violent(2, true, integrator), true);
  }
  return all;
}

}  // namespace tern::structure::testing
