#include "coupler/interface_force.hpp"

#include <cmath>

#include "base/parallel.hpp"
#include "coupler/interface_condition.hpp"
#include "coupler/schemes/scheme.hpp"
#include "sph/contact.hpp"

namespace tern::coupler {

template <int D>
void add_pressure(const Setup<D>& setup, const InterfacePressure<D>& pressure, Workspace<D>& window, Evaluations& evaluations) {
  const auto& pairs = window.pairs;
  evaluations.pressure += static_cast<long>(pairs.all_pairs().size());
  const Vector<D> gravity = [&] {
    Vector<D> g;
    for (int c = 0; c < D; ++c) g[c] = setup.gravity[c](window.begin);
    return g;
  }();
  // Pressure of every particle, carried to the surface by the weight of the fluid between. Behind a wall it goes on as before
  // it: an image carries what its particle does.
  std::vector<double>& carried = window.carried;
  const PairRange<D> all = pairs.all_pairs();
  carried.resize(all.size());
  parallel_for(static_cast<std::ptrdiff_t>(all.size()), [&](std::ptrdiff_t m) {
    const int i = all.particle(m);
    const Vector<D> d = window.surface.position[all.point(m)] - window.particles.position[i];
    carried[m] = pressure.pressure[i] + setup.density * gravity.dot(d);
  });
  if (setup.scheme.pair_pressures)
    setup.scheme.pair_pressures({setup.kernel, all, window.surface, window.particles, pairs.weighed_area()}, carried);
  std::size_t m = 0;
  std::vector<Vector<D>>& on_particles = window.particle_force.force;
  for (const auto& pair : pairs.pairs()) add_pair_force(pair, Vector<D>(carried[m++] * pair.b), window.load, on_particles);
  for (const auto& pair : pairs.back_facing_pairs()) add_pair_force(pair, Vector<D>(carried[m++] * pair.b), window.load, on_particles);
  // What images take back, the fluid has from the mirror that its walls are.
  for (const auto& pair : pairs.image_pairs()) window.load.force[pair.point] += carried[m++] * pair.b;
}

template <int D>
void settle_contacts(const Setup<D>& setup, const InterfacePressure<D>& pressure, Workspace<D>& window) {
  const bool iterates = setup.iterates;
  const Surface<D>& surface = window.surface;
  const InterfaceParticles<D>& particles = window.particles;
  std::vector<Vector<D>>& on_particles = window.particle_force.force;
  if (iterates) window.contact.force.assign(window.load.force.size(), Vector<D>::Zero());
  if (setup.contact_distance == 0) return;
  LumpMotion<D> answered(window.answer.lumps, window.answer.mass, window.duration);  // to what exceeds the assumed load
  if (iterates)
    for (std::size_t k = 0; k < surface.position.size(); ++k) answered.push(k, window.load.force[k] - window.assumed_load.force[k]);
  window.pairs.for_each_standing([&](const InterfacePair<D>& pair) {
    const int i = pair.particle, k = pair.point;
    const Vector<D>& n = surface.normal[k];
    const Vector<D> velocity = pressure.velocity[i] + (window.duration / particles.mass[i]) * on_particles[i];
    const double permitted =
        permitted_approach((particles.position[i] - surface.position[k]).dot(n), setup.contact_distance, window.duration);
    const double approach = (surface.velocity[k] - velocity).dot(n) - permitted;
    // Where the coupling is explicit the face gives way as the mass does that lies behind the particle.
    double behind = window.responding_mass[k] * std::pow(particles.volume[i], (D - 1.0) / D), expected = approach;
    if (iterates) {
      // As the pressure equation has it, to what exceeds the assumed load. When both sides agree nothing does, and the
      // particle has the velocity of the face, be that held by its stiffness or free.
      behind = answered.mass(k);
      expected += answered.velocity(k).dot(n);
    }
    if (expected <= 0) return;
    const double mass = particles.mass[i] * behind / (particles.mass[i] + behind);
    const Vector<D> force = -(mass * expected / window.duration) * n;
    add_pair_force(pair, force, window.load, on_particles);
    if (iterates) {
      window.contact.force[k] += force;
      answered.push(k, force);
    }
    window.audit.contact_dissipation += 0.5 * mass * expected * (approach + 2 * permitted);
    ++window.audit.contacts;
  });
}

template void add_pressure<2>(const Setup<2>&, const InterfacePressure<2>&, Workspace<2>&, Evaluations&);
template void add_pressure<3>(const Setup<3>&, const InterfacePressure<3>&, Workspace<3>&, Evaluations&);
template void settle_contacts<2>(const Setup<2>&, const InterfacePressure<2>&, Workspace<2>&);
template void settle_contacts<3>(const Setup<3>&, const InterfacePressure<3>&, Workspace<3>&);

}  // namespace tern::coupler
