#pragma once
// What every step rebuilds from the state.

#include <array>
#include <tuple>
#include <vector>

#include "fluid/motion/motion.hpp"
#include "fluid/particle_class.hpp"
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
  double bulk_speed = 0;                        ///< largest at the begin of the window, spray left out [m/s]
};

/// Order of the particles by cell.
template <int D>
struct CellOrder {
  CellGrid<D> grid;
  CellContents contents;
  CellContents ghosts;                   ///< of particles of other ranks (domain.hpp)
  Vector<D> corner = Vector<D>::Zero();  ///< of the box of all particles, those of other ranks included, ...
  double extent = 0;                     ///< and its largest side in whole cells [m]
  /// Scratch, by the type of field.
  std::tuple<std::vector<Vector<D>>, std::vector<double>, std::vector<std::uint32_t>, std::vector<ParticleClass>> sorted;
};

template <int D>
struct Corrections {
  std::vector<Matrix<D>> matrix;  ///< C = (M - T)^-1, identity for spray
  std::vector<Matrix<D>> fluid;   ///< C^F = (M^F)^-1 over fluid neighbours alone; 0 where these are too few
  std::vector<double> trace;      ///< tr M / D in [0, 1]
};

/// Velocities as the sums over pairs read them.
template <int D>
struct PackedVelocities {
  std::vector<Motion<D>> motion;                        ///< r* and u* when they were last packed
  std::vector<std::array<Packed<D>, D>> half_gradient;  ///< half the velocity gradient, by column; zero where there is none
  std::vector<double> strain_rate;                      ///< sqrt(2 E:E), E = (L + L^T)/2: that of a shear du/dy is |du/dy| [1/s]
};

}  // namespace tern::fluid
