// Energies: kinetic sum m v^2/2, strain sum V_0 W(F, K) (first_piola_kirchhoff.cpp); work and dissipation are summed up by the time step.

#include "structure/energy.hpp"

#include "structure/shell/shell_body.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {

template <int D>
double energy_density(const Body& body, const Workspace<D>& work, std::int32_t row) {
  const Material& m = body.material;
  Matrix<D> h;
  for (int a = 0; a < D; ++a)
    for (int b = 0; b < D; ++b) h(a, b) = work.displacement_gradient[a][b][row];
  const Matrix<D> f = Matrix<D>::Identity() + h;
  double density = std::visit([&](const auto& law) { return law.template energy_density<D>(h, f); }, m.law);
  const Matrix<D> inverse = f.inverse();
  for (int direction = 0; direction < D; ++direction) {
    Matrix<D> k;
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b) k(a, b) = work.curvature[a][curvature_index<D>(direction, b)][row];
    const Matrix<D> b = k * inverse;
    const Matrix<D> strain = 0.5 * (b + b.transpose());
    density += body.spacing * body.spacing / 12 * m.strain_energy<D>(strain);
  }
  return density;
}

template <int D>
Energies energies_of(const Reference<D>& reference, const State<D>& state, const Workspace<D>& work) {
  Energies e;
  for (std::size_t p = 0; p < reference.particle_row.size(); ++p) {
    const auto row = reference.particle_row[p];
    if (reference.inverse_mass[row] == 0) continue;
    const Body& body = reference.bodies[reference.particle_body[p]];
    double squared = 0;
    for (int a = 0; a < D; ++a) squared += state.velocity[a][row] * state.velocity[a][row];
    e.kinetic += 0.5 * reference.mass[row] * squared;
    if (body.shell < 0) e.strain += reference.volume[row] * energy_density<D>(body, work, row);
  }
  e.strain += shell_strain_energy(reference, work);
  for (const Lanes& loss : state.diffusion_loss) e.diffusion += sum(loss);
  for (const Lanes& loss : state.damping_loss) e.damping += sum(loss);
  e.potential = -state.gravity_work;
  e.interface_work = state.interface_work;
  e.load_work = state.load_work;
  e.clamp_work = state.clamp_work;
  return e;
}

template <int D>
Momentum momentum_of(const Reference<D>& reference, const State<D>& state) {
  Momentum momentum;
  for (const auto row : reference.particle_row) {
    if (reference.inverse_mass[row] == 0) continue;
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

template double energy_density<2>(const Body&, const Workspace<2>&, std::int32_t);
template double energy_density<3>(const Body&, const Workspace<3>&, std::int32_t);
template Energies energies_of<2>(const Reference<2>&, const State<2>&, const Workspace<2>&);
template Energies energies_of<3>(const Reference<3>&, const State<3>&, const Workspace<3>&);
template Momentum momentum_of<2>(const Reference<2>&, const State<2>&);
template Momentum momentum_of<3>(const Reference<3>&, const State<3>&);

}  // namespace tern::structure
