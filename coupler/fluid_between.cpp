#include "coupler/fluid_between.hpp"

#include <algorithm>

#include "coupler/schemes/scheme.hpp"

namespace tern::coupler {
namespace {

/// Of the mass of the fluid between: how much of it is in the answer of which the fluid is told, and how much there may be of it over the
/// mass that answers (fluid_between.hpp).
constexpr double share_told = 0.75, largest_share = 0.5;

/// Calls visit(pair, its number) for the pairs whose fluid goes on to the face. Past a corner it goes on along the face.
template <int D, class Visit>
void for_pairs_before_faces(const InterfacePairs<D>& pairs, Visit&& visit) {
  const std::size_t seen = pairs.pairs().size(), own = seen + pairs.back_facing_pairs().size();
  for (std::size_t m = 0; m < pairs.all_pairs().size(); ++m)
    if (m < seen || m >= own) visit(pairs.all_pairs()[m], m);
}

/// between.lead of every particle from between.acceleration of every point.
template <int D>
void find_lead(const Setup<D>& setup, Workspace<D>& window) {
  FluidBetween<D>& between = window.between;
  between.lead.assign(between.distance.size(), Vector<D>::Zero());
  for_pairs_before_faces(window.pairs, [&](const InterfacePair<D>& pair, std::size_t) {
    const double a = between.acceleration[pair.point];
    if (between.mass[pair.point] > 0) between.lead[pair.particle] -= a * pair.b;
  });
  for (std::size_t i = 0; i < between.lead.size(); ++i)
    between.lead[i] *= between.distance[i] > 0 ? setup.density * between.distance[i] / between.seen[i] : 0.0;
}

/// between.mass of every point from between.distance of every particle.
template <int D>
void find_mass(const Setup<D>& setup, Workspace<D>& window) {
  const Surface<D>& surface = window.surface;
  FluidBetween<D>& between = window.between;
  between.mass.assign(surface.position.size(), 0);
  for_pairs_before_faces(window.pairs, [&](const InterfacePair<D>& pair, std::size_t) {
    between.mass[pair.point] -= setup.density * between.distance[pair.particle] * pair.b.dot(surface.normal[pair.point]);
  });
  for (std::size_t k = 0; k < between.mass.size(); ++k) {
    const bool counts = between.filled[k] > least_share * surface.area[k];
    between.mass[k] = counts ? std::max(window.share[k] * surface.area[k] / between.filled[k] * between.mass[k], 0.0) : 0;
  }
}

/// Brings between.distance to where no lump has more than its share of its mass between it and the particles.
template <int D>
void lighten(const Setup<D>& setup, Workspace<D>& window) {
  FluidBetween<D>& between = window.between;
  const SurfaceLumps& lumps = window.answer.lumps;
  std::vector<double>& part = between.part;  // of each lump that may be, first its mass between
  part.assign(lumps.count, 0);
  for (std::size_t k = 0; k < between.mass.size(); ++k)
    for (std::size_t s = k * lumps.per_point; s < (k + 1) * lumps.per_point; ++s) part[lumps.lump[s]] += lumps.share[s] * between.mass[k];
  for (std::size_t a = 0; a < part.size(); ++a) {
    const double answers = setup.learns ? window.answer.mass[a] : window.responding_mass[a] * window.surface.area[a];
    part[a] = std::min(part[a] > 0 ? largest_share * answers / part[a] : 1, 1.0);
  }
  std::vector<double>& kept = between.carried;  // of what each point sees; carry_trial_by_inertia() sets it anew
  for (std::size_t k = 0; k < kept.size(); ++k) {
    kept[k] = 0;
    for (std::size_t s = k * lumps.per_point; s < (k + 1) * lumps.per_point; ++s) kept[k] += lumps.share[s] * part[lumps.lump[s]];
  }
  std::vector<double>& of_particle = between.kept;
  of_particle.assign(between.distance.size(), 0);
  for_pairs_before_faces(window.pairs, [&](const InterfacePair<D>& pair, std::size_t) {
    if (between.filled[pair.point] > least_share * window.surface.area[pair.point])
      of_particle[pair.particle] -= kept[pair.point] * pair.b.dot(window.surface.normal[pair.point]);
  });
  for (std::size_t i = 0; i < of_particle.size(); ++i)
    if (between.distance[i] > 0) between.distance[i] *= std::clamp(of_particle[i] / between.seen[i], 0.0, 1.0);
}

/// The answer of the surface, with a share of the mass of the fluid between.
template <int D>
SurfaceAnswer with_fluid_between(const Workspace<D>& window, double share) {
  SurfaceAnswer answer = window.answer;
  const SurfaceLumps& lumps = answer.lumps;
  for (std::size_t k = 0; k < window.between.mass.size(); ++k)
    for (std::size_t s = k * lumps.per_point; s < (k + 1) * lumps.per_point; ++s)
      answer.mass[lumps.lump[s]] += share * lumps.share[s] * window.between.mass[k];
  return answer;
}

}  // namespace

template <int D>
void find_fluid_between(const Setup<D>& setup, const State<D>& state, Workspace<D>& window) {
  const Surface<D>& surface = window.surface;
  FluidBetween<D>& between = window.between;
  between.filled.assign(surface.position.size(), 0);
  between.mass.assign(surface.position.size(), 0);
  between.carried.assign(surface.position.size(), 0);
  between.seen.assign(window.particles.id.size(), 0);
  between.distance.assign(window.particles.id.size(), 0);
  for (const auto& pair : window.pairs.all_pairs()) between.filled[pair.point] -= pair.b.dot(surface.normal[pair.point]);
  if (state.surface_velocity.empty() || setup.scheme.pair_pressures) return;
  for_pairs_before_faces(window.pairs, [&](const InterfacePair<D>& pair, std::size_t) {
    if (between.filled[pair.point] <= least_share * surface.area[pair.point]) return;
    if (!setup.learns && setup.is_light[setup.properties.body[pair.point]]) return;
    const Vector<D>& n = surface.normal[pair.point];
    between.seen[pair.particle] -= pair.b.dot(n);
    between.distance[pair.particle] -= pair.b.dot(n) * pair.offset.dot(n);
  });
  // At the end of the kernel w~ has both signs.
  for (std::size_t i = 0; i < between.seen.size(); ++i) {
    const bool before = between.seen[i] > least_share * window.particles.volume[i] / setup.spacing;
    between.distance[i] = before ? std::max(between.distance[i] / between.seen[i], 0.0) : 0;
  }
  find_mass(setup, window);
  lighten(setup, window);
  find_mass(setup, window);
}

template <int D>
void carry_trial_by_inertia(const Setup<D>& setup, const State<D>& state, Workspace<D>& window) {
  const Surface<D>& surface = window.surface;
  FluidBetween<D>& between = window.between;
  between.acceleration.assign(surface.position.size(), 0);
  for (std::size_t k = 0; k < surface.position.size(); ++k)
    if (between.mass[k] > 0)
      between.acceleration[k] = (surface.velocity[k] - state.surface_velocity[k]).dot(surface.normal[k]) / window.duration;
  find_lead(setup, window);
  between.carried.assign(surface.position.size(), 0);
  for_pairs_before_faces(window.pairs, [&](const InterfacePair<D>& pair, std::size_t) {
    const std::size_t k = static_cast<std::size_t>(pair.point);
    const Vector<D>& n = surface.normal[k];
    if (between.mass[k] > 0) between.carried[k] -= between.lead[pair.particle].dot(n) * pair.b.dot(n) / between.filled[k];
  });
}

template <int D>
void answer_with_fluid_between(Workspace<D>& window) {
  window.between.answer = with_fluid_between(window, 1.0);
  window.between.told = with_fluid_between(window, share_told);
}

template <int D>
void carry_by_inertia(const Setup<D>& setup, Workspace<D>& window, std::vector<double>& carried) {
  const Surface<D>& surface = window.surface;
  FluidBetween<D>& between = window.between;
  between.beyond.clear();
  if (std::none_of(between.mass.begin(), between.mass.end(), [](double mass) { return mass > 0; })) return;
  const std::size_t points = surface.position.size();
  between.pressure.assign(points, 0);
  for (std::size_t m = 0; m < carried.size(); ++m) {
    const InterfacePair<D>& pair = window.pairs.all_pairs()[m];
    between.pressure[pair.point] -= carried[m] * pair.b.dot(surface.normal[pair.point]);
  }
  for (std::size_t k = 0; k < points; ++k) between.pressure[k] = between.mass[k] > 0 ? between.pressure[k] / between.filled[k] : 0;
  if (setup.iterates) {
    // In excess of the assumed load the pressure moves the face together with the fluid between.
    LumpMotion<D> moves(between.answer.lumps, between.answer.mass, window.duration);
    LumpMotion<D> told(between.told.lumps, between.told.mass, window.duration);
    for (std::size_t k = 0; k < points; ++k) {
      if (!(between.mass[k] > 0)) continue;
      const Vector<D> loaded = -window.share[k] * surface.area[k] * surface.normal[k];
      moves.push(k, (between.pressure[k] + between.carried[k]) * loaded - carried_by_trial(window, k));
      told.push(k, (between.pressure[k] - window.condition.reference_pressure[k]) * loaded);
    }
    between.beyond.assign(points, Vector<D>::Zero());
    for (std::size_t k = 0; k < points; ++k) {
      if (!(between.mass[k] > 0)) continue;
      between.acceleration[k] += moves.velocity(k).dot(surface.normal[k]) / window.duration;
      between.beyond[k] = told.velocity(k) - moves.velocity(k);
    }
    find_lead(setup, window);
  }
  for_pairs_before_faces(window.pairs, [&](const InterfacePair<D>& pair, std::size_t m) {
    if (between.mass[pair.point] > 0) carried[m] += between.lead[pair.particle].dot(surface.normal[pair.point]);
  });
}

#define TERN_INSTANTIATE(D)                                                                 \
  template void find_fluid_between<D>(const Setup<D>&, const State<D>&, Workspace<D>&);     \
  template void carry_trial_by_inertia<D>(const Setup<D>&, const State<D>&, Workspace<D>&); \
  template void answer_with_fluid_between<D>(Workspace<D>&);                                \
  template void carry_by_inertia<D>(const Setup<D>&, Workspace<D>&, std::vector<double>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::coupler
