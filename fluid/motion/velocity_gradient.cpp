#include "fluid/motion/velocity_gradient.hpp"

#include <numbers>

#include "base/parallel.hpp"

namespace tern::fluid {

template <int D>
void compute_velocity_gradient(const Period<D>& space, const Neighbours<D>& neighbours, const Corrections<D>& correction,
                               const std::vector<ParticleClass>& particle_class, PackedVelocities<D>& packed) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(neighbours.rows()), all = static_cast<std::ptrdiff_t>(particle_class.size());
  for (auto& values : packed.half_stretch) values.resize(all);
  for (auto* parts : {&packed.shear, &packed.spin})
    for (auto& values : *parts) values.resize(all);
  for (auto* rates : {&packed.strain_rate, &packed.gradient_size}) rates->resize(all);
  space.specialise([&](auto periodic) {
    const LanePeriod<decltype(periodic)::value, D> period(space);
    parallel_for(n, [&](std::ptrdiff_t i) {
      Matrix<D> gradient = Matrix<D>::Zero();
      const bool has_gradient = particle_class[i].has(ParticleClass::corrected_gradient);
      if (has_gradient)
        gradient = velocity_gradient_sum<decltype(periodic)::value, D>(neighbours, period, packed.velocity, i) * correction.fluid[i];
      for (int a = 0; a < D; ++a) packed.half_stretch[a][i] = 0.5 * gradient(a, a);
      for_axis_pairs<D>([&](int a, int b, int place) {
        packed.shear[place][i] = 0.5 * (gradient(a, b) + gradient(b, a));
        packed.spin[place][i] = 0.5 * (gradient(a, b) - gradient(b, a));
      });
      packed.strain_rate[i] =
          has_gradient ? (gradient + gradient.transpose()).norm() / std::numbers::sqrt2 : PackedVelocities<D>::without_gradient;
      packed.gradient_size[i] = gradient.norm();
    });
  });
}

template void compute_velocity_gradient<2>(const Period<2>&, const Neighbours<2>&, const Corrections<2>&, const std::vector<ParticleClass>&,
                                           PackedVelocities<2>&);
template void compute_velocity_gradient<3>(const Period<3>&, const Neighbours<3>&, const Corrections<3>&, const std::vector<ParticleClass>&,
                                           PackedVelocities<3>&);

}  // namespace tern::fluid
