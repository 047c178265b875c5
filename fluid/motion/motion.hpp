#pragma once
// Position and velocity of a particle side by side, as the sums over pairs read them: one cache line a neighbour in 2D, and
// whole vector registers to compute with.

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "fluid/period.hpp"

namespace tern::fluid {

/// A vector in a register; in 3D with a fourth component that is zero.
template <int D>
using Packed = Eigen::Array<double, D == 2 ? 2 : 4, 1>;

/// Does not reach over the end of a cache line.
template <int D>
struct alignas(D == 2 ? 32 : 64) Motion {
  Packed<D> position, velocity;
};

template <int D>
void pack(const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& velocity, std::vector<Motion<D>>& motion) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(position.size());
  motion.resize(n);
  parallel_for(n, [&](std::ptrdiff_t i) {
    motion[i] = {Packed<D>::Zero(), Packed<D>::Zero()};
    for (int c = 0; c < D; ++c) motion[i].position[c] = position[i][c], motion[i].velocity[c] = velocity[i][c];
  });
}

/// Vectors between packed positions, as Period::between().
template <bool periodic, int D>
class PackedPeriod {
 public:
  explicit PackedPeriod(const Period<D>& period) : length_(Packed<D>::Zero()), inverse_length_(Packed<D>::Zero()) {
    for (int c = 0; c < D; ++c)
      if (period.repeats(c)) length_[c] = period.length(c), inverse_length_[c] = 1 / period.length(c);
  }

  Packed<D> between(const Packed<D>& from, const Packed<D>& to) const {
    Packed<D> d = to - from;
    if constexpr (periodic) d -= length_ * (d * inverse_length_).rint();
    return d;
  }

 private:
  Packed<D> length_, inverse_length_;
};

}  // namespace tern::fluid
