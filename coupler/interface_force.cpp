#include "coupler/interface_force.hpp"

#include <cmath>
#include <optional>

#include "base/parallel.hpp"
#include "coupler/interface_condition.hpp"
#include "coupler/schemes/scheme.hpp"
#include "sph/contact.hpp"

namespace tern::coupler {

template <int D>
void add_pressure(const Setup<D>& setup, const InterfacePressure<D>& pressure, Workspace<D>& window, Evaluations& evaluations) {
  const auto& pairs = window.pairs;
  evaluations.pressure += static_cast<long>(pairs.all_pairs().size());
  Vector<D> weight;
  for (int c = 0; c < D; ++c) weight[c] = setup.density * setup.gravity[c](window.begin);
  const CarriedPressure<D> carried{pressure.pressure, window.particles, window.surface, weight};
  setup.scheme.weigh_pressures(setup.kernel, pairs, carried, window.point_pressures);
  const auto force_of = [&](const InterfacePair<D>& pair) {
    return Vector<D>(window.point_pressures(pair, carried(pair.particle, pair.point)) * pair.b);
  };
  // All pairs of a point push along its normal: it sums numbers.
  const PointPressures<D>& points = window.point_pressures;
  window.point_sums.reset(pairs.parts(), window.surface.position.size());
  pairs.for_parts([&](int part, std::ptrdiff_t first, std::ptrdiff_t last) {
    double* on_point = window.point_sums.start(part);
    for (std::ptrdiff_t i = first; i < last; ++i) {
      const PairRange<D> of_particle = pairs.pairs_of(i);
      const Vector<D> x = window.particles.position[i];
      const double p = pressure.pressure[i];
      Vector<D> sum = Vector<D>::Zero();
      for (const auto& pair : of_particle.kept()) {
        const PairPoint<D>& point = of_particle.point(pair);
        const Vector<D> way = point.position - x;
        double here = p + weight.dot(way);
        if (!points.gradient.empty()) here += points.gradient[pair.point].dot(way);
        const double force = points.share[pair.point] * here * pair.weight;
        on_point[pair.point] += force;
        sum += force * point.normal;
      }
      window.particle_force.force[i] -= sum;
    }
  });
  parallel_for(static_cast<std::ptrdiff_t>(window.load.force.size()),
               [&](std::ptrdiff_t k) { window.load.force[k] += window.point_sums.sum(k) * window.surface.normal[k]; });
  for (const auto& pair : pairs.back_facing_pairs()) add_pair_force(pair, force_of(pair), window.load, window.particle_force.force);
  // What images take back, the fluid has from the mirror that its walls are.
  window.image_force.clear();
  for (const auto& pair : pairs.image_pairs()) {
    window.image_force.push_back(force_of(pair));
    window.load.force[pair.point] += window.image_force.back();
  }
}

namespace {

/// What a pair approaches with more than it may [m/s].
struct Approach {
  double approach, permitted, expected;
};

/// `answered`: what the point has along its normal by the load that exceeds the assumed one [m/s].
template <int D>
Approach approach_of(const Setup<D>& setup, const InterfacePressure<D>& pressure, const Workspace<D>& window, const InterfacePair<D>& pair,
                     double answered) {
  const int i = pair.particle, k = pair.point;
  const Surface<D>& surface = window.surface;
  const Vector<D>& n = surface.normal[k];
  const Vector<D> velocity = pressure.velocity[i] + (window.duration / window.particles.mass[i]) * window.particle_force.force[i];
  const double permitted =
      permitted_approach((window.particles.position[i] - surface.position[k]).dot(n), setup.contact_distance, window.duration);
  const double approach = (surface.velocity[k] - velocity).dot(n) - permitted;
  // Where windows are repeated the face gives way as the pressure equation has it, to what exceeds the assumed load. When both sides
  // agree nothing does, and the particle has the velocity of the face, be that held by its stiffness or free.
  return {approach, permitted, setup.iterates ? approach + answered : approach};
}

template <int D>
void add_contact(const InterfacePair<D>& pair, const Vector<D>& force, const Approach& met, bool iterates, Workspace<D>& window) {
  add_pair_force(pair, force, window.load, window.particle_force.force);
  if (iterates) window.contact.force[pair.point] += force;
  window.audit.contact_dissipation += 0.5 * window.duration * force.norm() * (met.approach + 2 * met.permitted);
  ++window.audit.contacts;
}

/// The assumed contacts, each to the particle that approaches its point the fastest.
template <int D>
void give_contacts(const Setup<D>& setup, const InterfacePressure<D>& pressure, Workspace<D>& window) {
  struct Fastest {
    Approach met;
    InterfacePair<D> pair;
  };
  std::vector<std::optional<Fastest>> fastest(window.surface.position.size());
  window.pairs.for_each_standing({}, [&](const InterfacePair<D>& pair) {
    if (window.assumed_contact.force[pair.point].isZero(0)) return;
    const Approach met = approach_of(setup, pressure, window, pair, 0);
    std::optional<Fastest>& best = fastest[pair.point];
    if (!best || met.approach > best->met.approach) best = Fastest{met, pair};
  });
  for (const std::optional<Fastest>& contact : fastest)
    if (contact) add_contact(contact->pair, window.assumed_contact.force[contact->pair.point], contact->met, true, window);
}

}  // namespace

template <int D>
void settle_contacts(const Setup<D>& setup, const InterfacePressure<D>& pressure, Workspace<D>& window) {
  const bool iterates = setup.iterates;
  const Surface<D>& surface = window.surface;
  const InterfaceParticles<D>& particles = window.particles;
  if (iterates) window.contact.force.assign(window.load.force.size(), Vector<D>::Zero());
  if (setup.contact_distance == 0) return;
  if (window.contacts_are_given) return give_contacts(setup, pressure, window);
  LumpMotion<D> answered(window.answer.lumps, window.answer.mass, window.duration);  // to what exceeds the assumed load
  const auto answered_speed = [&](std::size_t k) { return answered.velocity(k).dot(surface.normal[k]); };
  std::vector<double>& speed = window.answered_speed;  // before the first contact
  speed.assign(surface.position.size(), 0);
  if (iterates) {
    for (std::size_t k = 0; k < speed.size(); ++k) answered.push(k, window.load.force[k] - window.assumed_load.force[k]);
    parallel_for(static_cast<std::ptrdiff_t>(speed.size()),
                 [&](std::ptrdiff_t k) { speed[k] = answered_speed(static_cast<std::size_t>(k)); });
  }
  // Contacts are settled one after the other, for each changes what the next ones find. Up to the first one nothing has changed.
  const auto first = window.pairs.first_standing(
      [&](const InterfacePair<D>& pair) { return approach_of(setup, pressure, window, pair, speed[pair.point]).expected > 0; });
  window.pairs.for_each_standing(first, [&](const InterfacePair<D>& pair) {
    const int k = pair.point;
    const Approach met = approach_of(setup, pressure, window, pair, iterates ? answered_speed(k) : 0);
    if (met.expected <= 0) return;
    // Where the coupling is explicit the face gives way as the mass does that lies behind the particle.
    const double behind =
        iterates ? answered.mass(k) : window.responding_mass[k] * std::pow(particles.volume[pair.particle], (D - 1.0) / D);
    const double mass = particles.mass[pair.particle] * behind / (particles.mass[pair.particle] + behind);
    const Vector<D> force = -(mass * met.expected / window.duration) * surface.normal[k];
    add_contact(pair, force, met, iterates, window);
    if (iterates) answered.push(k, force);
  });
}

template void add_pressure<2>(const Setup<2>&, const InterfacePressure<2>&, Workspace<2>&, Evaluations&);
template void add_pressure<3>(const Setup<3>&, const InterfacePressure<3>&, Workspace<3>&, Evaluations&);
template void settle_contacts<2>(const Setup<2>&, const InterfacePressure<2>&, Workspace<2>&);
template void settle_contacts<3>(const Setup<3>&, const InterfacePressure<3>&, Workspace<3>&);

}  // namespace tern::coupler
