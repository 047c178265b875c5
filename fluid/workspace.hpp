#pragma once
// What every step rebuilds from the state.

#include <array>
#include <tuple>
#include <vector>

#include "fluid/lanes.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/row_grid.hpp"
#include "sph/cell_grid.hpp"

namespace tern::fluid {

/// The step that is computed [s].
struct Window {
  double begin = 0, duration = 0;
};

/// The particles on their way through a window.
template <int D>
struct Prediction {
  std::vector<Vector<D>> position;              ///< r*, at the middle of the window [m]
  std::vector<Vector<D>> velocity;              ///< u*, then u**, then u^{n+1} [m/s]
  std::vector<Vector<D>> gravity;               ///< at r* [m/s^2]
  std::vector<Vector<D>> unprojected_velocity;  ///< u* before the first coupling iteration; empty: not kept [m/s]
};

/// Order of the particles in rows.
template <int D>
struct RowOrder {
  RowGrid<D> grid;
  CellContents contents;
  // Of particles of other ranks, behind the own ones (domain.hpp): in rows of their own.
  RowGrid<D> ghost_grid;
  CellContents ghosts;
  Vector<D> corner = Vector<D>::Zero();  ///< of the box of all particles, those of other ranks included, ...
  double extent = 0;                     ///< and its largest side [m]
  /// Scratch, by the type of field.
  std::tuple<std::vector<Vector<D>>, std::vector<double>, std::vector<std::uint32_t>, std::vector<ParticleClass>> sorted;
};

template <int D>
struct Corrections {
  std::vector<Matrix<D>> matrix;  ///< C = (M - T)^-1, identity for spray
  std::vector<Matrix<D>> fluid;   ///< C^F = (M^F)^-1 over fluid neighbours alone; 0 where these are too few
  std::vector<double> trace;      ///< tr M / D in [0, 1]
};

/// A number of each particle for each pair of axes.
template <int D>
using ByPair = std::array<std::vector<double>, D*(D - 1) / 2>;

/// Velocities as the sums over pairs read them.
template <int D>
struct PackedVelocities {
  ByAxis<D> velocity;  ///< when it was last packed [m/s]
  // The gradient L, du_a/dx_b, in the parts that sums over pairs and the particle alone read; zero where there is none.
  ByAxis<D> half_stretch;             ///< [a]: L_aa / 2 [1/s]
  ByPair<D> shear;                    ///< of axes a < b: (L_ab + L_ba) / 2 [1/s]
  ByPair<D> spin;                     ///< of axes a < b: (L_ab - L_ba) / 2 [1/s]
  std::vector<double> strain_rate;    ///< sqrt(2 E:E), E = (L + L^T)/2: that of a shear du/dy is |du/dy|; without_gradient [1/s]
  std::vector<double> gradient_size;  ///< sqrt(L:L) [1/s]
  static constexpr double without_gradient = 1e200;  ///< of such a particle all motion counts as resolved, to less than rounding

  /// Calls visit(values...) with all arrays that sums over pairs read of the gradient.
  template <class Visit>
  void with_gradient(Visit&& visit) {
    const auto tie = [](auto&... values) { return std::tie(values...); };
    std::apply(visit, std::tuple_cat(std::apply(tie, half_stretch), std::apply(tie, shear), std::tie(strain_rate, gradient_size)));
  }
};

}  // namespace tern::fluid
