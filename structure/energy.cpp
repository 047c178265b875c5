// Energies: kinetic sum m v^2/2, strain sum V_0 Psi(F); work and dissipation are summed up by the time step.

#include "structure/energy.hpp"

#include <cmath>

#include "structure/time_step.hpp"

namespace tern::structure {

template <int D>
Energies energies_of(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work) {
  Energies e;
  for (std::size_t p = 0; p < reference.particle_row.size(); ++p) {
    const auto row = reference.particle_row[p];
    const Body& body = reference.bodies[reference.particle_body[p]];
    double squared = 0;
    for (int a = 0; a < D; ++a) squared += state.velocity[a][row] * state.velocity[a][row];
    e.kinetic += 0.5 * reference.mass[row] * squared;

    // tr F^T F - D = 2 tr H + H:H, which does not lose the digits of a small strain.
    double trace = 0;
    for (int a = 0; a < D; ++a) {
      trace += 2 * work.displacement_gradient[a][a][row];
      for (int b = 0; b < D; ++b) {
        const double h = work.displacement_gradient[a][b][row];
        trace += h * h;
      }
    }
    const double log_j = std::log(deformation_gradient_of<D>(work, row).determinant());
    const Material& m = body.material;
    e.strain += std::pow(body.spacing, D) * (0.5 * m.mu * trace - m.mu * log_j + 0.5 * m.lambda * log_j * log_j);
  }
  for (const Lanes& loss : state.diffusion_loss) e.diffusion += sum(loss);
  for (const Lanes& stored : state.penalty_store) e.penalty += sum(stored);
  e.potential = -state.gravity_work;
  e.interface_work = state.interface_work;
  return e;
}

template <int D>
Momentum momentum_of(const Reference<D>& reference, const State<D>& state) {
  Momentum momentum;
  for (const auto row : reference.particle_row) {
    std::array<double, 3> x{}, q{};
    for (int a = 0; a < D; ++a) {
      x[a] = reference.position[a][row] + state.displacement[a][row];
      q[a] = reference.mass[row] * state.velocity[a][row];
    }
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      momentum.linear[a] += q[a];
      momentum.angular[a] += x[b] * q[c] - x[c] * q[b];
    }
  }
  return momentum;
}

template Energies energies_of<2>(const Reference<2>&, const State<2>&, const Workspace<2>&);
template Energies energies_of<3>(const Reference<3>&, const State<3>&, const Workspace<3>&);
template Momentum momentum_of<2>(const Reference<2>&, const State<2>&);
template Momentum momentum_of<3>(const Reference<3>&, const State<3>&);

}  // namespace tern::structure
