#include "coupler/schemes/velocity_divergence_mitigation.hpp"

#include "base/error.hpp"
#include "coupler/state.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {
namespace {

/// Velocity divergence at the surface points, sum V_i (u_i - u_k) . grad w_ki over the fluid they see [1/s]. The section
/// behind a point moves with it and adds nothing.
template <int D>
std::vector<double> divergence_at_surface(const Kernel<D>& kernel, PairRange<D> pairs, const Surface<D>& surface,
                                          const InterfaceParticles<D>& particles) {
  std::vector<double> divergence(surface.position.size(), 0);
  for (const auto& pair : pairs) {
    const Vector<D>& d = pair.offset;
    divergence[pair.point] += particles.volume[pair.particle] * kernel.gradient_weight(d.norm()) *
                              d.dot(particles.velocity[pair.particle] - surface.velocity[pair.point]);
  }
  return divergence;
}

}  // namespace

template <int D>
void add_velocity_divergence_mitigation(const Setup<D>& setup, Workspace<D>& window, Evaluations& evaluations) {
  const CouplingCase& coupling = setup.coupling;
  if (!coupling.vem_coefficient) return;
  const InterfaceParticles<D>& particles = window.particles;
  if (particles.divergence.size() != particles.id.size())
    throw BadInput(
        "The fluid process sends no divergence of the velocity, which [coupling.vem] needs; leave that table out, or use "
        "a fluid that has it.");
  const auto& pairs = window.pairs.pairs();
  evaluations.vem += static_cast<long>(pairs.size());
  double fastest = 0;
  for (const auto& pair : pairs) fastest = std::max(fastest, particles.velocity[pair.particle].norm());
  const auto pressure_of = [&](double density, double divergence) {
    return -density * *coupling.vem_coefficient * setup.smoothing_length * fastest * divergence;
  };
  std::vector<double> surface_divergence;
  if (coupling.vem_form == VemForm::seed) surface_divergence = divergence_at_surface<D>(setup.kernel, pairs, window.surface, particles);
  for (const auto& pair : pairs) {
    const int i = pair.particle, k = pair.point;
    const double fluid = pressure_of(setup.density, particles.divergence[i]);
    const double structure =
        surface_divergence.empty() ? fluid : pressure_of(setup.body_density[setup.properties.body[k]], surface_divergence[k]);
    const MitigationPressure pressure = mitigation_pressure(coupling.vem_form, fluid, structure);
    if (pressure.on_fluid == 0 && pressure.on_structure == 0) continue;
    window.load.force[k] += pressure.on_structure * pair.b;
    window.condition.force[i] -= pressure.on_fluid * pair.b;
    window.audit.mitigation_dissipation -=
        window.duration * pair.b.dot(pressure.on_structure * window.surface.velocity[k] - pressure.on_fluid * particles.velocity[i]);
  }
}

template void add_velocity_divergence_mitigation<2>(const Setup<2>&, Workspace<2>&, Evaluations&);
template void add_velocity_divergence_mitigation<3>(const Setup<3>&, Workspace<3>&, Evaluations&);

}  // namespace tern::coupler
