#include "fluid/motion/velocity_gradient.hpp"

#include <numbers>

#include "base/parallel.hpp"

namespace tern::fluid {

template <int D>
void compute_velocity_gradient(const Period<D>& space, const Neighbours<D>& neighbours, const Corrections<D>& correction,
                               const std::vector<ParticleClass>& particle_class, const std::vector<Vector<D>>& position,
                               const std::vector<Vector<D>>& velocity, PackedVelocities<D>& packed) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(neighbours.rows());
  pack<D>(position, velocity, packed.motion);
  packed.half_gradient.resize(position.size());
  packed.strain_rate.resize(position.size());
  space.specialise([&](auto periodic) {
    const PackedPeriod<decltype(periodic)::value, D> period(space);
    parallel_for(n, [&](std::ptrdiff_t i) {
      std::array<Packed<D>, D>& half = packed.half_gradient[i];
      half.fill(Packed<D>::Zero());
      packed.strain_rate[i] = 0;
      if (!particle_class[i].has(ParticleClass::corrected_gradient)) return;
      const Matrix<D> gradient = velocity_gradient_sum(neighbours, period, packed.motion, i) * correction.fluid[i];
      for (int b = 0; b < D; ++b)
        for (int a = 0; a < D; ++a) half[b][a] = 0.5 * gradient(a, b);
      packed.strain_rate[i] = (gradient + gradient.transpose()).norm() / std::numbers::sqrt2;
    });
  });
}

template void compute_velocity_gradient<2>(const Period<2>&, const Neighbours<2>&, const Corrections<2>&, const std::vector<ParticleClass>&,
                                           const std::vector<Vector<2>>&, const std::vector<Vector<2>>&, PackedVelocities<2>&);
template void compute_velocity_gradient<3>(const Period<3>&, const Neighbours<3>&, const Corrections<3>&, const std::vector<ParticleClass>&,
                                           const std::vector<Vector<3>>&, const std::vector<Vector<3>>&, PackedVelocities<3>&);

}  // namespace tern::fluid
