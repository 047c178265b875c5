// Target of the divergence at the middle of the window:
//   div u^{n+1} = q,     q_i = s_i + dt/2 tr(L_i L_i),     L = grad u^n
// s is the density source. The other term makes the step second order. Particles that keep their velocity change its divergence at the
// rate -tr(L L). So a velocity that is solenoidal at the middle of one window has the divergence -dt tr(L L) at the middle of the next,
// half of which is made by the end of its own window. With q = 0 the pressure would take all of it at once, and with it
// (k u)^2 dt/2 of every turning motion per unit of time. With this q the mean of the velocities before and after the pressure is
// solenoidal at the middle, and the pressure does no work on the fluid.
//
// The rate is taken from the gradient, and not measured as the change of div u from one window to the next: that one also holds what
// no smooth motion makes, a wall that comes into the support or water that hits water, and to answer it throws the water back.
//
// Beside a structure the term is 0: there the coupling decides which velocity the fluid meets.

#include "fluid/pressure/divergence_target.hpp"

#include "base/parallel.hpp"

namespace tern::fluid {

template <int D>
void set_divergence_target(double duration, const Neighbours<D>& neighbours, const BesideStructure& beside,
                           const PackedVelocities<D>& velocities, const std::vector<double>& density_source, std::vector<double>& target) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(neighbours.rows());
  target.resize(n);
  const auto source = [&](std::ptrdiff_t i) { return density_source.empty() ? 0 : density_source[i]; };
  parallel_for(n, [&](std::ptrdiff_t i) {
    double quarter = 0;  // of tr(L L)
    for (int a = 0; a < D; ++a) quarter += velocities.half_stretch[a][i] * velocities.half_stretch[a][i];
    for_axis_pairs<D>([&](int, int, int place) {
      const double shear = velocities.shear[place][i], spin = velocities.spin[place][i];
      quarter += 0.5 * (shear * shear - spin * spin);
    });
    target[i] = source(i) + 2 * duration * quarter;
  });
  for (int i : beside.list) target[i] = source(i);
}

template <int D>
void list_beside_structure(const Domain<D>& domain, std::size_t particles, const Neighbours<D>& neighbours,
                           const std::vector<int>& at_structure, BesideStructure& beside) {
  beside.list.clear();
  beside.listed.assign(particles, 0);
  for (int i : at_structure) {
    beside.listed[i] = 1;
    neighbours.for_each(i, [&](int j, float) { beside.listed[j] = 1; });
  }
  domain.particles().collect(beside.listed, [](std::uint8_t& own, std::uint8_t other) { own |= other; });
  for (std::size_t i = 0; i < neighbours.rows(); ++i)
    if (beside.listed[i]) beside.list.push_back(static_cast<int>(i));
}

template void list_beside_structure<2>(const Domain<2>&, std::size_t, const Neighbours<2>&, const std::vector<int>&, BesideStructure&);
template void list_beside_structure<3>(const Domain<3>&, std::size_t, const Neighbours<3>&, const std::vector<int>&, BesideStructure&);
template void set_divergence_target<2>(double, const Neighbours<2>&, const BesideStructure&, const PackedVelocities<2>&,
                                       const std::vector<double>&, std::vector<double>&);
template void set_divergence_target<3>(double, const Neighbours<3>&, const BesideStructure&, const PackedVelocities<3>&,
                                       const std::vector<double>&, std::vector<double>&);

}  // namespace tern::fluid
