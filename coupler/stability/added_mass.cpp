#include "coupler/stability/added_mass.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "scene/mid_surface.hpp"

namespace tern::coupler {
namespace {

/// Grows a box by the points of a lattice for which `counts` is true.
template <int D, class Counts>
void enclose(Bounds<D>& box, const LatticePoints<D>& lattice, double spacing, Counts&& counts) {
  const Vector<D> half = Vector<D>::Constant(0.5 * spacing);
  for (const Vector<D>& x : lattice) {
    if (!counts(x)) continue;
    box.min = box.min.cwiseMin(x - half);
    box.max = box.max.cwiseMax(x + half);
  }
}

template <int D>
Bounds<D> nothing() {
  return {Vector<D>::Constant(1e300), Vector<D>::Constant(-1e300)};
}

/// 1/k of the first bending mode [m].
template <int D>
double wave_length(const StructureBody& body) {
  return free_length<D>(body) / 1.875104;
}

}  // namespace

double section_mass(const SurfaceProperties& properties, std::size_t body) {
  std::vector<double> masses;
  for (std::size_t k = 0; k < properties.body.size(); ++k)
    if (properties.body[k] == body && properties.section_mass[k] < held_mass) masses.push_back(properties.section_mass[k]);
  if (masses.empty()) return 0;
  const auto middle = masses.begin() + static_cast<std::ptrdiff_t>(masses.size() / 2);
  std::nth_element(masses.begin(), middle, masses.end());
  return *middle;
}

template <int D>
AddedMass predict_added_mass(const Case& scene, const SurfaceProperties& properties) {
  const std::vector<double> depths = moved_depths<D>(scene);
  AddedMass largest;
  for (std::size_t b = 0; b < scene.structure->bodies.size(); ++b) {
    const StructureBody& body = scene.structure->bodies[b];
    const double mass = section_mass(properties, b);
    if (mass == 0) continue;
    AddedMass here{body.name, 0, depths[b], depths[b] < wave_length<D>(body)};
    here.ratio = scene.fluid->density * here.length / mass;
    if (here.ratio > largest.ratio) largest = here;
  }
  return largest;
}

template <int D>
std::vector<double> moved_depths(const Case& scene) {
  auto water = nothing<D>();
  for (const FluidBody& body : scene.fluid->bodies)
    enclose<D>(water, fill_with_fluid<D>(body.shape, scene.fluid->spacing), scene.fluid->spacing, [](const Vector<D>&) { return true; });
  const double extent = (water.max - water.min).minCoeff(), depth = extent > 0 ? extent : std::numeric_limits<double>::infinity();
  std::vector<double> depths;
  for (const StructureBody& body : scene.structure->bodies) depths.push_back(std::min(depth, wave_length<D>(body)));
  return depths;
}

template <int D>
FluidWeight weight_of_fluid(const Case& scene) {
  FluidWeight weight;
  auto water = nothing<D>();
  for (const FluidBody& body : scene.fluid->bodies)
    enclose<D>(water, fill_with_fluid<D>(body.shape, scene.fluid->spacing), scene.fluid->spacing, [&](const Vector<D>&) {
      weight.volume += std::pow(scene.fluid->spacing, D);
      return true;
    });
  // The largest of the run: it may begin with none.
  constexpr int instants = 100;
  double gravity = 0;
  Vector<D> largest = Vector<D>::Zero();
  for (int n = 0; n <= instants; ++n) {
    Vector<D> g;
    for (int c = 0; c < D; ++c) g[c] = scene.gravity[c](scene.end_time * n / instants);
    if (g.norm() > gravity) gravity = g.norm(), largest = g;
  }
  if (gravity == 0 || weight.volume == 0) return weight;
  for (int c = 0; c < D; ++c) weight.height += std::abs(largest[c]) / gravity * (water.max[c] - water.min[c]);
  weight.pressure = 0.5 * scene.fluid->density * gravity * weight.height;
  return weight;
}

std::string describe(const AddedMass& added_mass) {
  return fmt::format("m_a/m_s = {:.3g} for '{}' ({:.3g} m of fluid, {}; all exposed faces wet)", added_mass.ratio, added_mass.body,
                     added_mass.length, added_mass.by_depth ? "its least extent" : "1/k of the first bending mode");
}

template AddedMass predict_added_mass<2>(const Case&, const SurfaceProperties&);
template AddedMass predict_added_mass<3>(const Case&, const SurfaceProperties&);
template std::vector<double> moved_depths<2>(const Case&);
template std::vector<double> moved_depths<3>(const Case&);
template FluidWeight weight_of_fluid<2>(const Case&);
template FluidWeight weight_of_fluid<3>(const Case&);

}  // namespace tern::coupler
