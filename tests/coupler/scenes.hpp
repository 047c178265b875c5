#pragma once
// Interfaces the coupler tests share, built by hand: flat plates of surface points, lattices of fluid over them.

#include <cmath>
#include <random>

#include "coupler/coupling_step.hpp"

namespace tern::coupler::testing {

inline VectorExpression constant(double x, double y = 0, double z = 0) {
  return {Expression(x), Expression(y), Expression(z)};
}

inline Shape box(std::array<double, 3> min, std::array<double, 3> max) {
  Shape shape;
  shape.min = min;
  shape.max = max;
  return shape;
}

/// Water and one elastic body of density 1200 kg/m^3, pressure forces only, no gravity.
inline Case scene(int dimension, double spacing, double smoothing_length_ratio = 1.5) {
  Case c;
  c.dimension = dimension;
  c.domain_min = {-1e3, -1e3, -1e3};
  c.domain_max = {1e3, 1e3, 1e3};
  c.fluid.emplace();
  c.fluid->density = 1000;
  c.fluid->spacing = spacing;
  c.fluid->numerics.smoothing_length_ratio = smoothing_length_ratio;
  c.structure.emplace();
  StructureBody body;
  body.name = "plate";
  body.density = 1200;
  body.shape = box({100, 100, 100}, {101, 101, 101});  // out of the way: only its density is used
  c.structure->bodies.push_back(body);
  c.coupling.riemann_limiter = 0;
  return c;
}

/// One body everywhere; `mass` is the section mass, with no bound by layer or wave speed.
inline SurfaceProperties properties(std::size_t points, double mass = 5) {
  SurfaceProperties p;
  p.body.assign(points, 0);
  p.section_mass.assign(points, mass);
  p.impedance.assign(points, 1e30);
  p.least_mass.assign(points, 0);
  return p;
}

template <int D>
void add_point(Surface<D>& surface, const Vector<D>& x, const Vector<D>& normal, double area,
               const Vector<D>& velocity = Vector<D>::Zero()) {
  surface.position.push_back(x);
  surface.normal.push_back(normal);
  surface.area.push_back(area);
  surface.velocity.push_back(velocity);
}

template <int D>
void add_particle(Band<D>& band, const Vector<D>& x, double spacing, const Vector<D>& velocity = Vector<D>::Zero(),
                  double density = 1000) {
  band.id.push_back(static_cast<std::uint32_t>(band.id.size()));
  band.position.push_back(x);
  band.velocity.push_back(velocity);
  band.volume.push_back(std::pow(spacing, D));
  band.mass.push_back(density * band.volume.back());
  band.divergence.push_back(0);
}

/// Calls visit(x) for every lattice point with |x|, |z| < half in the plane y = height.
template <int D, class Visit>
void for_lattice_plane(double half, double height, double spacing, Visit&& visit) {
  const int n = static_cast<int>(std::lround(2 * half / spacing));
  for (int k = 0; k < (D == 3 ? n : 1); ++k)
    for (int i = 0; i < n; ++i) {
      Vector<D> x;
      x[0] = (i + 0.5) * spacing - half;
      x[1] = height;
      if constexpr (D == 3) x[2] = (k + 0.5) * spacing - half;
      visit(x);
    }
}

/// Square plate in the plane y = 0 with points on both faces, its top at y = 0.
template <int D>
Surface<D> flat_plate(double half, double thickness, double point_spacing) {
  Surface<D> surface;
  const Vector<D> up = Vector<D>::Unit(1);
  const double area = std::pow(point_spacing, D - 1);
  for_lattice_plane<D>(half, 0, point_spacing, [&](const Vector<D>& x) { add_point<D>(surface, x, up, area); });
  for_lattice_plane<D>(half, -thickness, point_spacing, [&](const Vector<D>& x) { add_point<D>(surface, x, -up, area); });
  return surface;
}

/// Layers of fluid particles above y = 0 and, with `below`, under y = -thickness.
template <int D>
Band<D> fluid_layers(double half, int layers, double spacing, bool below = false, double thickness = 0) {
  Band<D> band;
  for (int l = 0; l < layers; ++l) {
    const double height = (l + 0.5) * spacing;
    for_lattice_plane<D>(half, height, spacing, [&](const Vector<D>& x) { add_particle<D>(band, x, spacing); });
    if (below)
      for_lattice_plane<D>(half, -thickness - height, spacing, [&](const Vector<D>& x) { add_particle<D>(band, x, spacing); });
  }
  return band;
}

/// Band pressure from a function of the position; velocities as in the band.
template <int D, class Function>
BandPressure<D> pressure_field(const Band<D>& band, Function&& pressure) {
  BandPressure<D> result;
  for (const auto& x : band.position) result.pressure.push_back(pressure(x));
  result.velocity = band.velocity;
  return result;
}

/// Force per area on the middle of the face (|x|, |z| < half) whose normal is `side` times e_y.
template <int D>
Vector<D> mean_traction(const Surface<D>& surface, const SurfaceLoad<D>& load, double half, double side) {
  Vector<D> force = Vector<D>::Zero();
  double area = 0;
  for (std::size_t k = 0; k < surface.position.size(); ++k) {
    const Vector<D>& x = surface.position[k];
    if (surface.normal[k][1] * side < 0 || std::abs(x[0]) > half || (D == 3 && std::abs(x[D - 1]) > half)) continue;
    force += load.force[k];
    area += surface.area[k];
  }
  return force / area;
}

}  // namespace tern::coupler::testing
