#pragma once
// Fluid that is enclosed all round, by walls or by its own periodic images: nothing ties its pressure to a value, and its
// pressure equation has a solution only if no net volume flows in. Each connected such pool is treated by itself.
//
// If all fluid is sealed and no wall moves, the fluid fills its enclosure once and for all. What is missing of a support
// later is disorder, not a free surface: taken for one it would tie the pressure to zero in the middle of the fluid, and
// flows that stretch their particles (stagnation points) blow up.

#include <cstdint>
#include <vector>

#include "fluid/neighbours.hpp"

namespace tern::fluid {

/// What sealed fluid was asked for and cannot do, over the run so far.
struct SealedAccount {
  bool any = false;         ///< there was sealed fluid
  double largest_flux = 0;  ///< net sum V (div u* - s) taken out of the source of a pool, largest by size [m^D/s]
  double volume_error = 0;  ///< volume that faces have pushed into a pool over its volume, largest by size [-]
  bool warned = false;
};

/// The pools of one step.
struct SealedPools {
  std::vector<int> pool;           ///< of each row; -1: not in a sealed pool
  std::vector<int> size;           ///< rows of each pool
  std::vector<double> pushed;      ///< volume error by label of the particle; a label keeps it while pools join and part
  std::vector<double> sum;         ///< scratch, one per pool
  std::vector<int> queue;          ///< scratch
  std::vector<std::uint8_t> tied;  ///< scratch

  bool any() const { return !size.empty(); }
  /// sum[k] = sum of the values over pool k.
  void add_up(const std::vector<double>& values);
  /// Takes the mean over each pool out of the values of its rows.
  void subtract_means(std::vector<double>& values);
};

/// Finds the connected sets of unknowns none of which has c_i > 0. Costs little where all is tied: ties spread along the
/// order of the particles, back and forwards, and only what they do not reach is searched.
template <int D>
void find_sealed_pools(const Neighbours<D>& neighbours, const std::vector<std::uint8_t>& active, const std::vector<float>& constant,
                       SealedPools& pools);

}  // namespace tern::fluid
