#include "coupler/stability/added_mass.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "scene/mid_surface.hpp"

namespace tern::coupler {
namespace {

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
  const std::vector<double> depths = moved_depths<D>(scene, weight_of_fluid<D>(scene));
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
std::vector<double> moved_depths(const Case& scene, const FluidWeight& weight) {
  std::vector<double> depths;
  for (const StructureBody& body : scene.structure->bodies) depths.push_back(std::min(weight.least_extent, wave_length<D>(body)));
  return depths;
}

template <int D>
FluidWeight weight_of_fluid(const Case& scene) {
  FluidWeight weight;
  Bounds<D> water{Vector<D>::Constant(1e300), Vector<D>::Constant(-1e300)};
  const double spacing = scene.fluid->spacing;
  const Vector<D> half = Vector<D>::Constant(0.5 * spacing);
  for (const FluidBody& body : scene.fluid->bodies)
    for (const Vector<D>& x : fill_with_fluid<D>(body.shape, spacing)) {
      water.min = water.min.cwiseMin(x - half);
      water.max = water.max.cwiseMax(x + half);
      weight.volume += std::pow(spacing, D);
    }
  if (weight.volume == 0) return weight;
  weight.least_extent = (water.max - water.min).minCoeff();
  // The largest of the run: it may begin with none.
  constexpr int instants = 100;
  double gravity = 0;
  Vector<D> largest = Vector<D>::Zero();
  for (int n = 0; n <= instants; ++n) {
    Vector<D> g;
    for (int c = 0; c < D; ++c) g[c] = scene.gravity[c](scene.end_time * n / instants);
    if (g.norm() > gravity) gravity = g.norm(), largest = g;
  }
  if (gravity == 0) return weight;
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
template std::vector<double> moved_depths<2>(const Case&, const FluidWeight&);
template std::vector<double> moved_depths<3>(const Case&, const FluidWeight&);
template FluidWeight weight_of_fluid<2>(const Case&);
template FluidWeight weight_of_fluid<3>(const Case&);

}  // namespace tern::coupler
