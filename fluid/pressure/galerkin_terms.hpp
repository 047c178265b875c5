#pragma once
// The Galerkin product P^T A P of two grids, P multilinear: which entries of a row of the finer grid go where depends on the parities of
// its place alone.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fluid/pressure/grid_stencil.hpp"

namespace tern::fluid {

struct GalerkinTerm {
  std::uint8_t fine, parent, coarse;  ///< stencil entry of the finer row; corner of the parent; its stencil entry
  float weight;
};

template <int D>
class GalerkinTerms {
 public:
  /// `halved`: in which directions the coarser grid has every second place. Even ones have themselves for a parent.
  explicit GalerkinTerms(const std::array<bool, D>& halved) {
    constexpr int stencil = D == 2 ? 9 : 27;
    for (int parity = 0; parity < corners; ++parity)
      for (int s = 0; s < stencil; ++s)
        for (int ca = 0; ca < corners; ++ca)
          for (int cb = 0; cb < corners; ++cb) {
            const auto step = stencil_offset<D>(s);
            std::array<int, D> entry;
            float weight = 1;
            for (int c = 0; c < D; ++c) {
              // From the even node below a: places of a and of its neighbour b, and of one parent of each.
              const int a = parity >> c & 1, b = a + step[c], upper_a = ca >> c & 1, upper_b = cb >> c & 1;
              if (!halved[c]) {
                if (a || upper_a || upper_b) weight = 0;
                entry[c] = step[c];
                continue;
              }
              const bool odd_b = b & 1;
              if ((upper_a && !a) || (upper_b && !odd_b)) weight = 0;
              weight *= (a ? 0.5f : 1.0f) * (odd_b ? 0.5f : 1.0f);
              entry[c] = (b - odd_b) / 2 + upper_b - upper_a;
            }
            if (weight == 0) continue;
            of_parity_[parity].push_back(
                {static_cast<std::uint8_t>(s), static_cast<std::uint8_t>(ca), static_cast<std::uint8_t>(stencil_entry<D>(entry)), weight});
          }
  }

  /// Bit c of `parity`: the place is odd in direction c, in which the grid is halved.
  std::span<const GalerkinTerm> of(int parity) const { return of_parity_[parity]; }

 private:
  static constexpr int corners = 1 << D;
  std::array<std::vector<GalerkinTerm>, corners> of_parity_;
};

}  // namespace tern::fluid
